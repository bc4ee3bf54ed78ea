"""The version of the product, for its packages and for what builds them."""

__version__ = "0.2.0"
