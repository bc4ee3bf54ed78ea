"""The workflow from logs to a verdict: preflight, floors, null, search, the same with known numbers floating, classes, report."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import repeat

import numpy as np
from numpy.typing import NDArray

from gimbal_hil.discrepancy.families import Family, families
from gimbal_hil.discrepancy.fit import Fit, refit
from gimbal_hil.discrepancy.floors import Floor, floors, over_own_noise, smaller, wide_twin
from gimbal_hil.discrepancy.hypothesis import FAR, Cause, Hypothesis, known_numbers, known_offsets, parameters_of
from gimbal_hil.discrepancy.processing import processing_floors
from gimbal_hil.discrepancy.record import TORQUE, record_of
from gimbal_hil.discrepancy.rivals import compare, with_rivals
from gimbal_hil.discrepancy.row_noise import encoder_noise, row_scales
from gimbal_hil.discrepancy.screening import Response, respond
from gimbal_hil.discrepancy.search import CALM_FLOORS, COMPLETE_FLOORS, Round, Scored, Search, selectable
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
#: a model's numbers are trusted to this share once they have to float
TRUST = 0.08
#: how exactly a twin can follow another integrator: share of the Coulomb level
_EXACTNESS = 0.0012
#: rows of the scored residual are correlated: what one row counts for in a prior's weight
_SPREAD = 2.0
#: gap, in floors, below which nothing is searched for
_QUIET = 1.3
#: a hypothesis is refined further while it leaves at most this many times what the best leaves beyond noise
_IN_THE_RACE = 5.0
#: a gap up to this many floors may be noise whose level changes
_NOISE_CHANGES = 2.0
#: causes that are looked for before the known numbers float
_FEW = 2
#: a torque floor this far above the encoder's noise may hide a cause; it does when a candidate brings it below this share of itself
_ABOVE_ENCODER, _HIDDEN = 3.0, 0.5
#: floors that fell below this share of what they were are worth another search
_FALLEN = 0.8
#: what known numbers that are off leave, as a share of what causes beside the model as it stands do, to be the better story
_CLEARLY_LESS = 0.5
#: share of the gap that they must have closed for more to be looked for
_PROMISING = 0.7


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
    wide.gyro_everywhere = twin.gyro_everywhere
    structure = twin.structure(())
    found = floors(twin, wide, structure, structure.P)
    noise = np.array([f.rms for f in found])
    drawn = encoder_noise(twin, measured)
    twin.scales, held.scales = row_scales(twin, drawn, noise), row_scales(held, encoder_noise(held, holdout), noise)
    found = smaller(found, floors(twin, wide, structure, structure.P))
    processing = processing_floors(twin, measured)
    catalogue = [family for axis in model.axes for family in families(model, axis, twin.records)]
    with open_executor(workers, dask) as executor:
        search = _search(twin, held, effective_floors(model, twin, found, processing), catalogue, executor, progress)
        encoder = np.sqrt(np.mean(np.concatenate(drawn), axis=0))
        result = _decide(search, wide, found, model, processing, encoder)
        best, null, floated, rounds, found = result
        if best.hypothesis.causes:
            best = polished(search, best)
        complete = search.complete(best, null)
        named = complete and bool(best.hypothesis.causes)
        only_noise = not named and _only_noise(search, measured, holdout, null, processing)
        rivals: tuple[tuple[Scored, ...], ...] = ()
        progress("what else could it be")
        if complete:
            best, rivals = with_rivals(search, best, null, rounds)
    return Diagnosis(
        model, search, null, best, floated, found, processing, tuple(rounds), complete, only_noise, ~search.selecting, rivals,
        suspected_only, twin.gyro_everywhere,
    )  # fmt: skip


def effective_floors(model: AntennaModel, twin: Twin, found: list[Floor], processing: Floats) -> Floats:
    """Noise and what no twin can follow, per channel."""
    out = []
    for floor, channel, process in zip(found, twin.channels, processing, strict=True):
        exactness = _EXACTNESS * model.number(channel.axis, "friction.coulomb") if channel.signal == TORQUE else 0.05 * floor.rms
        out.append(float(np.sqrt(floor.rms**2 + max(exactness, min(process, floor.rms)) ** 2)))
    return np.array(out)


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
        order = sorted(chosen, key=lambda f: -len(f.starts) * (5 if f.effect == "backlash" else 1) - (50 if f.ripple else 0))
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


def _lower_floors(
    search: Search, wide: Twin, found: list[Floor], model: AntennaModel, processing: Floats, hypothesis: Hypothesis
) -> list[Floor]:
    """Floors once a hypothesis is taken out; they may only fall. The search goes on under them."""
    structure, P = parameters_of(wide, hypothesis)
    found = smaller(found, floors(search.twin, wide, structure, P))
    search.floor = effective_floors(model, search.twin, found, processing)
    return found


def _hidden_in_its_floor(
    search: Search, wide: Twin, found: list[Floor], model: AntennaModel, processing: Floats, encoder: Floats, null: Scored
) -> Hypothesis | None:
    """The candidate under which a floor far above the encoder's own noise falls: what seemed noise above the band was its doing."""
    torque = np.array([channel.signal == TORQUE for channel in search.twin.channels])
    if not search.exact or not np.any(torque & (search.floor > _ABOVE_ENCODER * encoder)):
        return None
    fallen: list[tuple[float, Hypothesis]] = []
    for tried in search.one_round(null).tried[:3]:
        structure, P = parameters_of(wide, tried.hypothesis)
        lower = effective_floors(model, search.twin, smaller(found, floors(search.twin, wide, structure, P)), processing)
        fallen.append((float(np.min(lower / search.floor)), tried.hypothesis))
    ratio, hypothesis = min(fallen, key=lambda item: item[0], default=(1.0, null.hypothesis))
    return hypothesis if ratio < _HIDDEN else None


def _decide(
    search: Search, wide: Twin, found: list[Floor], model: AntennaModel, processing: Floats, encoder: Floats
) -> tuple[Scored, Scored, Scored | None, list[Round], list[Floor]]:
    """Sparse explanation first; when that fails, let the known numbers float and try again."""
    search.progress("the model as it stands")
    null = search.null()
    if _left(search, null) <= _QUIET:
        hidden = _hidden_in_its_floor(search, wide, found, model, processing, encoder, null)
        if hidden is None:
            return null, null, None, [], found
        found = _lower_floors(search, wide, found, model, processing, hidden)
        null = search.again(null)
    if not search.exact:
        # a model without bristles is refitted first: what it lacks shows beside the best that it can do
        known = known_numbers(model, TRUST) + known_offsets(model)
        as_stated, null = null, search.null(Hypothesis(floating=known, y=(0.0,) * len(known)))
        named = _too_far(search, null, as_stated)
        if named.hypothesis.causes:
            best, rounds = search.forward(named, null=as_stated)
            return best if search.complete(best, as_stated) else named, as_stated, null, rounds, found
        best, rounds = search.forward(null)
        return best, null, None, rounds, found
    sparse, rounds = search.forward(null, most=_FEW)
    tried = rounds
    for _ in range(_FEW):
        leading = sparse if sparse.hypothesis.causes else min((s for r in tried for s in r.tried), key=lambda s: s.fit.cost, default=null)
        if not leading.hypothesis.causes:
            break
        # a cause reaches beyond the scored band and passes for noise there until it is taken out: floors may only fall
        before = search.floor
        found = _lower_floors(search, wide, found, model, processing, leading.hypothesis)
        null, sparse = search.again(null), search.again(sparse)
        if float(np.min(search.floor / before)) >= _FALLEN or (sparse.hypothesis.causes and search.complete(sparse, null)):
            break
        # what seemed explained under the old floors may hide another cause under the new ones
        sparse, tried = search.forward(sparse, most=_FEW, null=null)
        rounds = rounds + tried
    stands = bool(sparse.hypothesis.causes) and search.complete(sparse, null)
    quiet = stands and _left(search, sparse) <= CALM_FLOORS
    if quiet and len(sparse.hypothesis.causes) == 1:
        return sparse, null, None, rounds, found
    search.progress("letting the known numbers float")
    known = known_numbers(model, TRUST)
    floated = search.null(Hypothesis(floating=known, y=(0.0,) * len(known)))
    if quiet:
        # several numbers that are off by a few per cent each can look like two causes, but not as closely as they are themselves
        off = _left(search, floated) < _QUIET and search.complete(floated, null) and not floated.hypothesis.far
        off = off and compare(search, sparse, floated).better
        return floated if off else sparse, null, floated if off else None, rounds, found
    found = _lower_floors(search, wide, found, model, processing, floated.hypothesis)
    null, sparse, floated = search.again(null), search.again(sparse), search.again(floated)
    stands = bool(sparse.hypothesis.causes) and search.complete(sparse, null)
    # where causes alone explain nearly all, known numbers that are off must explain clearly more to be the better story
    most = _CLEARLY_LESS * _left(search, sparse) if stands else math.inf
    if search.complete(floated, null) and _left(search, floated) < min(_QUIET, most):
        return _too_far(search, floated, null), null, floated, rounds, found
    again, more = search.forward(floated, most=_FEW)
    rounds += more
    if again.hypothesis.causes and search.complete(again, null) and _left(search, again) < most:
        return again, null, floated, rounds, found
    if search.complete(floated, null) and _left(search, floated) <= min(COMPLETE_FLOORS, most):
        return _too_far(search, floated, null), null, floated, rounds, found
    if stands:
        return sparse, null, None, rounds, found
    if len(sparse.hypothesis.causes) == _FEW and search.closed(sparse, null) > _PROMISING:
        search.progress("looking for more causes")
        sparse, more = search.forward(sparse, null=null)
        rounds += more
    return sparse, null, None, rounds, found


def _left(search: Search, state: Scored) -> float:
    """The largest gap that a state leaves on any channel, in floors."""
    return float(np.max(search.gaps(state)))


def _only_noise(
    search: Search, measured: tuple[SignalsTable, ...], holdout: tuple[SignalsTable, ...], state: Scored, processing: Floats
) -> bool:
    """Whether what a state leaves is the noise of its own rows, whose level changes, or what the pipeline leaves of the model itself."""
    if _left(search, state) <= COMPLETE_FLOORS:
        return True
    if not search.exact:
        return bool(np.all(search.gaps(state) <= COMPLETE_FLOORS * np.hypot(1.0, processing / search.floor)))
    if _left(search, state) > _NOISE_CHANGES:
        return False
    at = parameters_of(search.twin, state.hypothesis)
    logs = ((search.twin, measured), (search.holdout, holdout))
    return all(over_own_noise(twin, tables, *at, search.floor) <= COMPLETE_FLOORS for twin, tables in logs)


def _too_far(search: Search, floated: Scored, null: Scored) -> Scored:
    """A known number that had to move far beyond what a rig is off by is a cause: its effect is named in its place."""
    hypothesis = floated.hypothesis
    for known, _ in sorted(hypothesis.far.items(), key=lambda item: -item[1]):
        for family in search.families:
            paths = {search.twin.model.number_path(family.axis, p.path) for p in CATALOGUE[family.effect].parameters if p.path}
            if family.axis != known.axis or known.path not in paths or not CATALOGUE[family.effect].is_number:
                continue
            # the cause starts where the number was in the model, so that it and not the floating number does the way
            mine = [k.axis == known.axis and k.path in paths for k in hypothesis.floating]
            home = replace(hypothesis, y=tuple(0.0 if here else y for here, y in zip(mine, hypothesis.y, strict=True)))
            named = search.refitted(home.plus(Cause(family, (0.0,) * len(family.knobs))))
            left = max(
                abs(y)
                for k, y in zip(named.hypothesis.floating, named.hypothesis.y, strict=True)
                if k.path in paths and k.axis == known.axis
            )
            if search.complete(named, null) and left < 0.5 * FAR:
                return named
    return floated


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


__all__ = ["Diagnosis", "diagnose", "effective_floors", "scored_band", "with_hold_out"]
