"""Adapters: how other people's methods take part. Each is run as a process of its own, `python -m ... CASE ANSWER`."""
