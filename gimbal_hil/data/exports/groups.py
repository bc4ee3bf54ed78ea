"""What a run holds, as groups of channels that share their times: the one place where exported signals get their names.

`azimuth.position` is the signal of the signals table, `feedback_azimuth.position` the field of a frame,
`host.torque_azimuth` the column of a tick row, in every format.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime
from enum import IntEnum, IntFlag
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.errors import BadInputError
from firmware_protocol.json_object import Json
from gimbal_hil.data.runs import TICK_ROW, RecordedRun, columns_of, require_frames, stored_name
from gimbal_hil.data.signals import SignalsTable, unit_of
from gimbal_hil.loop.control import Mode
from gimbal_hil.loop.host import HostState, LinkStatus
from gimbal_hil.loop.timing import MISS_CODE

#: told how far an export is: steps done, of how many
Progress = Callable[[int, int], None]
PROGRESS_ROWS = 4096
HOST = "host"
_NOT_SHOWN = ("time_ns", "check")
#: columns of a tick row that are measures: what their names begin with, unit
_TICK_UNITS = (
    ("position_ref_", "rad"),
    ("rate_ref_", "rad/s"),
    ("torque_", "N m"),
    ("wake_latency_ns", "ns"),
    ("computing_ns", "ns"),
)


@dataclass(frozen=True)
class ExportedSignal:
    """One signal of a group: values (n,), its unit, and names of its values where they are an enumeration."""

    name: str
    values: NDArray[np.generic]
    unit: str = ""
    #: value -> name; empty for numbers
    labels: dict[int, str] | None = None
    #: whether the names are all that there can be
    closed: bool = True

    def named(self) -> list[Any]:
        """The values as plain objects: names for enumerations, None where a number is none."""
        if self.labels is not None:
            return [self.labels[value] for value in self.values.tolist()]
        if self.values.dtype.kind != "f":
            return list(self.values.tolist())
        return [value if np.isfinite(value) else None for value in self.values.tolist()]


@dataclass(frozen=True)
class Group:
    """Channels that were sampled together, at nanoseconds (n,) since the run's first tick."""

    name: str
    time_ns: NDArray[np.int64]
    channels: tuple[ExportedSignal, ...]


def groups_of(run: RecordedRun, table: SignalsTable | None) -> tuple[Group, ...]:
    """Signals by axis (where the run makes a table), good frames by message, and the host's ticks."""
    axes, period_ns = run.record.header.axes, run.record.header.period_ns
    groups = [] if table is None else _of_table(run, table)
    for message in run.protocol.messages:
        columns = columns_of(frames_of(run), message.name, run.protocol)
        if not len(columns.place):
            continue
        channels = tuple(
            ExportedSignal(stored_name(field.name, axes), columns.physical(field.name), field.unit)
            if field.is_physical
            else _counted(stored_name(field.name, axes), columns.raw[field.name], field.enum)
            for field in message.fields
        )
        groups.append(Group(stored_name(message.name, axes), columns.tick * period_ns, channels))
    return (*groups, _of_ticks(run))


def table_times_ns(run: RecordedRun, table: SignalsTable) -> NDArray[np.int64]:
    """Nanoseconds (n,) from the run's first tick to each row of its table."""
    first = columns_of(run.frames, "drive_status", run.protocol).tick[:1]
    begin_ns = int(first[0]) * run.record.header.period_ns if len(first) else 0
    return begin_ns + np.round(table.time_s * 1e9).astype(np.int64)


def _of_table(run: RecordedRun, table: SignalsTable) -> list[Group]:
    """The signals table by what stands before the dot, at the times of its own grid."""
    time_ns = table_times_ns(run, table)
    found: dict[str, list[ExportedSignal]] = {}
    for column, values in table.columns.items():
        group, _, name = column.rpartition(".")
        found.setdefault(group, []).append(ExportedSignal(name, values, unit_of(column)))
    return [Group(name, time_ns, tuple(channels)) for name, channels in found.items()]


def _of_ticks(run: RecordedRun) -> Group:
    axes = run.record.header.axes
    enumerations: Json = {
        "host_state": HostState,
        "link_status": LinkStatus,
        "mode_outer": Mode,
        "mode_inner": Mode,
    }
    channels = []
    for column in TICK_ROW.names or ():
        values, name = np.ascontiguousarray(run.ticks[column]), stored_name(column, axes)
        if column in _NOT_SHOWN:
            continue
        if column == "miss_cause":
            causes = {code: cause.value for cause, code in MISS_CODE.items()} | {0: "none"}
            channels.append(ExportedSignal(name, values, labels=_with_strangers(causes, values)))
        elif column in enumerations:
            channels.append(_counted(name, values, enumerations[column]))
        else:
            unit = next((unit for start, unit in _TICK_UNITS if column.startswith(start)), "")
            channels.append(ExportedSignal(name, values, unit))
    return Group(HOST, run.ticks["time_ns"].astype(np.int64), tuple(channels))


def _counted(name: str, values: NDArray[np.generic], kind: type[IntEnum] | type[IntFlag] | None) -> ExportedSignal:
    """A count, or an enumeration with the names of its values."""
    if kind is None:
        return ExportedSignal(name, values)
    if issubclass(kind, IntFlag):
        labels = {
            value: "|".join(flag.name.lower() for flag in kind if flag & value and flag.name) or "none"
            for value in np.unique(values).tolist()
        }
        return ExportedSignal(name, values, labels=labels, closed=False)
    return ExportedSignal(name, values, labels=_with_strangers({int(one): one.name.lower() for one in kind}, values))


def _with_strangers(labels: dict[int, str], values: NDArray[np.generic]) -> dict[int, str]:
    """A value that has no name is its number."""
    return {value: str(value) for value in np.unique(values).tolist()} | labels


def frames_of(run: RecordedRun) -> np.ndarray:
    """Frame rows; BadInputError where the run keeps none."""
    require_frames(run)
    return run.frames


def start_ns(run: RecordedRun) -> int:
    """Time of day of tick 0 in nanoseconds since 1970, as far as the run knows it."""
    try:
        start = datetime.fromisoformat(run.record.started_utc)
    except ValueError:
        where = f"{run.folder / 'run.yaml'}: when.started_utc"
        raise BadInputError(
            where, f"is {run.record.started_utc!r}", "a time such as 2026-01-31T12:00:00.000+00:00"
        ) from None
    return round(start.timestamp() * 1000) * 1_000_000


def missing_extra(kind: str, package: str, extra: str = "") -> BadInputError:
    """That the package for a format is not there; its extra is called like the format unless it is given."""
    extra = extra or kind
    return BadInputError(
        f"--format {kind}",
        f"needs the package {package}, which is not installed",
        f"pip install 'gimbal-hil[{extra}]'",
    )
