"""Which story is told: the model as it stands, few causes beside it, known numbers that are off, or causes beside those."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from gimbal_hil.discrepancy.completeness import CALM_FLOORS, COMPLETE_FLOORS
from gimbal_hil.discrepancy.falling_floors import FallingFloors
from gimbal_hil.discrepancy.hypothesis import FAR, Cause, Hypothesis, KnownNumber, known_numbers, known_offsets
from gimbal_hil.discrepancy.record import TORQUE
from gimbal_hil.discrepancy.rivals import compare
from gimbal_hil.discrepancy.search import Round, Scored, Search
from gimbal_hil.discrepancy.smoothing import Floats
from sim_backend.effects import CATALOGUE

#: a model's numbers are trusted to this share once they have to float
TRUST = 0.08
#: gap, in floors, below which nothing is searched for
_QUIET = 1.3
#: causes that are looked for before the known numbers float
_FEW = 2
#: a torque floor this far above the encoder's noise may hide a cause; it does when a candidate brings it below this share of itself
_ABOVE_ENCODER, _HIDDEN = 3.0, 0.5
#: candidates that are asked for that
_ASKED = 3
#: floors that fell below this share of what they were are worth another search
_FALLEN = 0.8
#: what known numbers that are off leave, as a share of what causes beside the model as it stands do, to be the better story
_CLEARLY_LESS = 0.5
#: share of the gap that causes must have closed for more to be looked for
_PROMISING = 0.7


@dataclass(frozen=True)
class Story:
    """The explanation that is taken, under the floors that stand at the end."""

    best: Scored
    #: the model as it stands; as it was refitted where it carries no bristle and no number of it had to move far
    null: Scored
    #: refitted without causes where known numbers had to float
    floated: Scored | None = None
    rounds: tuple[Round, ...] = ()


def decide(search: Search, floors: FallingFloors, encoder: Floats) -> Story:
    """The explanation of a search's data. `encoder`: rms that the encoder's error alone makes, per channel; floors fall on the way."""
    search.progress("the model as it stands")
    null = search.null()
    if largest_left(search, null) <= _QUIET:
        hidden = _hidden_in_its_floor(search, floors, encoder, null)
        if hidden is None:
            return Story(null, null)
        search.floor = floors.fall(hidden)
        null = search.again(null)
    return _with_bristles(search, floors, null) if search.exact else _without_bristles(search, null)


def largest_left(search: Search, state: Scored) -> float:
    """The largest gap that a state leaves on any channel, in floors."""
    return float(np.max(search.gaps(state)))


def _with_bristles(search: Search, floors: FallingFloors, null: Scored) -> Story:
    """Sparse explanation first; when that fails, let the known numbers float and try again."""
    sparse, null, rounds = _few_causes(search, floors, null)
    quiet = _stands(search, sparse, null) and largest_left(search, sparse) <= CALM_FLOORS
    if quiet and len(sparse.hypothesis.causes) == 1:
        return Story(sparse, null, None, rounds)
    search.progress("letting the known numbers float")
    floated = search.null(_floating(known_numbers(search.twin.model, TRUST)))
    if quiet:
        # several numbers that are off by a few per cent each can look like two causes, but not as closely as they are themselves
        off = largest_left(search, floated) < _QUIET and search.complete(floated, null) and not floated.hypothesis.far
        off = off and compare(search, sparse, floated).better
        return Story(floated, null, floated, rounds) if off else Story(sparse, null, None, rounds)
    search.floor = floors.fall(floated.hypothesis)
    null, sparse, floated = search.again(null), search.again(sparse), search.again(floated)
    # where causes alone explain nearly all, known numbers that are off must explain clearly more to be the better story
    stands = _stands(search, sparse, null)
    most = _CLEARLY_LESS * largest_left(search, sparse) if stands else math.inf
    if search.complete(floated, null) and largest_left(search, floated) < min(_QUIET, most):
        return Story(_far_numbers_named(search, floated, null), null, floated, rounds)
    again, more = search.forward(floated, most=_FEW)
    rounds += tuple(more)
    if _stands(search, again, null) and largest_left(search, again) < most:
        return Story(again, null, floated, rounds)
    if search.complete(floated, null) and largest_left(search, floated) <= min(COMPLETE_FLOORS, most):
        return Story(_far_numbers_named(search, floated, null), null, floated, rounds)
    if not stands and len(sparse.hypothesis.causes) == _FEW and search.closed(sparse, null) > _PROMISING:
        search.progress("looking for more causes")
        sparse, more = search.forward(sparse, null=null)
        rounds += tuple(more)
    return Story(sparse, null, None, rounds)


def _without_bristles(search: Search, as_stated: Scored) -> Story:
    """Known numbers float first: what such a model lacks shows beside the best that it can do."""
    model = search.twin.model
    floated = search.null(_floating(known_numbers(model, TRUST) + known_offsets(model)))
    named = _far_numbers_named(search, floated, as_stated)
    if named.hypothesis.causes:
        best, rounds = search.forward(named, null=as_stated)
        return Story(best if search.complete(best, as_stated) else named, as_stated, floated, tuple(rounds))
    best, rounds = search.forward(floated)
    return Story(best, floated, None, tuple(rounds))


def _few_causes(search: Search, floors: FallingFloors, null: Scored) -> tuple[Scored, Scored, tuple[Round, ...]]:
    """Few causes beside the model as it stands, the null under the same floors, and what was tried."""
    sparse, tried = search.forward(null, most=_FEW)
    rounds = tuple(tried)
    for _ in range(_FEW):
        leading = sparse if sparse.hypothesis.causes else min((s for r in tried for s in r.tried), key=lambda s: s.fit.cost, default=null)
        if not leading.hypothesis.causes:
            break
        before = search.floor
        search.floor = floors.fall(leading.hypothesis)
        null, sparse = search.again(null), search.again(sparse)
        if float(np.min(search.floor / before)) >= _FALLEN or _stands(search, sparse, null):
            break
        # what seemed explained under the old floors may hide another cause under the new ones
        sparse, tried = search.forward(sparse, most=_FEW, null=null)
        rounds += tuple(tried)
    return sparse, null, rounds


def _stands(search: Search, state: Scored, null: Scored) -> bool:
    """Whether a state has causes and they explain the data."""
    return bool(state.hypothesis.causes) and search.complete(state, null)


def _hidden_in_its_floor(search: Search, floors: FallingFloors, encoder: Floats, null: Scored) -> Hypothesis | None:
    """The candidate under which a floor far above the encoder's own noise falls: what seemed noise above the band was its doing."""
    torque = np.array([channel.signal == TORQUE for channel in search.twin.channels])
    if not search.exact or not np.any(torque & (search.floor > _ABOVE_ENCODER * encoder)):
        return None
    fallen: list[tuple[float, Hypothesis]] = []
    for tried in search.one_round(null).tried[:_ASKED]:
        lower = floors.under(tried.hypothesis)
        fallen.append((float(np.min(lower / search.floor)), tried.hypothesis))
    ratio, hypothesis = min(fallen, key=lambda item: item[0], default=(1.0, null.hypothesis))
    return hypothesis if ratio < _HIDDEN else None


def _floating(known: tuple[KnownNumber, ...]) -> Hypothesis:
    return Hypothesis(floating=known, y=(0.0,) * len(known))


def _far_numbers_named(search: Search, floated: Scored, null: Scored) -> Scored:
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
