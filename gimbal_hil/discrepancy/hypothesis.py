"""A hypothesis: which effects are added, where their coordinates stand, and what numbers that means."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from gimbal_hil.discrepancy.families import Family, Knob, Move
from gimbal_hil.discrepancy.twin import Structure, Twin, number_slot
from sim_backend import layout
from sim_backend.effects import CATALOGUE
from sim_backend.model import NUMBER_AT, AntennaModel, lag_decay

#: a known number that floats this far (log) is not what a rig is off by
FAR = 0.22


@dataclass(frozen=True)
class Cause:
    """A family and the coordinates at which it stands."""

    family: Family
    x: tuple[float, ...]


@dataclass(frozen=True)
class KnownNumber:
    """A number of the model that may float: its axis, path and the share by which one trusts it.

    It moves by the factor exp(y); with a size, by y times that size (an offset, which may change its sign).
    """

    axis: str
    path: str
    trust: float
    size: float = 0.0

    def moved(self, nominal: float, y: float) -> float:
        """The number at coordinate y."""
        return nominal + self.size * y if self.size > 0.0 else nominal * math.exp(y)


@dataclass(frozen=True)
class Hypothesis:
    """Causes beside a model whose known numbers may stand off by factors exp(y)."""

    causes: tuple[Cause, ...] = ()
    floating: tuple[KnownNumber, ...] = ()
    y: tuple[float, ...] = field(default=())

    @property
    def labels(self) -> tuple[tuple[str, str], ...]:
        """(effect, axis) of every cause."""
        return tuple(cause.family.label for cause in self.causes)

    @property
    def far(self) -> dict[KnownNumber, float]:
        """Known numbers that had to move farther than a rig is off by, and how far (log)."""
        moved = zip(self.floating, self.y, strict=True)
        return {known: abs(y) for known, y in moved if known.size == 0.0 and abs(y) > FAR}

    def vector(self) -> np.ndarray:
        """All coordinates: causes in order, then known numbers."""
        return np.array([x for cause in self.causes for x in cause.x] + list(self.y))

    def at(self, vector: np.ndarray) -> Hypothesis:
        """The same hypothesis at other coordinates, held inside the knobs' bounds."""
        causes, k = [], 0
        for cause in self.causes:
            knobs = cause.family.knobs
            causes.append(replace(cause, x=tuple(float(np.clip(vector[k + j], knob.low, knob.high)) for j, knob in enumerate(knobs))))
            k += len(knobs)
        limits = (20.0 if known.size > 0.0 else 0.7 for known in self.floating)
        return replace(self, causes=tuple(causes), y=tuple(float(np.clip(v, -m, m)) for v, m in zip(vector[k:], limits, strict=True)))

    def plus(self, cause: Cause) -> Hypothesis:
        """With one more cause."""
        more = replace(self, causes=(*self.causes, cause))
        return more.at(more.vector())

    def minus(self, index: int) -> Hypothesis:
        """Without cause number `index`."""
        return replace(self, causes=tuple(c for i, c in enumerate(self.causes) if i != index))


def hook_list(hypothesis: Hypothesis) -> tuple[tuple[str, str], ...]:
    """(effect, axis) of the causes that add physics, in order."""
    return tuple(label for label in hypothesis.labels if not CATALOGUE[label[0]].is_number)


def parameters_of(twin: Twin, hypothesis: Hypothesis) -> tuple[Structure, np.ndarray]:
    """The arrays that stand for a hypothesis: its structure and a filled copy of P."""
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
        offset = -1
        if not CATALOGUE[effect].is_number:
            offset = next(offsets)[1]
        for knob, x in zip(cause.family.knobs, cause.x, strict=True):
            _turn(twin.model, P, effect, axis, knob, x, offset)
    for i in range(len(twin.model.axes)):
        _keep_physical(P, layout.axis_block(i))
    return structure, P


def _turn(model: AntennaModel, P: np.ndarray, effect: str, axis: str, knob: Knob, x: float, offset: int) -> None:
    for name in knob.parameters:
        slot, path = _slot(model, effect, axis, name, offset)
        if path == "actuator.time_constant":
            decay, mean = lag_decay(max(knob.size * x, 1e-6), P[layout.STEP_S])
            P[slot], P[slot + layout.LAG_MEAN - layout.LAG_DECAY] = max(decay, 1e-300), mean
        elif knob.move is Move.ADD:
            P[slot] += knob.size * x
        elif path == "actuator.limit" or path is None or P[slot] == 0.0:
            P[slot] = knob.size * math.exp(x)
        else:
            P[slot] *= math.exp(x)


def _slot(model: AntennaModel, effect: str, axis: str, name: str, offset: int) -> tuple[int, str | None]:
    parameters = CATALOGUE[effect].parameters
    for j, parameter in enumerate(parameters):
        if parameter.name == name:
            if parameter.path is None:
                return offset + j, None
            return number_slot(model, axis, parameter.path), parameter.path
    # a number that moves along with a foreign effect: the joint's own inertia beside a backlash
    return number_slot(model, axis, "body.own_inertia"), "body.own_inertia"


def has_no_bump(model: AntennaModel, axis: str) -> bool:
    """Whether an axis' model states Coulomb friction without a Stribeck bump."""
    return 0.0 < model.number(axis, "friction.coulomb") == model.number(axis, "friction.breakaway")


def _keep_physical(P: np.ndarray, block: int) -> None:
    if P[block + layout.TC] > 0.0 or P[block + layout.TS] > 0.0:
        P[block + layout.TC] = max(P[block + layout.TC], 1e-9)
        # a map without a bristle may also dip towards standstill; a bristle then had nothing to break away from
        least = P[block + layout.TC] if P[block + layout.SIGMA0] > 0.0 else 0.05 * P[block + layout.TC]
        P[block + layout.TS] = max(P[block + layout.TS], least)
    P[block + layout.SIGMA2] = max(P[block + layout.SIGMA2], 0.0)


def values_of(model: AntennaModel, twin: Twin, hypothesis: Hypothesis, index: int) -> dict[str, tuple[float, float | None]]:
    """Parameters of one cause in the catalogue's names: (value, the model's own value where it has one)."""
    _, P = parameters_of(twin, hypothesis)
    structure = twin.structure(hook_list(hypothesis))
    cause = hypothesis.causes[index]
    effect, axis = cause.family.label
    hooks = [i for i, c in enumerate(hypothesis.causes) if not CATALOGUE[c.family.effect].is_number]
    offset = structure.offsets[hooks.index(index)] if index in hooks else -1
    found: dict[str, tuple[float, float | None]] = {}
    for parameter in CATALOGUE[effect].parameters:
        if parameter.path is None:
            value = float(P[offset + CATALOGUE[effect].parameters.index(parameter)])
            if any(parameter.name in knob.parameters for knob in cause.family.knobs):
                found[parameter.name] = value, None
        else:
            slot = number_slot(model, axis, parameter.path)
            value = float(P[slot])
            if parameter.path == "actuator.time_constant":
                value = -float(P[layout.STEP_S]) / math.log(value) if value > 0.0 else 0.0
            nominal = model.number(axis, model.number_path(axis, parameter.path))
            path = model.number_path(axis, parameter.path)
            found[parameter.name] = value, None if nominal == 0.0 and NUMBER_AT[path].default == 0.0 else nominal
    return _upright(effect, found)


def _upright(effect: str, found: dict[str, tuple[float, float | None]]) -> dict[str, tuple[float, float | None]]:
    """Ripples with a positive amplitude and a phase in (-pi, pi]."""
    name = "relative_amplitude" if "relative_amplitude" in found else "amplitude"
    if name in found and "phase" in found:
        amplitude, phase = found[name][0], found["phase"][0]
        if amplitude < 0.0:
            amplitude, phase = -amplitude, phase + math.pi
        found[name] = amplitude, None
        found["phase"] = (phase + math.pi) % (2.0 * math.pi) - math.pi, None
    return found


def known_offsets(model: AntennaModel) -> tuple[KnownNumber, ...]:
    """Torque offsets that the model states: drives drift, and an offset hides behind whatever depends on direction. Zero stays zero."""
    offsets = {axis: model.number(axis, "actuator.offset") for axis in model.axes}
    sizes = {axis: max(abs(value), model.number(axis, "friction.coulomb")) for axis, value in offsets.items() if value != 0.0}
    return tuple(KnownNumber(axis, "actuator.offset", 1.0, size) for axis, size in sizes.items())


def known_numbers(model: AntennaModel, trust: float, axes: Sequence[str] | None = None) -> tuple[KnownNumber, ...]:
    """Numbers that a real rig's model may have 5-10 % wrong: friction, inertia, centres of gravity; those that are zero stay zero."""
    paths = [
        "friction.coulomb",
        "friction.breakaway",
        "friction.stribeck_velocity",
        "friction.shape",
        "friction.sigma0",
        "friction.sigma1",
        "friction.viscous",
    ]
    if model.is_linear:
        paths.append("body.mass")
    else:
        paths += [f"body.inertia.{c}" for c in ("xx", "yy", "zz", "xy", "xz", "yz")] + [f"body.cog.{c}" for c in "xyz"]
    bump = {"friction.breakaway", "friction.stribeck_velocity", "friction.shape"}
    return tuple(
        KnownNumber(axis, path, trust)
        for axis in (axes or model.axes)
        for path in paths
        if model.number(axis, path) != 0.0 and not (path in bump and has_no_bump(model, axis))
    )
