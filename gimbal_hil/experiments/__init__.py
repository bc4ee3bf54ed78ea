"""Experiments: what is asked of an antenna, the runner that follows it, and what comes out."""
