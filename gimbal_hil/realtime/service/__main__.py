"""Entry point of the service process: `python -m gimbal_hil.realtime.service`, its orders on standard input."""

import os
import sys

from gimbal_hil.realtime.service.service import main


def _let_go() -> None:
    """Leave what a lost terminal does not take unsaid: a run that is whole must not end as a failure for it."""
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except OSError:
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


if __name__ == "__main__":
    code = main()
    _let_go()
    sys.exit(code)
