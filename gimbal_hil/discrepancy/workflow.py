"""The workflow from logs to a verdict: preflight, floors, null, search, the same with known numbers floating, classes, report."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from itertools import repeat

import numpy as np
from numpy.typing import NDArray

from gimbal_hil.discrepancy.completeness import COMPLETE_FLOORS
from gimbal_hil.discrepancy.deciding import decide, largest_left
from gimbal_hil.discrepancy.falling_floors import FallingFloors
from gimbal_hil.discrepancy.families import Family, families
from gimbal_hil.discrepancy.fit import Fit, refit
from gimbal_hil.discrepancy.floors import Floor, floors, over_own_noise, smaller, wide_twin
from gimbal_hil.discrepancy.hypothesis import Hypothesis, parameters_of
from gimbal_hil.discrepancy.processing import processing_floors
from gimbal_hil.discrepancy.record import record_of
from gimbal_hil.discrepancy.rivals import with_rivals
from gimbal_hil.discrepancy.row_noise import encoder_noise, other_readings, row_scales
from gimbal_hil.discrepancy.screening import Response, respond
from gimbal_hil.discrepancy.search import Round, Scored, Search, selectable
from gimbal_hil.discrepancy.smoothing import Floats
from gimbal_hil.discrepancy.twin import Twin
from gimbal_hil.discrepancy.valleys import polished
from gimbal_hil.executor import WorkExecutor, open_executor
from gimbal_hil.signals import SignalsTable
from sim_backend.effects import CATALOGUE
from sim_backend.model import AntennaModel

#: end of the scored band, Hz, at 1 kHz; slower logs score a smaller part
BAND_HZ = 25.0
#: and which part: the band's end times the sample period, with a gyro in the logs and without
_GYRO_SHARE, _ENCODER_SHARE = 0.05, 0.08
#: rows of the scored residual are correlated: what one row counts for in a prior's weight
_SPREAD = 2.0
#: a hypothesis is refined further while it leaves at most this many times what the best leaves beyond noise
_IN_THE_RACE = 5.0
#: a gap up to this many floors may be noise whose level changes
_NOISE_CHANGES = 2.0


@dataclass(frozen=True)
class Diagnosis:
    """Everything that a verdict, a model file and a report are made from."""

    model: AntennaModel
    search: Search
    null: Scored
    best: Scored
    #: refitted without causes where known numbers had to float
    floated: Scored | None
    floors: list[Floor]
    processing: Floats
    rounds: tuple[Round, ...]
    complete: bool
    #: nothing explains it all, and nothing stands above the noise that the same rows have beyond the band
    only_noise: bool
    #: rows of the hold-out that neither selected nor tuned anything
    untouched: NDArray[np.bool_]
    #: for every cause of `best`: what could stand in its place, best first
    rivals: tuple[tuple[Scored, ...], ...]
    suspected_only: bool
    has_gyro: tuple[bool, ...]


def scored_band(tables: tuple[SignalsTable, ...]) -> float:
    """End of the scored band for these logs, Hz."""
    # a gyro reads points of a rate that the held torque bends between samples; encoder positions are means and reach further
    gyro = any(table.signal(axis, "rate") is not None for table in tables for axis in table.axes)
    return min(BAND_HZ, (_GYRO_SHARE if gyro else _ENCODER_SHARE) / max(table.period_s for table in tables))


def diagnose(
    model: AntennaModel,
    measured: tuple[SignalsTable, ...],
    holdout: tuple[SignalsTable, ...],
    *,
    workers: int = 1,
    dask: str | None = None,
    suspected_only: bool = False,
    band_hz: float | None = None,
    progress: Callable[[str], None] = lambda text: None,
) -> Diagnosis:
    """Search for what the model lacks. The hold-out must be another trajectory; half of it selects, half is only ever looked at.

    `band_hz` ends the scored band in place of what `scored_band` chooses.
    """
    hz = band_hz or scored_band((*measured, *holdout))
    progress("smoothing the logs")
    twin = Twin(model, tuple(record_of(table, model, hz, f"measured {i}") for i, table in enumerate(measured)))
    held = Twin(model, tuple(record_of(table, model, hz, f"hold-out {i}") for i, table in enumerate(holdout)))
    twin.gyro_everywhere = held.gyro_everywhere = tuple(
        all(r.has_gyro[i] for r in (*twin.records, *held.records)) for i in range(len(model.axes))
    )
    progress("floors")
    wide = wide_twin(twin, measured)
    structure = twin.structure(())
    noise = floors(twin, wide, structure, structure.P)
    drawn, rms = encoder_noise(twin, measured), np.array([floor.rms for floor in noise])
    twin.scales, held.scales = row_scales(twin, drawn, rms), row_scales(held, encoder_noise(held, holdout), rms)
    noise = smaller(noise, floors(twin, wide, structure, structure.P))
    falling = FallingFloors(twin, wide, noise, processing_floors(twin, measured))
    catalogue = [family for axis in model.axes for family in families(model, axis, twin.records)]
    with open_executor(workers, dask) as executor:
        search = _search(twin, held, falling.effective(), catalogue, executor, progress)
        search.read_again = _readings(((twin, measured), (held, holdout)))
        story = decide(search, falling, np.sqrt(np.mean(np.concatenate(drawn), axis=0)))
        best, null = story.best, story.null
        if best.hypothesis.causes:
            best = polished(search, best)
        complete = search.complete(best, null)
        only_noise = not (complete and best.hypothesis.causes) and _only_noise(search, measured, holdout, null, falling.processing)
        rivals: tuple[tuple[Scored, ...], ...] = ()
        progress("what else could it be")
        if complete:
            best, rivals = with_rivals(search, best, null, story.rounds)
    return Diagnosis(
        model, search, null, best, story.floated, falling.noise, falling.processing, story.rounds, complete, only_noise,
        ~search.selecting, rivals, suspected_only, twin.gyro_everywhere,
    )  # fmt: skip


def _search(
    twin: Twin, held: Twin, floor: Floats, catalogue: list[Family], executor: WorkExecutor, progress: Callable[[str], None]
) -> Search:
    rows = [int(r.keep.sum()) for r in held.records]
    selecting = np.concatenate([np.arange(n) < n // 2 for n in rows])
    search = Search(
        twin, held, selectable(twin, held, selecting), floor, catalogue,
        lambda fit, fs: [], lambda hs, known: [], _SPREAD, selecting, progress,
    )  # fmt: skip
    search.exact = all(twin.model.number(axis, "friction.sigma0") > 0.0 for axis in twin.model.axes)

    there, gaps_there = executor.share(twin), executor.share(search.selectable)

    def listen(fit: Fit, chosen: list[Family]) -> list[Response]:
        # ripples and grids first: they take longest
        order = sorted(chosen, key=lambda f: -len(f.starts) * CATALOGUE[f.effect].fine_steps - (50 if f.ripple else 0))
        bare = replace(fit, jacobian=np.zeros((0, 0)))
        found = executor.map(respond, repeat(there), repeat(bare), repeat(search.floor), order)
        return [response for family in found for response in family]

    def refine(hypotheses: list[Hypothesis], known: Floats | None) -> list[Fit]:
        """One round for all, more for those that are still in the race."""
        if not hypotheses:
            return []

        def fitted(chosen: list[Hypothesis], rounds: int) -> list[Fit]:
            homes = [gaps_there if search.home(h) is search.selectable else there for h in chosen]
            floors = repeat(search.floor)
            return [search.cut(f) for f in executor.map(refit, homes, chosen, floors, repeat(rounds), repeat(known), repeat(_SPREAD))]

        fits = fitted(hypotheses, 1)
        size = fits[0].residual.size
        limit = _IN_THE_RACE * max(min(fit.cost for fit in fits) - size, 0.0) + 2.0 * size
        racing = [i for i, fit in enumerate(fits) if fit.cost <= limit]
        for i, fit in zip(racing, fitted([fits[i].hypothesis for i in racing], 4), strict=True):
            fits[i] = fit
        return fits

    search.listen, search.refine = listen, refine
    return search


def _readings(logs: tuple[tuple[Twin, tuple[SignalsTable, ...]], ...]) -> Callable[[Twin], tuple[Twin, ...]]:
    """Other readings of each twin's logs, made when they are first asked for."""

    @cache
    def made(which: int) -> tuple[Twin, ...]:
        return other_readings(*logs[which])

    return lambda twin: made(next(i for i, (one, _) in enumerate(logs) if one is twin))


def _only_noise(
    search: Search, measured: tuple[SignalsTable, ...], holdout: tuple[SignalsTable, ...], state: Scored, processing: Floats
) -> bool:
    """Whether what a state leaves is the noise of its own rows, whose level changes, or what the pipeline leaves of the model itself."""
    if largest_left(search, state) <= COMPLETE_FLOORS:
        return True
    if not search.exact:
        return bool(np.all(search.gaps(state) <= COMPLETE_FLOORS * np.hypot(1.0, processing / search.floor)))
    if largest_left(search, state) > _NOISE_CHANGES:
        return False
    at = parameters_of(search.twin, state.hypothesis)
    logs = ((search.twin, measured), (search.holdout, holdout))
    return all(over_own_noise(twin, tables, *at, search.floor) <= COMPLETE_FLOORS for twin, tables in logs)


def with_hold_out(
    measured: tuple[SignalsTable, ...], holdout: tuple[SignalsTable, ...]
) -> tuple[tuple[SignalsTable, ...], tuple[SignalsTable, ...], bool]:
    """Logs to fit and logs to judge on; without a hold-out the last, or (suspected only) the last third of the only one."""
    if holdout:
        return measured, holdout, False
    if len(measured) > 1:
        return measured[:-1], measured[-1:], False
    n = len(measured[0])
    first, last = measured[0].rows(0, 2 * n // 3), measured[0].rows(2 * n // 3, n)
    return (first,), (last,), True


__all__ = ["Diagnosis", "diagnose", "scored_band", "with_hold_out"]
