"""What is seen in a file before anything is asked of it: channels, units, rate, span."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

import numpy as np

from firmware_protocol.documents import LARGEST_NUMBER
from gimbal_hil.data.containers.contents import Contents, SampledGroup
from gimbal_hil.data.containers.guessing import Found, command_line, guessed

#: more columns of a group are counted, not listed
_LISTED = 40
#: whole numbers over a wider range may be counts
_COUNTS = 100.0
_IS_TIME = re.compile("time_s=").match
#: the name of a joint as messages of joint states have it; so many are listed
_JOINT, _NAMED = re.compile(r"position\[(.+)\]$"), 6


def survey(contents: Contents, words: Sequence[str], is_whole: bool) -> list[str]:
    """Lines for people: each group with rows, rate, span and its columns, then the `--column` of `words` that would
    read it, or all that names tell of one where it is not whole.
    """
    lines = [contents.kind, *(f"  {note}" for note in contents.notes)]
    for group in contents.groups:
        lines += [f"  {_head(group)}", *(f"    {line}" for line in _columns(group))]
    if is_whole:
        lines.append(f"  to read it: {command_line(words)}")
    elif words:
        lines.append(f"  names tell: {command_line(words)}; the rest is AXIS.position=COLUMN:UNIT, by name or number")
    else:
        lines.append("  no column looks like a position or a torque; --column AXIS.position=COLUMN:UNIT names them")
    if all(group.time_s is None for group in contents.groups) and not any(map(_IS_TIME, words)):
        lines.append("  its rows have no times that are known: --column time_s=COLUMN:UNIT names them, else --rate HZ")
        lines += [
            f"  column {name} rises evenly, as a time does; if so: --column time_s={name}:UNIT "
            "AXIS.position=COLUMN:UNIT AXIS.torque=COLUMN:UNIT, such as 1:ms, 2:deg, 3:mNm"
            for name in _clocks(contents)[:1]
        ]
    if len(joints := _joints(contents)) > 1:
        names = ", ".join(joints[:_NAMED]) + (" ..." if len(joints) > _NAMED else "")
        lines.append(
            f"  positions of {len(joints)} joints ({names}); where they are those of an arm: gimbal-hil joint "
            f"{contents.path} --urdf ARM.urdf --joint NAME takes out one"
        )
    return lines


def _joints(contents: Contents) -> list[str]:
    """Names of joints in brackets behind a position."""
    found = (_JOINT.search(name) for group in contents.groups for name in group.columns)
    return list(dict.fromkeys(one[1] for one in found if one is not None))


def guess(contents: Contents, axes: Sequence[str]) -> tuple[str, ...]:
    """Words for `--column` as far as names and units tell."""
    groups = contents.groups
    found = [
        Found.of(name, group.units.get(name, ""), group.columns[name]) for group in groups for name in group.columns
    ]
    once = list({one.column: one for one in found}.values())
    return guessed(once, axes)


def _clocks(contents: Contents) -> list[str]:
    """Columns that rise by steps of one size."""
    steps = {name: np.diff(values) for group in contents.groups for name, values in group.columns.items()}
    return [name for name, by in steps.items() if len(by) > 1 and by.min() > 0.0 and np.ptp(by) < 0.5 * np.median(by)]


def _head(group: SampledGroup) -> str:
    rows = len(next(iter(group.columns.values())))
    if group.time_s is None or rows < 2:
        return f"{group.name}: {rows} rows without times"
    span = float(group.time_s[-1] - group.time_s[0])
    rate = group.rate_hz
    return f"{group.name}: {rows} rows over {span:.4g} s" + (f", {rate:.5g} Hz" if rate else "")


def _columns(group: SampledGroup) -> Iterator[str]:
    for name, values in list(group.columns.items())[:_LISTED]:
        beyond = np.abs(values) > LARGEST_NUMBER
        good = values[np.isfinite(values) & ~beyond]
        unit = f" [{group.units[name]}]" if name in group.units else ""
        spread = f"{good.min():.5g} to {good.max():.5g}" if len(good) else "no number"
        if len(good) and np.ptp(good) > _COUNTS and np.all(good % 1.0 == 0.0):
            spread += ", whole numbers"
        if np.any(beyond):
            first = int(np.argmax(beyond))
            often = np.count_nonzero(beyond)
            spread += f"; holds {values[first]:g} in row {first + 1} ({often} such rows in all), which nobody measures"
        yield f"{name}{unit}: {spread}"
    if len(group.columns) > _LISTED:
        yield f"and {len(group.columns) - _LISTED} more"
