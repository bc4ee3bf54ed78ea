"""The wire: every message, its bytes, and the links that carry them.

What other packages may import is these modules and the folders `links`, `emit` and `adapters`. They are not imported
here, because half of them need numba and the other half serves commands that must answer at once.
"""

__all__ = [
    "block_codec",
    "bus_load",
    "codec",
    "compiling",
    "elementary",
    "enumerations",
    "errors",
    "interpreter",
    "json_object",
    "kernel_cache",
    "layout",
    "lockstep",
    "mail",
    "messages",
    "object_code",
    "opening",
    "places",
    "protocol_versions",
    "receiver",
    "records",
    "schema",
    "stream",
    "version",
    "words",
]
