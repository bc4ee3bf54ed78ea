"""Entry point of the service process: `python -m gimbal_hil.realtime.service`, its orders on standard input."""

import sys

from gimbal_hil.realtime.service.service import main

if __name__ == "__main__":
    sys.exit(main())
