"""How this program starts another one of itself."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager

_SAFE_PATH = "PYTHONSAFEPATH"


@contextmanager
def apart_from_the_users_folder() -> Iterator[None]:
    """Interpreters that are started meanwhile have nothing of the folder in which the user stands on their path: a
    `queue.py` there would take the place of the standard library's.

    By the environment, because spawned processes and the tracker of their resources take no flags; and only for so
    long, because the environment of a user's own script or notebook is the user's.
    """
    before = os.environ.get(_SAFE_PATH)
    os.environ[_SAFE_PATH] = "1"
    try:
        yield
    finally:
        if before is None:
            del os.environ[_SAFE_PATH]
        else:
            os.environ[_SAFE_PATH] = before
