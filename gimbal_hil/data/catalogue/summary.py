"""What a run was, from its header and its log."""

from __future__ import annotations

from collections import Counter
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from firmware_protocol.errors import BadInputError, GimbalHilError
from gimbal_hil.data.runs import RUN_FILE, EventKind, RecordedRun, read_header
from gimbal_hil.data.signals import SignalsTable, unit_of

#: how deep below a folder runs are looked for
_DEPTH = 3


@dataclass(frozen=True)
class Summary:
    """A run in a line. `length_s` is antenna time and None while the log is not closed; `ending` is in words."""

    folder: Path
    title: str
    started_utc: str
    length_s: float | None
    ending: str
    exit_code: int | None
    axes: tuple[str, str]
    model: str

    def as_dict(self) -> dict[str, object]:
        """For JSON."""
        return asdict(self) | {"folder": str(self.folder), "axes": list(self.axes)}


@dataclass(frozen=True)
class Measure:
    """One figure of a run."""

    name: str
    value: float
    unit: str = ""


def find_runs(folder: Path) -> list[Path]:
    """Run folders in and below a folder, oldest first; BadInputError where there is no such folder."""
    if not folder.is_dir():
        raise BadInputError(str(folder), "is no folder", "a folder with run folders in it, or below")
    found = [folder] if (folder / RUN_FILE).exists() else []
    for depth in range(1, _DEPTH + 1):
        found += [path.parent for path in folder.glob("/".join(["*"] * depth + [RUN_FILE]))]
    return sorted(dict.fromkeys(found), key=lambda path: ((path / RUN_FILE).stat().st_mtime, path))


def summary_of(folder: Path) -> Summary:
    """The line of one run, from its header alone. One that cannot be read says so in `ending`."""
    try:
        record = read_header(folder)
    except GimbalHilError as error:
        return Summary(folder, "", "", None, f"cannot be read: {error}", None, ("", ""), "")
    end, header = record.end, record.header
    ticks = None if end is None else end.counts.get("ticks")
    return Summary(
        folder,
        header.title,
        record.started_utc,
        None if ticks is None else ticks * header.period_ns * record.every_ticks / 1e9,
        "goes on, or was killed" if end is None else end.reason or "done",
        None if end is None else end.exit_code,
        header.axes,
        str(header.model.get("name") or "not known"),
    )


def measures_of(run: RecordedRun, table: SignalsTable | None) -> list[Measure]:
    """Figures of a run: its ticks, and of every axis its travel, rate, torque and following error."""
    ticks = run.ticks
    faults = Counter(event.kind for event in run.events)
    found = [
        Measure("ticks", float(len(ticks))),
        Measure("ticks missed", float(ticks["skipped_ticks"].sum()) if len(ticks) else 0.0),
        Measure("frames rejected", float(ticks["rejected_frames"].sum()) if len(ticks) else 0.0),
        Measure("faults", float(faults[EventKind.FAULT])),
    ]
    if table is None:
        return found
    for axis in table.axes:
        position, torque = table.position(axis), table.commanded(axis)
        angle, effort = unit_of(f"{axis}.position"), unit_of(f"{axis}.torque")
        found += [
            Measure(f"{axis}: travel", float(np.ptp(position)), angle),
            Measure(f"{axis}: torque rms", float(np.sqrt(np.mean(torque**2))), effort),
            Measure(f"{axis}: torque at most", float(np.abs(torque).max()), effort),
        ]
        rate = table.signal(axis, "rate")
        if rate is not None:
            found.append(Measure(f"{axis}: rate at most", float(np.abs(rate).max()), unit_of(f"{axis}.rate")))
        reference = table.signal(axis, "position_ref")
        if reference is not None:
            error = float(np.sqrt(np.mean((reference - position) ** 2)))
            found.append(Measure(f"{axis}: following error rms", error, angle))
    return found
