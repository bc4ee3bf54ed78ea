"""What is seen in a file before anything is asked of it: channels, units, rate, span."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from gimbal_hil.data.containers.contents import Contents, SampledGroup
from gimbal_hil.data.containers.guessing import Found, command_line, guessed

#: more columns of a group are counted, not listed
_LISTED = 40


def survey(contents: Contents, axes: Sequence[str]) -> list[str]:
    """Lines for people: each group with rows, rate, span and its columns, then the `--column` that would read it."""
    lines = [contents.kind, *(f"  {note}" for note in contents.notes)]
    for group in contents.groups:
        lines += [f"  {_head(group)}", *(f"    {line}" for line in _columns(group))]
    words = guess(contents, axes)
    if words:
        lines.append(f"  to read it: {command_line(words)}")
    else:
        lines.append("  no column looks like a position or a torque; --column AXIS.position=COLUMN:UNIT names them")
    return lines


def guess(contents: Contents, axes: Sequence[str]) -> tuple[str, ...]:
    """Words for `--column` as far as names and units tell."""
    found = [Found(name, group.units.get(name, "")) for group in contents.groups for name in group.columns]
    once = list({one.column: one for one in found}.values())
    return guessed(once, axes)


def _head(group: SampledGroup) -> str:
    rows = len(next(iter(group.columns.values())))
    if group.time_s is None or rows < 2:
        return f"{group.name}: {rows} rows without times"
    span = float(group.time_s[-1] - group.time_s[0])
    rate = group.rate_hz
    return f"{group.name}: {rows} rows over {span:.4g} s" + (f", {rate:.5g} Hz" if rate else "")


def _columns(group: SampledGroup) -> Iterator[str]:
    for name, values in list(group.columns.items())[:_LISTED]:
        good = values[np.isfinite(values)]
        unit = f" [{group.units[name]}]" if name in group.units else ""
        spread = f"{good.min():.5g} to {good.max():.5g}" if len(good) else "no number"
        yield f"{name}{unit}: {spread}"
    if len(group.columns) > _LISTED:
        yield f"and {len(group.columns) - _LISTED} more"
