"""Random antennas, plans and seeds: everything that a model file can say, drawn from one seed."""

from __future__ import annotations

import copy
import math
from typing import Any

import numpy as np

from gimbal_hil.loop.host import AxisCommand, EndCondition, EndKind, Guard, Mode, ReferenceOrigin, Segment, Shape
from sim_backend.effects import CATALOGUE
from sim_backend.effects.effect import Effect
from sim_backend.effects.parameter import Parameter
from sim_backend.model import AntennaModel, model_from_document, shipped_model
from sim_backend.model.numbers import AXIS_NUMBERS

_SHIPPED = shipped_model()
_BODY = ("body.inertia", "body.cog", "body.mass")
#: numbers that a model may have or not, with their sizes
_OPTIONAL = {
    "actuator.gain_error": 0.05,
    "actuator.offset": 0.02,
    "actuator.time_constant": 2e-3,
    "encoder.noise": 1e-5,
    "gyro.bandwidth": 900.0,
    "gyro.bias": 1e-3,
    "gyro.scale_error": 0.01,
    "gyro.noise": 1e-3,
    "thermal.time_constant": 20.0,
    "thermal.heating": 0.5,
    "start.position": 0.3,
    "start.rate": 0.05,
}
_LARGEST = {
    "N m": 0.1,
    "N m s/rad": 0.1,
    "s": 4e-3,
    "rad": 1e-2,
    "Hz": 60.0,
    "1/turn": 60.0,
    "kg m2": 0.05,
    "1/K": 0.02,
    "N m/rad": 1.0,
}


def random_model(seed: int) -> AntennaModel:
    """A two-axis antenna, or one in four times a single axis: other bodies and friction, sensors, stops, heat, base,
    slips, effects.
    """
    rng = np.random.default_rng(seed)
    document: dict[str, Any] = copy.deepcopy(_SHIPPED.document) | {"effects": []}
    if rng.random() < 0.25:
        document["kind"] = str(rng.choice(["rotary", "linear"]))
        document["axes"] = {"outer": document["axes"]["outer"]}
        document["incline_sine"] = float(rng.choice([0.0, 0.02, 1.0 if document["kind"] == "rotary" else 0.05]))
    else:
        document["gravity_reading"] = str(rng.choice(["separate_bodies", "total_mass"]))
        document["base"] = _base(rng)
        if rng.random() < 0.1:
            document["thesis_slips"] = [
                str(rng.choice(["missing_elevation_rate", "inner_friction_on_outer", "gravity_row"]))
            ]
    for axis in document["axes"].values():
        _vary(axis, rng)
    hooks = [effect for effect in CATALOGUE.values() if not effect.is_number]
    for _ in range(int(rng.choice([0, 0, 1, 2, 5]))):
        effect = hooks[int(rng.integers(len(hooks)))]
        if document["kind"] == "gimbal" or not (effect.two_axis_only or effect.rotary_only):
            document["effects"].append(
                {"name": effect.name, "axis": str(rng.choice(list(document["axes"]))), **_strength(effect, rng)}
            )
    return model_from_document(document, f"random {seed}")


def random_segments(seed: int, longest: int) -> list[Segment]:
    """One to five segments of up to `longest` ticks, any mode and shape, with ends, guards and decimation."""
    rng = np.random.default_rng(seed + 1_000_000)
    segments = []
    for label in range(int(rng.integers(1, 6))):
        ends = (
            (EndCondition(EndKind.RATE_ABOVE, int(rng.integers(2)), float(rng.uniform(0.1, 3.0)), 3),)
            if rng.random() < 0.3
            else ()
        )
        outer, inner = _directions(rng) if rng.random() < 0.15 else (_command(rng), _command(rng))
        segments.append(
            Segment(
                outer,
                inner,
                int(rng.integers(1, longest + 1)),
                ends,
                label,
                int(rng.choice([0, 0, 3])),
                bool(rng.random() < 0.2),
            )
        )
    return segments


def _vary(axis: dict[str, Any], rng: np.random.Generator) -> None:
    """Other numbers for one axis of a document, in place."""
    scale = float(rng.uniform(0.5, 2.0))
    for number in AXIS_NUMBERS:
        *path, key = number.path.split(".")
        section = axis
        for part in path:
            section = section.setdefault(part, {})
        given = section.get(key)
        # without its unit, which is another one on a linear axis
        value = section[key] = given["value"] if isinstance(given, dict) else given
        if value is None:
            del section[key]
        if value is not None and number.path.startswith(_BODY):
            # one factor for the whole body, so that its tensor stays that of a body
            section[key] = value * scale
        elif value is not None and number.path.startswith("friction"):
            section[key] = value * float(rng.uniform(0.5, 1.5))
        elif number.path in _OPTIONAL and rng.random() < 0.3:
            signed = number.path.endswith(("error", "offset", "bias", "position", "rate"))
            section[key] = _OPTIONAL[number.path] * float(rng.uniform(-1.0 if signed else 0.1, 1.0))
    friction = axis["friction"]
    friction["breakaway"] = max(friction["breakaway"], friction["coulomb"])
    if rng.random() < 0.1:
        friction["sigma0"] = 0.0
    if rng.random() < 0.3:
        axis["travel"] = {
            "low": -0.4,
            "high": 0.4,
            "stiffness": float(rng.uniform(50.0, 500.0)),
            "damping": float(rng.uniform(0.0, 5.0)),
        }


def _base(rng: np.random.Generator) -> dict[str, Any]:
    def three(names: str, low: float, high: float) -> dict[str, float]:
        return {name: float(rng.uniform(low, high)) for name in names.split()}

    angles = "roll pitch yaw"
    motion = str(rng.choice(["fixed", "fixed", "fixed", "constant_rate", "case", "sinusoid"]))
    base: dict[str, Any] = {"motion": motion}
    if motion == "case":
        return base | {"table": "3.2", "case": int(rng.integers(1, 5))}
    if motion != "fixed" or rng.random() < 0.3:
        base["attitude_rad"] = three(angles, -0.3, 0.3)
    if motion == "constant_rate":
        base["rate_rad_s"] = three("p q r", -0.5, 0.5)
    if motion == "sinusoid":
        base |= {
            "amplitude_rad": three(angles, 0.0, 0.2),
            "frequency_hz": three(angles, 0.1, 2.0),
            "phase_rad": three(angles, -3.0, 3.0),
        }
    return base


def _strength(effect: Effect, rng: np.random.Generator) -> dict[str, float]:
    return {parameter.name: _amount(parameter, rng) for parameter in effect.parameters}


def _amount(parameter: Parameter, rng: np.random.Generator) -> float:
    if rng.random() < 0.1:
        return parameter.neutral
    most = min(parameter.high, _LARGEST.get(parameter.unit, 0.3))
    if parameter.periodic:
        return float(rng.uniform(-math.pi, math.pi))
    return float(rng.uniform(max(parameter.low, 0.0), max(most, parameter.low * 1.5)))


def _command(rng: np.random.Generator) -> AxisCommand:
    def number(low: float, high: float) -> float:
        return float(rng.uniform(low, high))

    value, time_s, positive = number(-0.5, 0.5), number(0.02, 0.3), number(0.1, 5.0)
    shape = Shape(int(rng.choice([int(s) for s in Shape])))
    table: tuple[float, ...] = ()
    parameters: tuple[float, ...] = {
        Shape.HOLD: (value,),
        Shape.RAMP: (value, number(-0.5, 0.5), positive),
        Shape.SINE: (value, number(-0.5, 0.5), positive, value),
        Shape.CHIRP: (value, number(-0.5, 0.5), positive, value, time_s),
        Shape.TRAPEZOID: (value, positive, positive),
        Shape.SMOOTH: (value, time_s),
        Shape.PULSES: (value, number(-0.5, 0.5), time_s, 0.5 * time_s, float(rng.integers(2)), 9.0),
        Shape.TABLE: (time_s, positive),
        Shape.TIMETABLE: (time_s, positive, float(rng.choice([-1.0, 100.0, 1000.0]))),
    }[shape]
    if shape in (Shape.TABLE, Shape.TIMETABLE):
        table = tuple(rng.uniform(-0.5, 0.5, int(rng.integers(1, 20))).tolist())
    guard = Guard(rate_rad_s=number(0.5, 5.0)) if rng.random() < 0.2 else Guard()
    mode, origin = (
        Mode(int(rng.choice([int(m) for m in Mode if m is not Mode.POINTING]))),
        ReferenceOrigin(int(rng.integers(2))),
    )
    return AxisCommand(mode, shape, parameters, origin, guard, table)


def _directions(rng: np.random.Generator) -> tuple[AxisCommand, AxisCommand]:
    """Both axes in mode pointing, from hardly any elevation to beyond the zenith."""
    azimuth, elevation = float(rng.uniform(-3.0, 3.0)), float(rng.uniform(-1.7, 0.3))
    kind = int(rng.integers(3))
    if kind == 0:
        shapes = [(Shape.HOLD, (azimuth,)), (Shape.HOLD, (elevation,))]
    elif kind == 1:
        shapes = [(Shape.RAMP, (azimuth, 0.3, 5.0)), (Shape.RAMP, (elevation, 0.1, 5.0))]
    else:
        first = float(rng.choice([-1.0, 100.0]))
        outer, inner = (
            AxisCommand(
                Mode.POINTING,
                Shape.TIMETABLE,
                (0.05, 1.0, first),
                table=tuple((start + rng.uniform(-0.1, 0.1, 12)).tolist()),
            )
            for start in (azimuth, elevation)
        )
        return outer, inner
    outer, inner = (AxisCommand(Mode.POINTING, shape, parameters) for shape, parameters in shapes)
    return outer, inner
