"""What the columns of a table of somebody else are likely to be, and how to say so."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from gimbal_hil.data.containers import Contents, Found, SampledGroup, guessed, time_among
from gimbal_hil.data.signals.column_map import ColumnMap
from gimbal_hil.data.signals.table import REQUIRED_SIGNALS, TIME
from gimbal_hil.data.tables import RawColumns

#: seconds in one of a unit of time -> the unit
_WORDS = {1.0: "", 1e-3: ":ms", 1e-6: ":us", 1e-9: ":ns"}

#: names of seconds and of the rest of a time, and what the rest is in
_IN_PARTS = (
    ("sec", "nanosec", "ns"),
    ("secs", "nsecs", "ns"),
    ("sec", "nsec", "ns"),
    ("tv_sec", "tv_nsec", "ns"),
    ("tv_sec", "tv_usec", "us"),
    ("sec", "usec", "us"),
    ("secs", "usecs", "us"),
    ("sec", "msec", "ms"),
)


def guessed_words(raw: RawColumns, axes: Sequence[str]) -> tuple[str, ...]:
    """Words for `--column`: time, position and torque (else current) of each axis, as far as names and units tell."""
    columns = [Found.of(name, raw.units.get(name, ""), values) for name, values in raw.values.items()]
    words = guessed(columns, axes)
    return (*_time_word(raw), *words) if words else ()


def contents_of_table(raw: RawColumns) -> Contents:
    """The same file as one group of columns, for whoever looks at it first."""
    words = _time_word(raw)
    time_s = None
    if words:
        called = ColumnMap.of_words(words).read(replace(raw, notes=()), (), False)
        time_s = called.values[TIME] - np.nanmin(called.values[TIME])
    units = {name: unit for name, unit in raw.units.items() if unit not in name}
    return Contents(raw.path, "table", (SampledGroup("rows", time_s, raw.values, units),), raw.notes)


def is_read_by(words: Sequence[str], axes: Sequence[str]) -> bool:
    """Whether words for `--column` name all that a signals table of these axes has to have."""
    names = {word.partition("=")[0].replace(".current", ".torque") for word in words}
    return names >= {TIME, *(f"{axis}.{signal}" for axis in axes for signal in REQUIRED_SIGNALS)}


def _time_word(raw: RawColumns) -> tuple[str, ...]:
    parts = {name.rpartition(".")[2].lower(): name for name in raw.values}
    for seconds, rest, part in _IN_PARTS:
        if seconds in parts and rest in parts:
            return (f"{TIME}={parts[seconds]}+{parts[rest]}:{part}",)
    time, unit = _time(raw)
    if time is None:
        return ()
    return (f"{TIME}={time}" if time in raw.units else f"{TIME}={time}{_WORDS[unit]}",)


def _time(raw: RawColumns) -> tuple[str | None, float]:
    """The column that is the time, and seconds in one of its units."""
    return time_among({name: values for name, values in raw.values.items() if np.isfinite(values).any()})
