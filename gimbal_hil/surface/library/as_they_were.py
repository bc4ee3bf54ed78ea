"""Logs of other people as they were before they smoothed them, and the band in which a search can use them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from gimbal_hil.data.runs import is_run_folder
from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.discrepancy import band_within
from gimbal_hil.knowledge.identification import unsmoothed
from sim_backend.model import AntennaModel


def as_they_were(
    model: AntennaModel, tables: Sequence[SignalsTable], paths: Sequence[Path], band_hz: float | None
) -> tuple[tuple[SignalsTable, ...], float | None]:
    """Tables read from `paths`, with a smoothing of their columns taken back, which notes tell; and the end of the
    scored band, Hz: up to where half of them was left, unless one was asked for.

    Run folders are as they were recorded.
    """
    foreign = [place for place, path in enumerate(paths) if not is_run_folder(path)]
    found = unsmoothed(model, [tables[place] for place in foreign])
    freed = dict(zip(foreign, found.tables, strict=True))
    if found.to_hz is not None and band_hz is None:
        band_hz = band_within(found.tables, found.to_hz)
    return tuple(freed.get(place, table) for place, table in enumerate(tables)), band_hz
