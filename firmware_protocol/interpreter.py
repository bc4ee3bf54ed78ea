"""How this program starts another one of itself."""

from __future__ import annotations

import sys

#: this interpreter, and nothing of the folder in which the user happens to stand on its path: a `queue.py` there would
#: take the place of the standard library's
INTERPRETER = (sys.executable, "-P")
