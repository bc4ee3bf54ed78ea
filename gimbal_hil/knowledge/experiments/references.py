"""Reference shapes as a plan file writes them: quantities carry the unit of the mode they are for in their key.

In mode `position` a value is `value_rad` and a slope `slope_rad_s`; in `rate` and `inertial_rate` they are
`value_rad_s` and `slope_rad_s2`; in `torque` `value_nm` and `slope_nm_s`. A key with another mode's unit is refused.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import Annotated, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, TypeAdapter

from firmware_protocol.documents import Strict
from firmware_protocol.errors import BadInputError
from gimbal_hil.loop.control import Mode
from gimbal_hil.loop.host import AxisCommand, Guard, ReferenceOrigin, Shape

#: unit of a value, of its slope and of its curvature
UNITS: dict[Mode, tuple[str, str, str]] = {
    Mode.TORQUE: ("nm", "nm_s", "nm_s2"),
    Mode.RATE: ("rad_s", "rad_s2", "rad_s3"),
    Mode.INERTIAL_RATE: ("rad_s", "rad_s2", "rad_s3"),
    Mode.POSITION: ("rad", "rad_s", "rad_s2"),
    Mode.POINTING: ("rad", "rad_s", "rad_s2"),
}
#: rows of a table times the sines in it: 160 MB while it is computed
_MOST_ROWS = 20_000_000
_EVERY_UNIT = {unit for units in UNITS.values() for unit in units}
Positive = Annotated[float, Field(gt=0.0)]


class Reference(Strict):
    """Base of the shapes; names of quantities stand without unit here, see `without_units`."""

    #: quantities by how often they are differentiated
    quantities: ClassVar[dict[str, int]] = {}
    from_start: bool = Field(
        default=False,
        description=(
            "count from where the axis is when the segment starts (or from the reference before it), not from zero"
        ),
    )

    @abstractmethod
    def host_shape(self, step_s: float) -> tuple[Shape, tuple[float, ...], NDArray[np.float64]]:
        """Shape, parameters in the host's order, and the rows of a table."""

    def command(self, mode: Mode, guard: Guard, step_s: float) -> AxisCommand:
        """What the host follows."""
        shape, parameters, table = self.host_shape(step_s)
        origin = ReferenceOrigin.START if self.from_start else ReferenceOrigin.ABSOLUTE
        return AxisCommand(mode, shape, parameters, origin, guard, table)


_NO_TABLE = np.zeros(0)


class Hold(Reference):
    """One value."""

    quantities: ClassVar[dict[str, int]] = {"value": 0}
    shape: Literal["hold"] = "hold"
    value: float = Field(default=0.0, description="what is held")

    def host_shape(self, step_s: float) -> tuple[Shape, tuple[float, ...], NDArray[np.float64]]:
        return Shape.HOLD, (self.value,), _NO_TABLE


class Ramp(Reference):
    """A constant slope; it ends `span` from where it began, if given."""

    quantities: ClassVar[dict[str, int]] = {"value": 0, "slope": 1, "span": 0}
    shape: Literal["ramp"]
    value: float = Field(default=0.0, description="where it begins")
    slope: float = Field(description="its slope")
    span: Positive | None = Field(default=None, description="how far it goes; for ever without it")

    def host_shape(self, step_s: float) -> tuple[Shape, tuple[float, ...], NDArray[np.float64]]:
        return Shape.RAMP, (self.value, self.slope, math.inf if self.span is None else self.span), _NO_TABLE


class Sine(Reference):
    """A sine about a value."""

    quantities: ClassVar[dict[str, int]] = {"value": 0, "amplitude": 0}
    shape: Literal["sine"]
    value: float = Field(default=0.0, description="middle")
    amplitude: float = Field(description="amplitude")
    frequency_hz: Positive = Field(description="frequency")
    phase_rad: float = Field(default=0.0, description="phase at the start")

    def host_shape(self, step_s: float) -> tuple[Shape, tuple[float, ...], NDArray[np.float64]]:
        return Shape.SINE, (self.value, self.amplitude, self.frequency_hz, self.phase_rad), _NO_TABLE


class Chirp(Reference):
    """A sine whose frequency goes from first to last, the same time for each octave."""

    quantities: ClassVar[dict[str, int]] = {"value": 0, "amplitude": 0}
    shape: Literal["chirp"]
    value: float = Field(default=0.0, description="middle")
    amplitude: float = Field(description="amplitude")
    first_hz: Positive = Field(description="frequency at the start")
    last_hz: Positive = Field(description="frequency at the end")
    sweep_s: Positive = Field(description="time from first to last")

    def host_shape(self, step_s: float) -> tuple[Shape, tuple[float, ...], NDArray[np.float64]]:
        growth = math.log(self.last_hz / self.first_hz) / self.sweep_s
        return Shape.CHIRP, (self.value, self.amplitude, self.first_hz, growth, self.sweep_s), _NO_TABLE


class Trapezoid(Reference):
    """The fastest move to a target within a largest slope and curvature."""

    quantities: ClassVar[dict[str, int]] = {"target": 0, "largest_slope": 1, "largest_curvature": 2}
    shape: Literal["trapezoid"]
    target: float = Field(description="where it ends")
    largest_slope: Positive = Field(description="largest slope")
    largest_curvature: Positive = Field(description="largest curvature")

    def host_shape(self, step_s: float) -> tuple[Shape, tuple[float, ...], NDArray[np.float64]]:
        return Shape.TRAPEZOID, (self.target, self.largest_slope, self.largest_curvature), _NO_TABLE


class Smooth(Reference):
    """A move of least jerk to a target in a given time."""

    quantities: ClassVar[dict[str, int]] = {"target": 0}
    shape: Literal["smooth"]
    target: float = Field(description="where it ends")
    over_s: Positive = Field(description="duration of the move")

    def host_shape(self, step_s: float) -> tuple[Shape, tuple[float, ...], NDArray[np.float64]]:
        return Shape.SMOOTH, (self.target, self.over_s), _NO_TABLE


class Pulses(Reference):
    """Pulses on a value, every other one negative if alternating."""

    quantities: ClassVar[dict[str, int]] = {"value": 0, "amplitude": 0}
    shape: Literal["pulses"]
    value: float = Field(default=0.0, description="between the pulses")
    amplitude: float = Field(description="of a pulse, added to the value")
    period_s: Positive = Field(description="from pulse to pulse")
    width_s: Positive = Field(description="length of a pulse")
    alternating: bool = Field(default=False, description="every other one is negative")
    count: Annotated[int, Field(ge=1)] | None = Field(default=None, description="how many; without end without it")

    def host_shape(self, step_s: float) -> tuple[Shape, tuple[float, ...], NDArray[np.float64]]:
        count = float(self.count or 2**40)
        return (
            Shape.PULSES,
            (self.value, self.amplitude, self.period_s, self.width_s, float(self.alternating), count),
            _NO_TABLE,
        )


class TableReference(Reference):
    """Values at equal times, joined by straight lines."""

    quantities: ClassVar[dict[str, int]] = {"values": 0}
    shape: Literal["table"]
    values: Annotated[tuple[float, ...], Field(min_length=1)] = Field(description="the values, at equal times")
    row_s: Positive = Field(description="time between two of them")
    scale: float = Field(default=1.0, description="factor on all of them")

    def host_shape(self, step_s: float) -> tuple[Shape, tuple[float, ...], NDArray[np.float64]]:
        return Shape.TABLE, (self.row_s, self.scale), np.array(self.values)


class Multisine(Reference):
    """`lines` sines at multiples of 1/period from first to last, with phases that keep the peak low (Schroeder 1970),
    for `periods`.
    """

    quantities: ClassVar[dict[str, int]] = {"value": 0, "amplitude": 0}
    shape: Literal["multisine"]
    value: float = Field(default=0.0, description="middle")
    amplitude: Positive = Field(description="largest size of the sum")
    first_hz: Positive = Field(description="lowest frequency")
    last_hz: Positive = Field(description="highest frequency")
    lines: Annotated[int, Field(ge=1)] = Field(description="how many sines")
    period_s: Positive = Field(description="period that all of them share")
    periods: Annotated[int, Field(ge=1)] = Field(default=1, description="how often it is repeated")

    def host_shape(self, step_s: float) -> tuple[Shape, tuple[float, ...], NDArray[np.float64]]:
        rows = self.period_s / step_s * max(self.periods, self.lines)
        if rows > _MOST_ROWS:
            most_s = _MOST_ROWS * step_s
            raise BadInputError(
                "multisine", f"{rows:g} numbers to compute", f"period_s times periods, and times lines, of {most_s:g} s"
            )
        orders = np.unique(
            np.round(np.geomspace(self.first_hz, self.last_hz, self.lines) * self.period_s).astype(np.int64)
        )
        orders = orders[orders > 0]
        times = step_s * np.arange(max(1, round(self.period_s / step_s)))
        phases = -math.pi * np.arange(len(orders)) * (np.arange(len(orders)) + 1) / max(1, len(orders))
        wave = np.sin(2.0 * math.pi / self.period_s * np.outer(times, orders) + phases).sum(axis=1)
        largest = float(np.abs(wave).max()) or 1.0
        period = self.value + wave * (self.amplitude / largest)
        return Shape.TABLE, (step_s, 1.0), np.append(np.tile(period, self.periods), period[0])


AnyReference = Annotated[
    Hold | Ramp | Sine | Chirp | Trapezoid | Smooth | Pulses | TableReference | Multisine,
    Field(discriminator="shape"),
]
ANY_REFERENCE: TypeAdapter[object] = TypeAdapter(AnyReference)
SHAPES: dict[str, type[Reference]] = {
    "hold": Hold,
    "ramp": Ramp,
    "sine": Sine,
    "chirp": Chirp,
    "trapezoid": Trapezoid,
    "smooth": Smooth,
    "pulses": Pulses,
    "table": TableReference,
    "multisine": Multisine,
}


def without_units(section: dict[str, object], mode: Mode) -> dict[str, object]:
    """A reference's keys with the unit of `mode` taken off; ValueError names the key that should stand there
    instead.
    """
    kind = SHAPES.get(str(section.get("shape", "hold")))
    if kind is None or mode not in UNITS:
        return section
    plain: dict[str, object] = {}
    for key, value in section.items():
        name = next(
            (name for name in kind.quantities if key == name or key.removeprefix(name + "_") in _EVERY_UNIT), None
        )
        if name is not None:
            wanted = f"{name}_{UNITS[mode][kind.quantities[name]]}"
            if key != wanted:
                raise ValueError(f"{key} in mode {mode.name.lower()}: expected {wanted}")
            key = name
        plain[key] = value
    return plain
