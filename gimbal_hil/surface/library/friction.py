"""Friction from logs, as an object: a table of estimates, the updated model, the figures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from gimbal_hil.data.preflight import preflight, questioned
from gimbal_hil.data.signals import ColumnMap, LogReading
from gimbal_hil.knowledge.identification import (
    AxisIdentification,
    Log,
    as_warm_as,
    axes_to_identify,
    identification_page,
    identify_axis,
    read_logs,
    updated_model,
)
from gimbal_hil.surface.library.picture import Picture
from gimbal_hil.surface.library.run import pandas_module
from gimbal_hil.surface.library.sources import Source, as_list, as_paths, model_of, plots_of
from sim_backend.model import AntennaModel

if TYPE_CHECKING:
    import pandas as pd

    from gimbal_hil.pages.report import Page


@dataclass(frozen=True)
class Friction:
    """The identified friction. `prior` is the model before the identification, `notes` what a reader must know of the
    logs.
    """

    axes: tuple[AxisIdentification, ...]
    prior: AntennaModel = field(repr=False)
    sources: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()

    def __str__(self) -> str:
        """A table for people: axis, parameter, value, 95 % interval, unit, how far the data determine it."""
        rows = [
            (
                r.axis,
                e.name,
                e.value_text,
                f"({e.interval_text})" if e.fitted_ends else "-",
                e.unit,
                e.verdict.value.replace("_", " "),
            )
            for r in self.axes
            for e in r.estimates
        ]
        widths = [max((len(row[column]) for row in rows), default=0) for column in range(6)]
        return "\n".join("  ".join(map(str.ljust, row, widths)).rstrip() for row in rows)

    def frame(self) -> pd.DataFrame:
        """One row for each parameter: axis, name, value, low, high (95 %), unit, verdict, reason."""
        rows = [
            (r.axis, e.name, e.value, e.interval.low, e.interval.high, e.unit, e.verdict.value, e.reason)
            for r in self.axes
            for e in r.estimates
        ]
        columns = ["axis", "name", "value", "low", "high", "unit", "verdict", "reason"]
        return pandas_module().DataFrame(rows, columns=columns)

    @cached_property
    def model(self) -> AntennaModel:
        """The prior with the identified numbers."""
        return updated_model(self.prior, list(self.axes))

    @cached_property
    def page(self) -> Page:
        """The report; `page.write(path)` puts it on disk."""
        return identification_page(self.prior, self.axes, self.sources)

    def figures(self) -> list[Picture]:
        """The figures of the report."""
        return [Picture.of(plot.figure, self.page.title) for plot in plots_of(self.page.blocks)]


def identify(
    logs: Source | Sequence[Source],
    model: str | Path | AntennaModel | None = None,
    *,
    axes: Sequence[str] | None = None,
    torque_driven: bool = False,
    resample: bool = False,
    drop_invalid: bool = False,
    columns: Mapping[str, str] | None = None,
    repair: bool = False,
) -> Friction:
    """Identify friction as `gimbal-hil identify` does; `model` is the prior and the rigid body, `columns` and `repair`
    as in `find_discrepancy`.
    """
    given = model_of(model)
    chosen = axes_to_identify(given, axes, "axes")
    reading = LogReading(ColumnMap(columns or {}), resample, None, drop_invalid, repair)
    read: list[Log] = []
    with as_paths(as_list(logs), "log") as paths:
        for path in paths:
            read += read_logs(path, given, reading, torque_driven=torque_driven)
        tables = questioned(given, tuple(log.table for log in read), reading.repair)
        preflight(given, tables)
    read = [replace(log, table=table) for log, table in zip(read, tables, strict=True)]
    # friction as it is where these logs were taken: a table over temperature is written by the command
    given = as_warm_as(given, read)
    results = tuple(identify_axis(read, given, axis) for axis in chosen)
    notes = tuple(f"{log.name}: {note}" for log in read for note in log.table.notes)
    return Friction(results, given, tuple(log.name for log in read), notes)
