"""A run folder as an object: signals as a DataFrame with units, events, figures, the proof by replay."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

from firmware_protocol.errors import BadInputError
from firmware_protocol.json_object import Json
from gimbal_hil.data.runs import RecordedRun as Log
from gimbal_hil.data.runs import open_run
from gimbal_hil.data.signals import SignalsTable, signals_of_run, unit_of, units_of
from gimbal_hil.surface.library.picture import Picture

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class Run:
    """A recorded run. The folder is read when it is first used; BadInputError says what is wrong with it."""

    folder: Path

    def __init__(self, folder: str | Path) -> None:
        object.__setattr__(self, "folder", Path(folder))

    @cached_property
    def log(self) -> Log:
        """Everything that was recorded: ticks, frames, events, header."""
        return open_run(self.folder)

    @property
    def axes(self) -> tuple[str, str]:
        """Names of the axes, the carrying one first."""
        return self.log.record.header.axes

    @property
    def configuration(self) -> Json:
        """The configuration of the daemon or experiment, as in its file."""
        return dict(self.log.record.header.configuration)

    def table(self, *, resample: bool = False, drop_invalid: bool = False) -> SignalsTable:
        """The signals table (docs/reference/signals-table.md): what `identify` and `find_discrepancy` read."""
        return signals_of_run(self.log, resample=resample, drop_invalid=drop_invalid)

    def frame(self, *, resample: bool = False, drop_invalid: bool = False) -> pd.DataFrame:
        """The same as a DataFrame over `time_s`; `frame.attrs["units"]` has the unit of every column."""
        table = self.table(resample=resample, drop_invalid=drop_invalid)
        columns = dict(table.columns) | ({} if table.repeat is None else {"repeat": table.repeat})
        frame = pandas_module().DataFrame(columns, index=pandas_module().Index(table.time_s, name="time_s"))
        frame.attrs["units"] = dict(units_of(["time_s", *columns]))
        frame.attrs["notes"] = list(table.notes)
        return frame

    def events(self) -> pd.DataFrame:
        """State changes, faults, operator commands and steps of experiments: tick, time_s, kind, text."""
        rows = [(event.tick, event.time_ns * 1e-9, event.kind.value, event.text) for event in self.log.events]
        return pandas_module().DataFrame(rows, columns=["tick", "time_s", "kind", "text"])

    def figure(self, *columns: str) -> Picture:
        """Signals over time, a panel for each unit; all positions without names. Columns as in `frame`."""
        from gimbal_hil.pages.plots import stacked, thinned

        table = self.table()
        names = columns or tuple(name for name in table.columns if name.endswith(".position"))
        for name in names:
            if name not in table.columns:
                raise BadInputError(str(self.folder), f"has no signal {name!r}", ", ".join(table.columns))
        units = list(dict.fromkeys(unit_of(name) for name in names))
        drawn = stacked([""] * len(units), "time [s]", [f"[{unit}]" for unit in units])
        part = thinned(len(table))
        for name in names:
            row = units.index(unit_of(name)) + 1
            drawn.add_scatter(x=table.time_s[part], y=table.columns[name][part], name=name, row=row)
        return Picture.of(drawn, f"Run {self.folder.name}")

    def replays(self) -> bool:
        """Whether the host, run again on the recorded frames, gives the same bits."""
        from gimbal_hil.data.runs import replay
        from gimbal_hil.realtime.lockstep import give_again, host_of

        host = host_of(self.log)
        return replay(self.log, host, lambda event: give_again(host, self.log, event)).identical


def pandas_module() -> ModuleType:
    try:
        import pandas
    except ImportError:
        raise BadInputError(
            "frame()", "needs the package pandas, which is not installed", "pip install 'gimbal-hil[pandas]'"
        ) from None
    return pandas
