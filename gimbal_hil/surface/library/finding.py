"""What a model lacks, as an object: the verdict, the corrected model, the figures."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from firmware_protocol.json_object import Json
from gimbal_hil.data.preflight import preflight, questioned
from gimbal_hil.data.signals import ColumnMap, LogReading, SignalsTable, read_together
from gimbal_hil.knowledge.discrepancy import (
    Kind,
    Request,
    Result,
    Verdict,
    attributed,
    check_logs,
    corrected_model,
    diagnose,
    discrepancy_page,
    ramps_apart,
    recalibrated_model,
    verdict_of,
    with_torque_times,
)
from gimbal_hil.surface.library.as_they_were import as_they_were
from gimbal_hil.surface.library.picture import Picture
from gimbal_hil.surface.library.search_scope import SearchScope
from gimbal_hil.surface.library.sources import Source, as_list, as_paths, model_of, plots_of
from sim_backend.model import AntennaModel

if TYPE_CHECKING:
    from gimbal_hil.pages.report import Page

_AS_IT_IS, _EVERYTHING = LogReading(), SearchScope()


@dataclass(frozen=True)
class Finding:
    """The result of a search. `verdict.document` is what `verdict.json` holds (docs/reference/verdict.md)."""

    verdict: Verdict
    result: Result = field(repr=False)
    sources: tuple[str, ...] = ()

    @property
    def kind(self) -> Kind:
        """named, ambiguous, unexplained or no_discrepancy."""
        return self.verdict.kind

    @property
    def effects(self) -> tuple[Json, ...]:
        """The causes, named or ambiguous: name, axis, parameters with intervals, gain on held-out data."""
        return self.verdict.effects

    @cached_property
    def model(self) -> AntennaModel | None:
        """The model with the named causes; None if nothing was named."""
        corrected = corrected_model(self.result)
        return None if corrected is None else attributed(self.result.model, corrected, self.verdict)

    @cached_property
    def recalibrated(self) -> AntennaModel | None:
        """The model with known numbers refitted within their uncertainty, if nothing was named."""
        moved = self.model is None and bool(self.verdict.recalibrated)
        return attributed(self.result.model, recalibrated_model(self.result), self.verdict) if moved else None

    @cached_property
    def page(self) -> Page:
        """The report; `page.write(path)` puts it on disk."""
        return discrepancy_page(self.result, self.verdict, self.model, list(self.sources))

    def figures(self) -> list[Picture]:
        """The figures of the report."""
        return [Picture.of(plot.figure, self.page.title) for plot in plots_of(self.page.blocks)]


@dataclass(frozen=True)
class Question:
    """Logs that were accepted, sorted by use, and the model that they are held against."""

    request: Request
    #: slow ramps: they only contradict
    ramps: tuple[SignalsTable, ...]
    notes: tuple[str, ...]
    sources: tuple[str, ...]
    #: axes of which somebody said when the torque of a row was in force
    time_stated: frozenset[str] = frozenset()

    def asked(
        self, *, workers: int = 1, dask: str | None = None, progress: Callable[[str], None] = lambda text: None
    ) -> Finding:
        """The search itself."""
        result = diagnose(self.request, workers=workers, dask=dask, progress=progress)
        judged = (*self.request.measured, *self.request.holdout)
        verdict = verdict_of(result, (*judged, *self.ramps), self.notes)
        progress("when the torque of the logs was in force")
        told = with_torque_times(verdict, result, judged, self.time_stated)
        return Finding(told, result, self.sources)


def question_of(
    model: AntennaModel,
    measured: Sequence[Path],
    holdout: Sequence[Path],
    reading: LogReading = _AS_IT_IS,
    scope: SearchScope = _EVERYTHING,
) -> Question:
    """Read logs and say what is asked of them. BadInputError for logs that cannot answer, or that fit the model only if
    they are read otherwise.
    """
    paths, band_hz = [*measured, *holdout], scope.band_hz
    tables = questioned(model, read_together(paths, model, reading), reading.repair)
    check_logs(model, tables, band_hz)
    preflight(model, tables)
    tables, band_hz = as_they_were(model, tables, paths, band_hz)
    fitted, ramps, notes = ramps_apart(model, tables[: len(measured)])
    judged = tables[len(measured) :]
    own = (f"{table.source}: {note}" for table in (*fitted, *judged, *ramps) for note in table.notes)
    request = Request(model, fitted, judged, band_hz, scope.only, scope.without)
    stated = frozenset(
        axis
        for axis in model.axes
        if reading.columns.states_time_of(axis) or any(f"{axis}.torque_sampled" in table.columns for table in tables)
    )
    return Question(request, ramps, (*notes, *own), tuple(str(path) for path in paths), stated)


def find_discrepancy(
    measured: Source | Sequence[Source],
    holdout: Source | Sequence[Source] = (),
    model: str | Path | AntennaModel | None = None,
    *,
    only: Sequence[str] = (),
    without: Sequence[str] = (),
    band_hz: float | None = None,
    resample: bool = False,
    drop_invalid: bool = False,
    columns: Mapping[str, str] | None = None,
    repair: bool = False,
    workers: int = 1,
) -> Finding:
    """Search as `gimbal-hil discrepancy` does: in `measured`, judged on `holdout`, another trajectory.

    `columns` says what tables of your own call theirs, and their units: `{"joint.position": "theta:deg"}`. `repair`
    makes up a few rows that no joint can make, and a note of the verdict says which.
    """
    given = model_of(model)
    searched, judged = as_list(measured), as_list(holdout)
    reading = LogReading(ColumnMap(columns or {}), resample, None, drop_invalid, repair)
    scope = SearchScope(tuple(only), tuple(without), band_hz)
    with as_paths([*searched, *judged], "log") as paths:
        question = question_of(given, paths[: len(searched)], paths[len(searched) :], reading, scope)
    return question.asked(workers=workers)
