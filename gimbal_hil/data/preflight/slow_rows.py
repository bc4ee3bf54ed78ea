"""Rows so far apart that their times are in another unit than seconds: the first question to a log."""

from __future__ import annotations

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.preflight.stating import stated_unit
from gimbal_hil.data.signals import SignalsTable

#: slower logs hold nothing of what friction and joints do; a period in milliseconds looks like one
_LONGEST_PERIOD_S = 0.1
#: smaller units of time, s
_SMALLER = ((1e-3, "milliseconds", "ms"), (1e-6, "microseconds", "us"), (1e-9, "nanoseconds", "ns"))


def require_fast_rows(table: SignalsTable) -> None:
    """Raise BadInputError, with the unit that the times are likely in, where rows are too far apart for a log."""
    period = table.period_s
    if period <= _LONGEST_PERIOD_S:
        return
    usual = next((unit for unit in _SMALLER if unit[0] * period <= _LONGEST_PERIOD_S), _SMALLER[-1])
    what, option = usual[1], stated_unit(table, {"time_s": usual[2]})
    if period == 1.0:
        what, option = f"{what}, or the numbers of rows", "--rate HZ with the rows a second"
    expected = f"seconds, at most {_LONGEST_PERIOD_S:g} a row"
    raise BadInputError(
        f"{table.source or 'log'}: time_s",
        f"has a period of {period:.4g}, which is slow for seconds and usual for {what}",
        f"{expected}: {option}" if option else expected,
    )
