"""Containers of others, written by the libraries that own them."""
