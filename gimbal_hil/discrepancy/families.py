"""How each effect of the catalogue is searched for: which numbers move, on what scale, and from where."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

import numpy as np

from gimbal_hil.discrepancy.record import Record
from sim_backend.effects import CATALOGUE
from sim_backend.model import AntennaModel

Vector = tuple[float, ...]
#: order of a ripple whose coordinate is zero
_NEUTRAL_ORDER = 1.0
#: milliradians by which a fitted encoder can be off its centre
_MOST_ECCENTRIC = 25.0


class Move(Enum):
    """How a coordinate moves its numbers: by a size, or by a factor exp(x)."""

    ADD = 0
    FACTOR = 1


@dataclass(frozen=True)
class Knob:
    """One coordinate of a hypothesis: x moves the named parameters of an effect together."""

    parameters: tuple[str, ...]
    move: Move
    #: ADD: change per unit of x
    size: float
    low: float = -math.inf
    high: float = math.inf


class Reading(Enum):
    """How least-squares coefficients of a start's probes become coordinates."""

    #: base + sum of coefficient times (probe - base)
    LINEAR = 0
    #: amplitude and phase of a ripple from its responses at phase 0 and a quarter turn
    POLAR = 1
    #: stiffness and rest position from a spring's pull and its constant part
    SPRING = 2


@dataclass(frozen=True)
class Start:
    """A point from which a family is tried: the response to `probes` (coordinates) spans what it can do near there."""

    probes: tuple[Vector, ...]
    base: Vector
    reading: Reading = Reading.LINEAR

    def coordinates(self, c: np.ndarray) -> Vector:
        """Where the coefficients of the probes point."""
        if self.reading is Reading.POLAR:
            return (float(np.hypot(c[0], c[1])) * self.probes[0][0], *self.base[1:-1], float(math.atan2(c[1], c[0])))
        if self.reading is Reading.SPRING:
            stiffness = float(c[0] + c[1])
            return stiffness, float(np.clip(c[1] / stiffness, -20.0, 20.0)) if abs(stiffness) > 1e-9 else 0.0
        move = sum(float(k) * (np.array(probe) - np.array(self.base)) for k, probe in zip(c, self.probes, strict=True))
        return tuple(float(x) for x in np.array(self.base) + move)


@dataclass(frozen=True)
class Family:
    """An effect on an axis, with its knobs and starts. `extra` moves another effect's number along (backlash: the joint's inertia)."""

    effect: str
    axis: str
    knobs: tuple[Knob, ...]
    starts: tuple[Start, ...]
    #: position ripples: which regressor finds the order, sin/cos of n q times one, or times the sign of the rate
    ripple: str | None = None
    #: a step along which its numbers trade against each other, in a valley too bent for the steps of a refit
    valley: Vector = ()

    @property
    def label(self) -> tuple[str, str]:
        """(effect, axis)."""
        return self.effect, self.axis


def _line(probe: float = 1.0) -> Start:
    return Start(((probe,),), (0.0,))


def _plane(dimensions: int, probe: float = 1.0) -> Start:
    return Start(tuple(tuple(probe if i == j else 0.0 for j in range(dimensions)) for i in range(dimensions)), (0.0,) * dimensions)


def _bent(at: Vector) -> Start:
    """A start where only the finite change itself is tried, as it is."""
    return Start((at,), at)


def ripple_start(order: float, probe: float) -> Start:
    """A ripple of one order with free amplitude and phase; the order's coordinate counts from the catalogue's neutral order."""
    x = order - _NEUTRAL_ORDER
    return Start(((probe, x, 0.0), (probe, x, 0.5 * math.pi)), (0.0, x, 0.0), Reading.POLAR)


def families(model: AntennaModel, axis: str, records: tuple[Record, ...]) -> list[Family]:
    """Every effect of the catalogue that this axis can have, scaled to the model and the data."""
    i = model.axes.index(axis)
    torque = float(np.sqrt(np.mean(np.concatenate([r.torque[:, i] ** 2 for r in records])))) or 1.0
    speed = float(np.quantile(np.concatenate([np.abs(r.motion[:, 2 + i]) for r in records]), 0.98)) or 1e-6
    peak = float(max(np.abs(r.torque[:, i]).max() for r in records))
    number = {path: model.number(axis, path) for path in _PATHS}
    inertia = model.number(axis, model.own_inertia_path(axis))
    friction = max(number["friction.coulomb"], 0.02 * torque)
    drag = max(number["friction.viscous"], 0.02 * torque / speed)
    add = Move.ADD

    def one(effect: str, parameter: str, size: float, low: float = -math.inf, high: float = math.inf, *probes: float) -> Family:
        return Family(effect, axis, (Knob((parameter,), add, size, low, high),), tuple(_line(p) for p in (probes or (1.0,))))

    found = [
        one("viscous", "viscous", 0.2 * drag),
        Family("coulomb", axis, (Knob(("coulomb", "breakaway"), add, 0.1 * friction),), (_line(),)),
        one("coulomb_asymmetry", "asymmetry", 0.05, -18.0, 18.0),
        one("viscous_asymmetry", "asymmetry", 0.1, -9.0, 9.0),
        one("load_dependent_friction", "coefficient", 0.02, 0.0, 40.0),
        one("quadratic_drag", "coefficient", 0.2 * drag / speed, 0.0),
        one("inertia", "inertia", 0.05 * inertia),
        one("torque_gain", "gain_error", 0.05, -15.0, 40.0),
        one("torque_offset", "offset", 0.05 * torque),
        one("back_emf", "coefficient", 0.2 * drag, 0.0),
        one("transport_delay", "delay", 1e-3, 0.0, 50.0, 0.5, 3.0),
        one("actuator_lag", "time_constant", 1e-3, 0.0, 200.0, 0.5, 3.0),
        one("temperature_viscosity", "temperature_coefficient", 0.01, -20.0, 20.0),
        _spring(axis, torque),
        _stribeck(axis, number),
        _resonance(axis),
        _backlash(axis, inertia),
        Family("cogging", axis, _ripple_knobs("amplitude", 0.02 * torque), (), ripple="torque"),
        Family("position_dependent_friction", axis, _ripple_knobs("relative_amplitude", 0.05), (), ripple="friction"),
    ]
    if peak > 0.0:
        found.append(_saturation(model, axis, records, i, peak))
    if number["friction.sigma0"] > 0.0:
        knobs = (Knob(("sigma0",), Move.FACTOR, 1.0, -4.0, 4.0), Knob(("sigma1",), Move.FACTOR, 1.0, -4.0, 4.0))
        found.append(Family("presliding", axis, knobs, (_plane(2, 0.1), _bent((1.0, 0.5)), _bent((-1.0, -0.5)))))
    elif number["friction.coulomb"] > 0.0:
        found.append(_first_bristle(axis, number["friction.coulomb"], speed))
    if not model.is_linear:
        cog = max(0.1 * float(np.linalg.norm([model.number(axis, f"body.cog.{c}") for c in "xyz"])), 1e-5)
        mass = model.number(axis, "body.mass")
        if mass > 0.0:
            found.append(Family("static_unbalance", axis, tuple(Knob((f"cog_{c}",), add, cog) for c in "xyz"), (_plane(3),)))
        eccentric = (Knob(("amplitude",), add, 1e-3, -_MOST_ECCENTRIC, _MOST_ECCENTRIC), Knob(("phase",), add, 1.0))
        at = Start(((1.0, 0.0), (1.0, 0.5 * math.pi)), (0.0, 0.0), Reading.POLAR)
        found.append(Family("encoder_eccentricity", axis, eccentric, (at,)))
    if len(model.axes) > 1:
        found.append(Family("dynamic_unbalance", axis, tuple(Knob((p,), add, 0.02 * inertia) for p in ("ixy", "ixz", "iyz")), (_plane(3),)))
    if all(r.has_gyro[i] for r in records):
        found += [one("gyro_bias", "bias", 1e-3), one("gyro_scale", "scale_error", 5e-3, -90.0, 90.0)]
        if len(model.axes) > 1:
            leaks = ("leak_x", "leak_y") if i == 0 else ("leak_x", "leak_z")
            found.append(Family("gyro_misalignment", axis, tuple(Knob((p,), add, 0.01, -45.0, 45.0) for p in leaks), (_plane(2),)))
    return [family for family in found if family.effect in CATALOGUE]


_PATHS = ("friction.coulomb", "friction.breakaway", "friction.viscous", "friction.sigma0", "friction.stribeck_velocity", "actuator.limit")


def _ripple_knobs(amplitude: str, size: float) -> tuple[Knob, ...]:
    return Knob((amplitude,), Move.ADD, size), Knob(("order",), Move.ADD, 1.0, 0.0), Knob(("phase",), Move.ADD, 1.0)


def _spring(axis: str, torque: float) -> Family:
    # the rest position acts through stiffness times angle: at a probe of one unit its response is the constant torque k q0
    knobs = (Knob(("stiffness",), Move.ADD, 0.05 * torque, 0.0), Knob(("rest_position",), Move.ADD, 1.0, -50.0, 50.0))
    start = Start(((1.0, 0.0), (1.0, 1.0)), (0.0, 0.0), Reading.SPRING)
    return Family("cable_spring", axis, knobs, (start,))


def _first_bristle(axis: str, coulomb: float, speed: float) -> Family:
    """A bristle for a model that has none: friction that turns over with the motion, within 0.1 to 100 ms of travel at speed."""
    knob = Knob(("sigma0",), Move.FACTOR, coulomb / (1e-3 * speed), -5.0, 3.0)
    return Family("presliding", axis, (knob,), tuple(_bent((float(x),)) for x in np.linspace(-4.6, 2.3, 8)))


def _stribeck(axis: str, number: dict[str, float]) -> Family:
    size = 0.1 * max(number["friction.breakaway"], 1e-9)
    knobs = (
        Knob(("breakaway",), Move.ADD, size),
        Knob(("stribeck_velocity",), Move.FACTOR, 1.0, -3.5, 3.5),
        Knob(("shape",), Move.FACTOR, 1.0, -0.7, 1.2),
    )
    starts = [_plane(3, 0.3)]
    for shift in (-0.7, 0.7, 1.4, 2.1, 3.0):
        starts.append(Start(((0.7, shift, 0.0),), (0.0, shift, 0.0)))
    return Family("stribeck", axis, knobs, tuple(starts))


def _saturation(model: AntennaModel, axis: str, records: tuple[Record, ...], i: int, peak: float) -> Family:
    limit = model.number(axis, "actuator.limit")
    reference = limit if 0.0 < limit < 1.2 * peak else 1.2 * peak
    levels = [
        float(np.quantile(np.concatenate([np.abs(r.torque[:, i]) for r in records]), p)) for p in (0.9, 0.96, 0.985, 0.994, 0.998, 0.9995)
    ]
    # short peaks: of a log that hardly ever asks for much, quantiles see the ordinary torque only
    levels += [share * peak for share in (0.5, 0.65, 0.8, 0.95)]
    knob = Knob(("limit",), Move.FACTOR, reference, -4.0, math.log(1.0))
    return Family("saturation", axis, (knob,), tuple(_bent((math.log(max(level, 1e-9) / reference),)) for level in levels))


def _resonance(axis: str) -> Family:
    knobs = (
        Knob(("antiresonance_frequency",), Move.ADD, 1.0, -49.0, 100.0),
        Knob(("damping_ratio",), Move.ADD, 0.02, -0.5, 20.0),
        Knob(("inertia_share",), Move.ADD, 0.05, 0.0, 15.0),
    )
    starts = []
    for hz in np.geomspace(4.0, 60.0, 20):
        at = float(hz) - 50.0
        starts.append(Start(((at, 0.75, 0.4),), (at, 0.75, 0.0)))
    return Family("structural_resonance", axis, knobs, tuple(starts))


def _backlash(axis: str, inertia: float) -> Family:
    knobs = (
        Knob(("gap",), Move.FACTOR, 1e-3, -5.0, 5.0),
        Knob(("rotor_inertia",), Move.FACTOR, 0.2 * inertia, -7.0, 2.0),
        Knob(("inertia",), Move.ADD, 0.05 * inertia),
        # how it bounces decides when the next flank is met; bounds keep the contact stable in the twin's steps
        Knob(("contact_frequency",), Move.FACTOR, 90.0, -1.2, 0.8),
        Knob(("contact_damping",), Move.FACTOR, 0.3, -2.0, 1.0),
    )
    # rotors that the model's inertia counts already, and rotors that come on top of it
    rotors = ((0.08, 1.0), (0.25, 1.0), (0.001, 0.0), (0.01, 0.0), (0.08, 0.0))
    starts = tuple(
        _bent((math.log(gap / 1e-3), math.log(share / 0.2), -counted * share / 0.05, 0.0, 0.0))
        for gap in (5e-4, 2e-3, 8e-3)
        for share, counted in rotors
    )
    # what a crossing takes is the gap times the rotor: each alone shows in its timing only
    return Family("backlash", axis, knobs, starts, valley=(0.15, -0.15, 0.0, 0.0, 0.0))
