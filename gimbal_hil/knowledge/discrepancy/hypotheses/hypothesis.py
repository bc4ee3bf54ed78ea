"""A hypothesis: which effects are added, where their coordinates stand, and what numbers that means."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from gimbal_hil.knowledge.discrepancy.hypotheses.families import Family
from gimbal_hil.knowledge.discrepancy.twin import (
    Bounds,
    Structure,
    Twin,
    keep_physical,
    keep_within,
    number_slot,
    read_number,
    write_number,
)
from sim_backend import layout
from sim_backend.effects import CATALOGUE, Knob, Move
from sim_backend.model import CENTRE, MOMENTS, NUMBER_AT, PRODUCTS, AntennaModel, beside

#: a coordinate this close to its bound (share of the room that it has, at most of one unit) stands there: a search
#: that presses against a bound ends a little before it
_NEAR = 0.02
#: a number that is held back by this share stands at its bound
_HELD = 1e-3
#: by less it is rounding
_ROUNDING = 1e-9
#: and a known number this close to the end of its uncertainty presses against it
_PRESSING = 0.98
#: an uncertainty that was stated too small by this factor surprises nobody: with twice, numbers 10 % off where 5 % is
#: stated lay just beyond it, and gains of the drives were named in their place
PLAUSIBLE = 2.5


@dataclass(frozen=True)
class Cause:
    """A family and the coordinates at which it stands."""

    family: Family
    x: tuple[float, ...]

    @property
    def knobs_at_bound(self) -> tuple[str, ...]:
        """Parameters whose coordinates may go no further. Nuisances do not count, nor does nothing as the bound of a
        strength: near it, the strength is small.
        """
        found: list[str] = []
        strengths = {parameter.name for parameter in CATALOGUE[self.family.effect].strengths}
        for knob, x in zip(self.family.knobs, self.x, strict=True):
            close = _NEAR * min(knob.high - knob.low, 1.0)
            from_nothing = knob.move is Move.ADD and strengths.issuperset(knob.parameters)
            ends = [end for end in knob.telling_ends if end != knob.nothing or not from_nothing]
            if knob.low < knob.high and any(abs(x - end) <= close for end in ends):
                found += knob.parameters or (knob.along or "",)
        return tuple(found)


@dataclass(frozen=True)
class KnownNumber:
    """A number of the model that may float: its axis, path, the share by which one trusts it, and how many times that
    it may move.

    It moves by the factor exp(y); with a size, by y times that size: offsets, centres of gravity and products of
    inertia may change their sign, and next to zero no factor leads where they may be.
    """

    axis: str
    path: str
    trust: float
    size: float = 0.0
    room: float = 1.0

    @property
    def reach(self) -> float:
        """The farthest coordinate."""
        return self.room * self.trust

    def moved(self, nominal: float, y: float) -> float:
        """The number at coordinate y."""
        return nominal + self.size * y if self.size > 0.0 else nominal * math.exp(y)

    def coordinate(self, nominal: float, value: float) -> float | None:
        """The coordinate at which the number has a value; None where it never has."""
        if self.size > 0.0:
            return (value - nominal) / self.size
        return math.log(value / nominal) if value * nominal > 0.0 else None


@dataclass(frozen=True)
class Origin:
    """Where the encoder of an axis (its index) had its zero in one log, against the first fitted one: `shift` of
    position, and the shift that is one unit of its coordinate.
    """

    record: str
    axis: int
    shift: float
    size: float


@dataclass(frozen=True)
class Hypothesis:
    """Causes beside a model whose known numbers may stand off by factors exp(y), in logs whose zeros may differ."""

    causes: tuple[Cause, ...] = ()
    floating: tuple[KnownNumber, ...] = ()
    y: tuple[float, ...] = field(default=())
    origins: tuple[Origin, ...] = ()

    @property
    def pressing(self) -> tuple[int, ...]:
        """Known numbers that are held back by their uncertainty, as places in `floating`."""
        both = zip(self.floating, self.y, strict=True)
        return tuple(i for i, (known, y) in enumerate(both) if abs(y) >= _PRESSING * known.reach)

    @property
    def labels(self) -> tuple[tuple[str, str], ...]:
        """(effect, axis) of every cause."""
        return tuple(cause.family.label for cause in self.causes)

    def vector(self) -> np.ndarray:
        """All coordinates: causes in order, then zeros of the logs, then known numbers."""
        zeros = [origin.shift / origin.size for origin in self.origins]
        return np.array([x for cause in self.causes for x in cause.x] + zeros + list(self.y))

    def at(self, vector: np.ndarray) -> Hypothesis:
        """The same hypothesis at other coordinates, held inside the knobs' bounds."""
        causes, k = [], 0
        for cause in self.causes:
            knobs = cause.family.knobs
            causes.append(
                replace(
                    cause, x=tuple(float(np.clip(vector[k + j], knob.low, knob.high)) for j, knob in enumerate(knobs))
                )
            )
            k += len(knobs)
        zeros = len(self.origins)
        origins = tuple(
            replace(origin, shift=float(z) * origin.size)
            for origin, z in zip(self.origins, vector[k : k + zeros], strict=True)
        )
        return replace(self, causes=tuple(causes), origins=origins, y=tuple(float(v) for v in vector[k + zeros :]))

    def plus(self, cause: Cause) -> Hypothesis:
        """With one more cause."""
        more = replace(self, causes=(*self.causes, cause))
        return more.at(more.vector())

    def minus(self, index: int) -> Hypothesis:
        """Without cause number `index`."""
        left = tuple(c for i, c in enumerate(self.causes) if i != index)
        # where zeros stand is only seen by what repeats over position
        origins = self.origins if any(c.family.ripple for c in left) else ()
        return replace(self, causes=left, origins=origins)


def hook_list(hypothesis: Hypothesis) -> tuple[tuple[str, str], ...]:
    """(effect, axis) of the causes that add physics, in order."""
    return tuple(label for label in hypothesis.labels if not CATALOGUE[label[0]].is_number)


def parameters_of(twin: Twin, hypothesis: Hypothesis) -> tuple[Structure, np.ndarray]:
    """The arrays that stand for a hypothesis: its structure and a filled copy of P, held where an antenna can be."""
    structure, P = _as_moved(twin, hypothesis)
    _hold(twin, hypothesis, P, structure.P)
    return structure, P


def _hold(twin: Twin, hypothesis: Hypothesis, P: np.ndarray, stated: np.ndarray) -> None:
    keep_within(twin.model, P, _bounds(twin.model, hypothesis))
    keep_physical(twin.model, P, stated)


def is_held(twin: Twin, hypothesis: Hypothesis) -> bool:
    """Whether a number is held back where causes and recalibration lead: no antenna is there."""
    structure, led = _as_moved(twin, hypothesis)
    held = led.copy()
    _hold(twin, hypothesis, held, structure.P)
    return bool(np.any(np.abs(led - held) > _ROUNDING * np.abs(held)))


def _as_moved(twin: Twin, hypothesis: Hypothesis) -> tuple[Structure, np.ndarray]:
    """The same, wherever causes and recalibration lead the numbers together."""
    structure = twin.structure(hook_list(hypothesis))
    P = structure.P.copy()
    offsets = iter(zip(hook_list(hypothesis), structure.offsets, strict=True))
    for known, y in zip(hypothesis.floating, hypothesis.y, strict=True):
        slot = number_slot(twin.model, known.axis, known.path)
        P[slot] = known.moved(float(P[slot]), y)
    for axis in twin.model.axes:
        if hypothesis.floating and has_no_bump(twin.model, axis):
            block = layout.axis_block(twin.model.axes.index(axis))
            P[block + layout.TS] = P[block + layout.TC]
    for cause in hypothesis.causes:
        effect, axis = cause.family.label
        offset = -1 if CATALOGUE[effect].is_number else next(offsets)[1]
        for knob, x in zip(cause.family.knobs, cause.x, strict=True):
            for place in _places(effect, knob, offset):
                if isinstance(place, int):
                    P[place] = knob.moved(float(P[place]), x)
                else:
                    write_number(twin.model, P, axis, place, knob.moved(read_number(twin.model, P, axis, place), x))
        if cause.family.ripple is not None:
            _turn_about_middle(cause.family, P, structure.P, offset)
    return structure, P


def _turn_about_middle(family: Family, P: np.ndarray, stated: np.ndarray, offset: int) -> None:
    """Give a ripple of another order, whose parameters begin at `offset`, the phase with which the middle of the travel
    keeps its angle.
    """
    slots = {parameter.name: offset + j for j, parameter in enumerate(CATALOGUE[family.effect].parameters)}
    if {"order", "phase"} <= slots.keys():
        P[slots["phase"]] -= family.middle * (P[slots["order"]] - stated[slots["order"]])


def _places(effect: str, knob: Knob, offset: int) -> list[int | str]:
    """What a knob moves: slots of an instance whose parameters begin at `offset`, and paths of numbers of the model."""
    found: list[int | str] = [] if knob.along is None else [knob.along]
    for j, parameter in enumerate(CATALOGUE[effect].parameters):
        if parameter.name in knob.parameters:
            found.append(offset + j if parameter.path is None else parameter.path)
    return found


def _bounds(model: AntennaModel, hypothesis: Hypothesis) -> Bounds:
    """The catalogue's bounds of every number of the model that a cause has; more than one cause may have it."""
    found: dict[tuple[str, str], tuple[float, float]] = {}
    for effect, axis in hypothesis.labels:
        for parameter in CATALOGUE[effect].parameters:
            if parameter.path is not None:
                path = model.number_path(axis, parameter.path)
                found[axis, path] = CATALOGUE[effect].bounds(parameter.name, model.number(axis, path))
    return found


def has_no_bump(model: AntennaModel, axis: str) -> bool:
    """Whether an axis' model states Coulomb friction without a Stribeck bump."""
    return 0.0 < model.number(axis, "friction.coulomb") == model.number(axis, "friction.breakaway")


def is_tied(model: AntennaModel, axis: str, path: str) -> bool:
    """Whether a number goes with another one: without a Stribeck bump, break-away stands at the Coulomb level."""
    return path in _BUMP and has_no_bump(model, axis)


def values_of(
    model: AntennaModel, twin: Twin, hypothesis: Hypothesis, index: int, held: bool = True
) -> dict[str, tuple[float, float | None]]:
    """Parameters of one cause in the catalogue's names: (value, the model's own value where it has one); not `held`,
    wherever causes and recalibration lead them, be it where no antenna can be.
    """
    _, P = parameters_of(twin, hypothesis) if held else _as_moved(twin, hypothesis)
    structure = twin.structure(hook_list(hypothesis))
    cause = hypothesis.causes[index]
    effect, axis = cause.family.label
    hooks = [i for i, c in enumerate(hypothesis.causes) if not CATALOGUE[c.family.effect].is_number]
    offset = structure.offsets[hooks.index(index)] if index in hooks else -1
    is_stated = model.own_instance(effect, axis) is not None
    found: dict[str, tuple[float, float | None]] = {}
    for j, parameter in enumerate(CATALOGUE[effect].parameters):
        if parameter.path is None:
            if any(parameter.name in knob.parameters for knob in cause.family.knobs):
                found[parameter.name] = float(P[offset + j]), float(structure.P[offset + j]) if is_stated else None
        else:
            path = model.number_path(axis, parameter.path)
            nominal = model.number(axis, path)
            usual = NUMBER_AT[path].default_beside(lambda other: model.number(axis, other))
            stated = None if nominal == usual == 0.0 else nominal
            found[parameter.name] = read_number(model, P, axis, path), stated
    return _upright(effect, found)


def plainer_of(twin: Twin, hypothesis: Hypothesis, index: int) -> str | None:
    """The name of the effect with fewer numbers that a cause contains where its numbers stand."""
    plainer = CATALOGUE[hypothesis.causes[index].family.effect].plainer
    if plainer is None:
        return None
    values = values_of(twin.model, twin, hypothesis, index)
    return plainer.name if plainer.holds({name: value for name, (value, _) in values.items()}) else None


def at_bound(twin: Twin, hypothesis: Hypothesis, index: int) -> tuple[str, ...]:
    """Parameters of one cause that may go no further: of those nothing is known.

    They stand at the end of their own coordinates, or are held back where the cause and recalibration together would
    leave the catalogue's bounds or what an antenna can be.
    """
    cause = hypothesis.causes[index]
    effect, axis = cause.family.label
    nuisances = {name for knob in cause.family.knobs if knob.nuisance for name in knob.parameters}
    (_, led), (_, held) = _as_moved(twin, hypothesis), parameters_of(twin, hypothesis)
    found = list(cause.knobs_at_bound)
    for parameter in CATALOGUE[effect].parameters:
        if parameter.path is not None and parameter.name not in (*found, *nuisances):
            wanted, kept = (read_number(twin.model, P, axis, parameter.path) for P in (led, held))
            if abs(wanted - kept) > _HELD * abs(kept):
                found.append(parameter.name)
    return tuple(found)


def _upright(effect: str, found: dict[str, tuple[float, float | None]]) -> dict[str, tuple[float, float | None]]:
    """Ripples with a positive amplitude, angles in (-pi, pi]."""
    for parameter in CATALOGUE[effect].parameters:
        if parameter.periodic and parameter.name in found:
            (angle, stated), of = found[parameter.name], parameter.half_turn_of
            if of in found and found[of][0] < 0.0:
                found[of], angle = (-found[of][0], None), angle + math.pi
            found[parameter.name] = (angle + math.pi) % (2.0 * math.pi) - math.pi, stated
    return found


def known_numbers(model: AntennaModel) -> tuple[KnownNumber, ...]:
    """Numbers that float within what the model says of them: friction, bodies, offsets, gains. What is exactly known
    stays, as does friction that is none.

    A number that no effect of the catalogue could tell may go as far as is plausible: held back, it would press, and
    something that is not off would be told in its place.
    """
    tellable = {
        (axis, model.number_path(axis, parameter.path))
        for axis in model.axes
        for effect in CATALOGUE.values()
        for parameter in effect.parameters
        if effect.is_number and parameter.path
    }
    bodies = ("body.mass",) if model.is_linear else (*MOMENTS, *PRODUCTS, *CENTRE)
    found = []
    for axis in model.axes:
        for path in (*_FRICTION, *bodies, *_ACTUATOR):
            value, spread = model.number(axis, path), model.uncertainty(axis, path)
            # what may have either sign also floats from zero, in units of all its components or of what is said of it
            together = math.hypot(*(model.number(axis, one) for one in beside(path))) or spread
            size, unit = (together, together) if path in _SIGNED else (abs(value), 0.0)
            if size == 0.0 or spread == 0.0 or is_tied(model, axis, path):
                continue
            room = 1.0 if (axis, path) in tellable else PLAUSIBLE
            found.append(KnownNumber(axis, path, spread / size, unit, room))
    return tuple(found)


_BUMP = ("friction.breakaway", "friction.stribeck_velocity", "friction.shape")
_FRICTION = ("friction.coulomb", *_BUMP, "friction.sigma0", "friction.sigma1", "friction.viscous")
_ACTUATOR = ("actuator.offset", "actuator.gain_error")
#: either side of zero
_SIGNED = (*PRODUCTS, *CENTRE, *_ACTUATOR)
