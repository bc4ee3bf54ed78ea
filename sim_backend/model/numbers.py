"""Every number an axis of a model file may hold: its key, unit, bounds, default and place in the plant's parameters.

One table serves the file's validation, the plant's arrays and the effects that are such a number being wrong.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum

from sim_backend import layout


class SlotBase(IntEnum):
    """Which run of P a slot counts from."""

    AXIS = 0
    INERTIA = 1
    COG = 2
    MASS = 3
    #: used while building the arrays, holds no slot of its own
    BUILD = 4


@dataclass(frozen=True)
class Number:
    """One number of an axis; a default of None means that the file must give it, a path that it is as that number."""

    path: str
    unit: str
    linear_unit: str
    low: float
    high: float
    default: float | str | None
    block: SlotBase
    slot: int
    text: str

    def default_beside(self, number: Callable[[str], float]) -> float:
        """The default on an axis that has this `number` at a path."""
        return number(self.default) if isinstance(self.default, str) else self.default or 0.0

    def unit_for(self, linear: bool) -> str:
        """Unit on a rotary or linear axis."""
        return self.linear_unit if linear else self.unit


_A, _I, _C, _M, _B = SlotBase.AXIS, SlotBase.INERTIA, SlotBase.COG, SlotBase.MASS, SlotBase.BUILD
_BIG = 1e9
#: a travel limit that is none
ENDLESS = 1e4

AXIS_NUMBERS: tuple[Number, ...] = (
    Number("body.inertia.xx", "kg m2", "kg", 0.0, _BIG, 0.0, _I, layout.XX, "moment about x through the pivot"),
    Number("body.inertia.yy", "kg m2", "kg", 0.0, _BIG, 0.0, _I, layout.YY, "moment about y through the pivot"),
    Number(
        "body.inertia.zz",
        "kg m2",
        "kg",
        0.0,
        _BIG,
        0.0,
        _I,
        layout.ZZ,
        "moment about z through the pivot; a single axis turns about z",
    ),
    Number(
        "body.inertia.xy",
        "kg m2",
        "kg",
        -_BIG,
        _BIG,
        0.0,
        _I,
        layout.XY,
        "product of inertia as it stands in the tensor",
    ),
    Number(
        "body.inertia.xz",
        "kg m2",
        "kg",
        -_BIG,
        _BIG,
        0.0,
        _I,
        layout.XZ,
        "product of inertia as it stands in the tensor",
    ),
    Number(
        "body.inertia.yz",
        "kg m2",
        "kg",
        -_BIG,
        _BIG,
        0.0,
        _I,
        layout.YZ,
        "product of inertia as it stands in the tensor",
    ),
    Number("body.cog.x", "m", "m", -100.0, 100.0, 0.0, _C, 0, "centre of gravity from the pivot"),
    Number("body.cog.y", "m", "m", -100.0, 100.0, 0.0, _C, 1, "centre of gravity from the pivot"),
    Number("body.cog.z", "m", "m", -100.0, 100.0, 0.0, _C, 2, "centre of gravity from the pivot"),
    Number("body.mass", "kg", "kg", 0.0, _BIG, 0.0, _M, 0, "mass; on a linear axis what is accelerated"),
    Number(
        "friction.coulomb", "N m", "N", 0.0, _BIG, 0.0, _A, layout.TC, "Tc, sliding torque without the Stribeck bump"
    ),
    Number("friction.breakaway", "N m", "N", 0.0, _BIG, "friction.coulomb", _A, layout.TS, "Ts, torque at break-away"),
    Number("friction.stribeck_velocity", "rad/s", "m/s", 1e-9, 1e3, 0.01, _A, layout.VS, "v_s"),
    Number("friction.shape", "1", "1", 0.1, 20.0, 1.0, _A, layout.DELTA, "delta, exponent of the Stribeck curve"),
    Number(
        "friction.sigma0",
        "N m/rad",
        "N/m",
        0.0,
        1e12,
        0.0,
        _A,
        layout.SIGMA0,
        "bristle stiffness; 0 makes friction a static curve",
    ),
    Number("friction.sigma1", "N m s/rad", "N s/m", 0.0, 1e9, 0.0, _A, layout.SIGMA1, "bristle damping"),
    Number("friction.viscous", "N m s/rad", "N s/m", 0.0, 1e9, 0.0, _A, layout.SIGMA2, "sigma2"),
    Number("actuator.gain_error", "1", "1", -0.99, 10.0, 0.0, _A, layout.GAIN_ERROR, "e in T = (1 + e) u"),
    Number("actuator.offset", "N m", "N", -1e6, 1e6, 0.0, _A, layout.OFFSET, "o in T = u + o"),
    Number("actuator.limit", "N m", "N", 0.0, 1e9, 0.0, _A, layout.LIMIT, "largest torque; 0 means none"),
    Number(
        "actuator.torque_constant",
        "N m/A",
        "N/A",
        0.0,
        1e6,
        0.0,
        _B,
        -1,
        "torque per ampere, for logs in amperes; 0 means not known",
    ),
    Number("actuator.time_constant", "s", "s", 0.0, 10.0, 0.0, _B, -1, "first-order lag; 0 means none"),
    Number(
        "actuator.measurement_noise",
        "N m",
        "N",
        0.0,
        1e6,
        0.0,
        _A,
        layout.TORQUE_NOISE,
        "rms noise of the torque measured from motor current",
    ),
    Number("encoder.step", "rad", "m", 0.0, 1.0, 0.0, _A, layout.ENCODER_STEP, "one count; 0 means ideal"),
    Number("encoder.noise", "rad", "m", 0.0, 1.0, 0.0, _A, layout.ENCODER_NOISE, "rms"),
    Number(
        "gyro.bandwidth",
        "rad/s",
        "rad/s",
        0.0,
        1e5,
        0.0,
        _B,
        -1,
        "natural frequency of its second-order lag; 0 means no lag",
    ),
    Number("gyro.damping", "1", "1", 0.1, 10.0, 0.707, _B, -1, "damping ratio of that lag"),
    Number("gyro.bias", "rad/s", "m/s", -10.0, 10.0, 0.0, _A, layout.GYRO_BIAS, "added to the rate"),
    Number("gyro.scale_error", "1", "1", -0.9, 10.0, 0.0, _A, layout.GYRO_SCALE_ERROR, "s in (1 + s) rate"),
    Number("gyro.noise", "rad/s", "m/s", 0.0, 10.0, 0.0, _A, layout.GYRO_NOISE, "rms at the sample rate"),
    Number("gyro.step", "rad/s", "m/s", 0.0, 1.0, 0.0, _A, layout.GYRO_STEP, "one count; 0 means ideal"),
    Number("travel.low", "rad", "m", -ENDLESS, ENDLESS, -ENDLESS, _A, layout.STOP_LOW, "lower end of travel"),
    Number("travel.high", "rad", "m", -ENDLESS, ENDLESS, ENDLESS, _A, layout.STOP_HIGH, "upper end of travel"),
    Number(
        "travel.stiffness",
        "N m/rad",
        "N/m",
        0.0,
        1e9,
        0.0,
        _A,
        layout.STOP_STIFFNESS,
        "of the stops there; 0: only the drive keeps to them",
    ),
    Number("travel.damping", "N m s/rad", "N s/m", 0.0, 1e9, 0.0, _A, layout.STOP_DAMPING, "of the stops"),
    Number(
        "thermal.ambient",
        "degC",
        "degC",
        -100.0,
        300.0,
        20.0,
        _A,
        layout.AMBIENT,
        "temperature at the start and far from the motor",
    ),
    Number(
        "thermal.time_constant", "s", "s", 0.0, 1e6, 0.0, _A, layout.THERMAL_TIME_S, "0 means that temperature stays"
    ),
    Number("thermal.heating", "K/(N m)2/s", "K/N2/s", 0.0, 1e6, 0.0, _A, layout.HEATING, "warming per squared torque"),
    Number("start.position", "rad", "m", -1e4, 1e4, 0.0, _A, layout.START_POSITION, "where the motion starts"),
    Number("start.rate", "rad/s", "m/s", -1e3, 1e3, 0.0, _A, layout.START_RATE, "joint rate at the start"),
)

#: a body's moments and products of inertia, and its centre of gravity
MOMENTS, PRODUCTS = (tuple(f"body.inertia.{c}" for c in of) for of in (("xx", "yy", "zz"), ("xy", "xz", "yz")))
CENTRE = tuple(f"body.cog.{c}" for c in "xyz")
#: numbers that are components of one thing, and so are known alike
_TOGETHER = (CENTRE, PRODUCTS)

NUMBER_AT: dict[str, Number] = {number.path: number for number in AXIS_NUMBERS}
#: order of a friction row in a temperature table, as in the plant's layout
FRICTION_ROW = ("breakaway", "coulomb", "stribeck_velocity", "sigma0", "sigma1", "viscous", "shape")


def beside(path: str) -> tuple[str, ...]:
    """Paths of the components of what the number at `path` is one of; the path alone where it stands for itself."""
    return next((group for group in _TOGETHER if path in group), (path,))


def gyro_filter(
    bandwidth_rad_s: float, damping: float, step_s: float
) -> tuple[float, float, float, float, float, float]:
    """Exact zero-order-hold discretisation of x'' = wn^2 (u - x) - 2 zeta wn x': (a11, a12, a21, a22, b1, b2)."""
    wn, zeta, h = bandwidth_rad_s, damping, step_s
    decay = math.exp(-zeta * wn * h)
    split = zeta * zeta - 1.0
    if split < 0.0:
        wd = wn * math.sqrt(-split)
        c, s = math.cos(wd * h), math.sin(wd * h) / wd
    elif split > 0.0:
        wd = wn * math.sqrt(split)
        c, s = math.cosh(wd * h), math.sinh(wd * h) / wd
    else:
        c, s = 1.0, h
    a11, a12 = decay * (c + zeta * wn * s), decay * s
    a21, a22 = -wn * wn * a12, decay * (c - zeta * wn * s)
    return a11, a12, a21, a22, 1.0 - a11, -a21
