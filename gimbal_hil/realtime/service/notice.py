"""What systemd is told: that ticks run (ready), and again and again that they still do (watchdog).

Sent by the service process when ticks have come, so that a control process that hangs is started anew; the loop itself
does nothing for it. The protocol is sd_notify(3): a datagram to the socket in $NOTIFY_SOCKET.
"""

from __future__ import annotations

import contextlib
import os
import socket
import time
from collections.abc import Callable, Mapping

#: a share of the watchdog's time between two words
_SHARE = 3.0


class Notice:
    """Speaks to systemd; says nothing where nobody listens."""

    def __init__(
        self, environment: Mapping[str, str] = os.environ, clock_s: Callable[[], float] = time.monotonic
    ) -> None:
        self._address = environment.get("NOTIFY_SOCKET", "")
        period_us = environment.get("WATCHDOG_USEC", "")
        self._every_s = int(period_us) / 1e6 / _SHARE if period_us.isdigit() else None
        self._clock_s, self._said_s = clock_s, -1e9
        self._ready = False

    def ticks_came(self) -> None:
        """Ticks have run since the last call."""
        if not self._address:
            return
        if not self._ready:
            self._ready = True
            self._send("READY=1\nSTATUS=ticks run")
        now_s = self._clock_s()
        if self._every_s is not None and now_s - self._said_s >= self._every_s:
            self._said_s = now_s
            self._send("WATCHDOG=1")

    def _send(self, text: str) -> None:
        # a leading @ is the abstract name space
        address = "\0" + self._address[1:] if self._address.startswith("@") else self._address
        with contextlib.suppress(OSError), socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as speaker:
            speaker.setblocking(False)
            speaker.sendto(text.encode(), address)
