"""Would these logs have shown a number of the model that is half or twice its true value? Without that, "no gap" says
nothing.

Each inertia, Coulomb and viscous friction and torque gain is changed by a factor of two, in either direction, along the
motion of the logs. The other known numbers may compensate within their uncertainty. What remains has to be a gap by the
same rule that found none: on the hold-out, or a larger one in any log. If it is not, the logs cannot judge that number.
Noise is not added to it, because nobody knows how much of the floor is noise.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from gimbal_hil.knowledge.discrepancy.hypotheses import (
    Cause,
    Family,
    Fit,
    Hypothesis,
    KnownNumber,
    Weighing,
    command_residual,
    prior_weights,
)
from gimbal_hil.knowledge.discrepancy.inquiry import Inquiry, State, rms, weighing_of
from gimbal_hil.knowledge.discrepancy.judgement.smallest import Shows, slopes_of_hold_out, without_own
from gimbal_hil.knowledge.discrepancy.judgement.wander import beside_wander
from gimbal_hil.knowledge.discrepancy.search import row_weights
from gimbal_hil.knowledge.discrepancy.twin import Floats, Twin
from sim_backend.effects import CATALOGUE, Effect, Knob, Move
from sim_backend.model import AntennaModel

_FACTORS = (0.5, 2.0)
#: the fit of the other known numbers, and those that are the number itself
_Without: TypeAlias = tuple[Fit, tuple[KnownNumber, ...]]


@dataclass(frozen=True)
class NumberError:
    """A number (effect, axis) that is half or twice what it should be, over what its own uncertainty takes of that: two
    hypotheses, and the fit of the other known numbers.
    """

    label: tuple[str, str]
    near: Hypothesis
    off: Hypothesis
    bare: Fit

    def on(self, twin: Twin, floor: Floats) -> Floats:
        """What it does to the residual, (rows, channels), in floors."""
        return command_residual(twin, self.off, floor) - command_residual(twin, self.near, floor)


def hidden_errors(
    inquiry: Inquiry, null: State, smallest: tuple[Shows, ...], searched: frozenset[str]
) -> tuple[tuple[str, str], ...]:
    """Numbers (effect, axis) that a model has to be right in and of which these logs would not have shown that they are
    half or twice what they should be, as far as the model states them and they were `searched`. What is told to show
    (`smallest`) from more than a half beyond what its own uncertainty takes would not have shown as half.
    """
    shares = {(one.name, one.axis): one.relative for one in smallest}
    model, families = inquiry.twin.model, {family.label: family for family in inquiry.families}
    asked = [
        (effect.name, axis)
        for axis in model.axes
        for effect in CATALOGUE.values()
        if effect.must_show and effect.name in searched and _is_stated(model, axis, effect)
    ]
    weighing = weighing_of(inquiry, null)
    slopes = dict(zip(null.held.floating, slopes_of_hold_out(inquiry, null), strict=True))

    def shows(family: Family) -> bool:
        without = without_own(inquiry, null, family)
        late = _shows_late(inquiry.twin.model, family, without[1], shares.get(family.label))
        return not late and all(_shows(inquiry, null, weighing, slopes, family, without, of) for of in _FACTORS)

    return tuple(label for label in asked if label not in families or not shows(families[label]))


def _shows_late(model: AntennaModel, family: Family, own: tuple[KnownNumber, ...], share: float | None) -> bool:
    """Whether a number shows from more than a half beyond the share by which it moves within its own uncertainty."""
    taken = _within_reach(model, family, own, max(_FACTORS)) - 1.0
    return share is not None and share > taken + 1.0 - min(_FACTORS)


def _is_stated(model: AntennaModel, axis: str, effect: Effect) -> bool:
    """Whether the model has the effect's number; a gain is one where nothing is said."""
    first = effect.parameters[0]
    return first.unit == "1" or model.number(axis, model.number_path(axis, first.path or "")) != 0.0


def number_errors(inquiry: Inquiry, null: State, labels: tuple[tuple[str, str], ...]) -> tuple[NumberError, ...]:
    """Both errors of every one of these numbers of which any log could show them: not where what the model says of a
    number allows as much.
    """
    families = {family.label: family for family in inquiry.families}
    both = {label: _errors(inquiry, null, families[label]) for label in labels if label in families}
    return tuple(one for errors in both.values() if None not in errors for one in errors if one is not None)


def _errors(inquiry: Inquiry, null: State, family: Family) -> list[NumberError | None]:
    without = without_own(inquiry, null, family)
    return [_error(inquiry, family, without, factor) for factor in _FACTORS]


def _error(inquiry: Inquiry, family: Family, without: _Without, factor: float) -> NumberError | None:
    """A number that is off by a factor; None where what the model says of it allows as much: nothing would be told."""
    bare, own = without
    near = _within_reach(inquiry.twin.model, family, own, factor)
    if (near - factor) * (factor - 1.0) >= 0.0:
        return None
    at, off = (bare.hypothesis.plus(_off_by(inquiry.twin.model, family, of)) for of in (near, factor))
    return NumberError(family.label, at, off, bare)


def _shows(
    inquiry: Inquiry,
    null: State,
    weighing: Weighing,
    slopes: dict[KnownNumber, Floats],
    family: Family,
    without: _Without,
    factor: float,
) -> bool:
    """Whether a number that is off by a factor would have left a gap."""
    error = _error(inquiry, family, without, factor)
    if error is None:
        return False
    fitted, held = (error.on(twin, inquiry.floor) for twin in (inquiry.twin, inquiry.holdout))
    if not (np.isfinite(fitted).all() and np.isfinite(held).all()):
        # no joint of that size makes this motion at all
        return True
    bare = error.bare
    others = bare.hypothesis.floating
    if others:
        moved = _taken(bare.jacobian, fitted.ravel(), row_weights(bare, weighing), bare.hypothesis)
        fitted = fitted - (bare.jacobian @ moved).reshape(fitted.shape)
        held = held - sum(by * slopes[known] for known, by in zip(others, moved, strict=True))
    return _is_gap(inquiry, null, fitted, held)


def _is_gap(inquiry: Inquiry, null: State, fitted: Floats, held: Floats) -> bool:
    """Whether rows of the fitted logs and of the hold-out are a gap by themselves, whatever the noise is: by the rule
    of the decision.
    """
    policy, limit = inquiry.policy, np.hypot(1.0, inquiry.inexact)
    halves = [rms(held[mask]) for mask in (inquiry.selecting, ~inquiry.selecting) if np.any(mask)]
    repeated = np.any(rms(held) > policy.least_gap * limit)
    large = np.any(np.max([rms(fitted), *halves], axis=0) > policy.not_repeated * limit)
    if not (repeated or large):
        return False
    return bool(np.any(beside_wander(inquiry, null, fitted, held) > policy.least_gap * limit))


def _taken(jacobian: Floats, rows: Floats, per_row: Floats, hypothesis: Hypothesis) -> Floats:
    """By how much known numbers move, within their uncertainty, to take what they can of rows of the fitted logs."""
    from scipy.optimize import lsq_linear

    basis, corner = np.linalg.qr(np.vstack([jacobian * per_row[:, None], np.diag(prior_weights(hypothesis))]))
    wanted = basis[: len(rows)].T @ (rows * per_row)
    y, reach = np.array(hypothesis.y), np.array([known.reach for known in hypothesis.floating])
    room = np.minimum(-reach - y, -1e-12), np.maximum(reach - y, 1e-12)
    return np.asarray(lsq_linear(corner, wanted, room, method="bvls").x)


def _within_reach(model: AntennaModel, family: Family, own: tuple[KnownNumber, ...], factor: float) -> float:
    """The factor up to which a number that is off moves to where it belongs, within its own uncertainty."""
    stated, is_share = _stated(model, family, family.knobs[0])
    ends = [known.moved(stated, math.copysign(known.reach, factor - 1.0)) for known in own if known.axis == family.axis]
    return next((1.0 + end - stated if is_share else end / stated for end in ends), 1.0)


def _stated(model: AntennaModel, family: Family, knob: Knob) -> tuple[float, bool]:
    """What the model says of the number that a knob moves, and whether one is added to it to make a factor."""
    parameter = next(p for p in CATALOGUE[family.effect].parameters if p.name == knob.parameters[0])
    return model.number(family.axis, model.number_path(family.axis, parameter.path or "")), parameter.unit == "1"


def _off_by(model: AntennaModel, family: Family, factor: float) -> Cause:
    """A number that is so many times what the model says, as far as the catalogue lets it be."""
    x = []
    for knob in family.knobs:
        stated, is_share = _stated(model, family, knob)
        wanted = stated + factor - 1.0 if is_share else factor * stated
        x.append(min(max(_coordinate(knob, stated, wanted), knob.low), knob.high))
    return Cause(family, tuple(x))


def _coordinate(knob: Knob, stated: float, wanted: float) -> float:
    if knob.move is Move.ADD:
        return (wanted - stated) / knob.size
    return math.log(wanted / (stated if knob.move is Move.FACTOR else knob.size))
