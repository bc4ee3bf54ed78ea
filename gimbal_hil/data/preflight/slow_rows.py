"""Rows so far apart that their times are in another unit than seconds: the first question to a log."""

from __future__ import annotations

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.preflight.stating import stated_unit
from gimbal_hil.data.signals import LONGEST_PERIOD_S, SignalsTable, smaller_unit


def require_fast_rows(table: SignalsTable) -> None:
    """Raise BadInputError, with the unit that the times are likely in, where rows are too far apart for a log."""
    period = table.period_s
    usual = smaller_unit(period)
    if usual is None:
        return
    what, option = usual[0], stated_unit(table, {"time_s": usual[1]})
    if period == 1.0:
        what, option = f"{what}, or the numbers of rows", "--rate HZ with the rows a second"
    expected = f"seconds, at most {LONGEST_PERIOD_S:g} a row"
    raise BadInputError(
        f"{table.source or 'log'}: time_s",
        f"has a period of {period:.4g}, which is slow for seconds and usual for {what}",
        f"{expected}: {option}" if option else expected,
    )
