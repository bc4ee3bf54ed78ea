"""The wire: every message, its bytes, and the links that carry them."""
