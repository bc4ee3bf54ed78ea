"""Hostile input: everything that reads what others wrote may refuse it, but with the project's own error and nothing
else.
"""
