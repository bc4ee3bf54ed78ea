"""What changed between two sets of logs, as an object: the verdict, the causes, the page."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from firmware_protocol.errors import BadInputError
from firmware_protocol.json_object import Json
from gimbal_hil.data.preflight import preflight, questioned
from gimbal_hil.data.signals import ColumnMap, LogReading, read_together
from gimbal_hil.knowledge.change import ChangeKind, MachineComparison, change_page, compare, document_of
from gimbal_hil.knowledge.discrepancy import check_logs
from gimbal_hil.surface.library.as_they_were import as_they_were
from gimbal_hil.surface.library.search_scope import SearchScope
from gimbal_hil.surface.library.sources import Source, as_list, as_paths, model_of
from sim_backend.model import AntennaModel

if TYPE_CHECKING:
    from gimbal_hil.pages.report import Page


@dataclass(frozen=True)
class Changes:
    """The answer of a comparison. `document` is what `changed.json` holds (docs/reference/changed.md)."""

    document: Json
    comparison: MachineComparison = field(repr=False)

    @property
    def kind(self) -> ChangeKind:
        """changed, ambiguous, no_change or cannot_judge."""
        return self.comparison.kind

    @property
    def effects(self) -> tuple[Json, ...]:
        """What changed: name, axis, parameters after with intervals and with the number before."""
        return tuple(self.document["effects"])

    @property
    def model(self) -> AntennaModel:
        """The model of the machine before: the one that was given, fitted to the logs before."""
        return self.comparison.model

    @cached_property
    def page(self) -> Page:
        """The report; `page.write(path)` puts it on disk."""
        return change_page(self.comparison)


def changes_between(
    model: AntennaModel,
    before: Sequence[Path],
    after: Sequence[Path],
    reading: LogReading,
    scope: SearchScope,
    *,
    workers: int = 1,
    progress: Callable[[str], None] = lambda text: None,
) -> Changes:
    """Read logs and compare them. BadInputError for logs that cannot answer."""
    both = {path.resolve() for path in before} & {path.resolve() for path in after}
    if both:
        raise BadInputError(str(sorted(both)[0]), "is before and after", "other logs on each side")
    progress("reading logs")
    tables = questioned(model, read_together([*before, *after], model, reading), reading.repair)
    check_logs(model, tables, scope.band_hz)
    preflight(model, tables)
    sides = [
        as_they_were(model, some, paths, scope.band_hz)
        for some, paths in ((tables[: len(before)], before), (tables[len(before) :], after))
    ]
    tables = tuple(table for side, _ in sides for table in side)
    band_hz = min((end_hz for _, end_hz in sides if end_hz is not None), default=None)
    tables = tuple(replace(table, source=str(path)) for table, path in zip(tables, [*before, *after], strict=True))
    found = compare(
        model,
        tables[: len(before)],
        tables[len(before) :],
        band_hz=band_hz,
        only=scope.only,
        without=scope.without,
        workers=workers,
        progress=progress,
    )
    notes = [f"{table.source}: {note}" for table in tables for note in table.notes]
    return Changes({**document_of(found), "notes": notes}, found)


def find_changes(
    before: Source | Sequence[Source],
    after: Source | Sequence[Source],
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
) -> Changes:
    """Compare as `gimbal-hil changed` does: which numbers or effects of the machine in `after` are not those of the one
    in `before`. `columns` and `repair` as in `find_discrepancy`.
    """
    first, second = as_list(before), as_list(after)
    with as_paths([*first, *second], "log") as paths:
        return changes_between(
            model_of(model),
            paths[: len(first)],
            paths[len(first) :],
            LogReading(ColumnMap(columns or {}), resample, None, drop_invalid, repair),
            SearchScope(tuple(only), tuple(without), band_hz),
            workers=workers,
        )
