"""Whether this machine's time of day is held against anything, and how far it may be off: what the kernel says of it.

NTP and PTP daemons steer the clock through `adjtimex` and tell the kernel how far it may be off; from then on the
kernel lets that bound grow by 500 parts in a million, until it is told again (adjtimex(2), ntp_adjtime; RFC 5905).
"""

from __future__ import annotations

import ctypes
from dataclasses import dataclass

#: what the bound grows by, s/s
GROWTH = 500e-6
_UNSYNCHRONISED, _ERROR = 0x0040, 5


class _Timex(ctypes.Structure):
    """`struct timex` of Linux as far as it is read; what follows is room."""

    _fields_ = (
        ("modes", ctypes.c_uint),
        ("offset", ctypes.c_long),
        ("freq", ctypes.c_long),
        ("maxerror", ctypes.c_long),
        ("esterror", ctypes.c_long),
        ("status", ctypes.c_int),
        ("rest", ctypes.c_byte * 400),
    )


@dataclass(frozen=True)
class ClockSync:
    """What the kernel says of the time of day: s. Nothing is known where `known` is false."""

    synchronised: bool
    error_bound_s: float
    known: bool = True

    @property
    def age_s(self) -> float:
        """How long ago, at most, the clock was last held against its source: all of the bound may have grown since."""
        return self.error_bound_s / GROWTH

    def in_words(self) -> str:
        """For people."""
        if not self.known:
            return "whether this machine's time of day is right is not known: its kernel does not say"
        if not self.synchronised:
            return "this machine's time of day is not synchronised (no NTP, PTP or GPS steers it)"
        return (
            f"this machine's time of day is synchronised: within {1e3 * self.error_bound_s:.3g} ms, last compared with "
            f"its source {self.age_s:.0f} s ago at most"
        )


def clock_sync() -> ClockSync:
    """The state of this machine's time of day; changes nothing and needs no privilege."""
    found = _Timex()
    try:
        state = ctypes.CDLL(None, use_errno=True).adjtimex(ctypes.byref(found))
    except (OSError, AttributeError):
        state = -1
    return clock_sync_of(state, found.status, found.maxerror)


def clock_sync_of(state: int, status: int, bound_us: int) -> ClockSync:
    """What `adjtimex` answered: its return value, `status` and `maxerror`."""
    if state < 0:
        return ClockSync(False, 0.0, known=False)
    return ClockSync(state != _ERROR and not status & _UNSYNCHRONISED, 1e-6 * bound_us)
