"""A list of segments as the host core takes it: numbers only, so that it can be recorded, sent and replayed bit for bit."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.errors import BadInputError
from gimbal_hil.control.layout import Mode
from gimbal_hil.host import layout
from gimbal_hil.host.states import EndKind, Origin, Shape

_PARAMETER_COUNT = {
    Shape.HOLD: 1,
    Shape.RAMP: 3,
    Shape.SINE: 4,
    Shape.CHIRP: 5,
    Shape.TRAPEZOID: 3,
    Shape.SMOOTH: 2,
    Shape.PULSES: 6,
    Shape.TABLE: 4,
}


@dataclass(frozen=True, slots=True)
class Guard:
    """What an axis is allowed while a segment runs: position (rad), size of joint rate (rad/s) and of torque (N m)."""

    low_rad: float = -math.inf
    high_rad: float = math.inf
    rate_rad_s: float = math.inf
    torque_nm: float = math.inf


@dataclass(frozen=True, slots=True)
class AxisCommand:
    """What one axis follows: a mode and a reference shape; parameters as listed in `references`, in the mode's unit.

    A TABLE gives its rows in `table` and (seconds per row, scale) as parameters.
    """

    mode: Mode = Mode.OFF
    shape: Shape = Shape.HOLD
    parameters: tuple[float, ...] = (0.0,)
    origin: Origin = Origin.ABSOLUTE
    guard: Guard = Guard()
    table: tuple[float, ...] | NDArray[np.float64] = ()


@dataclass(frozen=True, slots=True)
class EndCondition:
    """Ends a segment once it has held for `hold_ticks` ticks in a row."""

    kind: EndKind
    axis: int
    threshold: float
    hold_ticks: int = 1


@dataclass(frozen=True, slots=True)
class Segment:
    """One stretch of a run. `duration_ticks` 0 has no end; `record_every` 0 leaves the decimation to the recording."""

    outer: AxisCommand = field(default_factory=AxisCommand)
    inner: AxisCommand = field(default_factory=AxisCommand)
    duration_ticks: int = 0
    ends: tuple[EndCondition, ...] = ()
    label: int = 0
    record_every: int = 0
    switch_off_afterwards: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Program:
    """Segments compiled to one float64 array, tables behind them; `length` segments."""

    values: NDArray[np.float64]
    length: int

    def as_document(self) -> dict[str, object]:
        """For JSON: exact, since floats are written with all their digits (infinities as text)."""
        return {"length": self.length, "values": [v if math.isfinite(v) else str(v) for v in self.values.tolist()]}

    @classmethod
    def from_document(cls, document: dict[str, object], where: str = "command") -> Program:
        """The program of `as_document`; BadInputError when it cannot be one."""
        try:
            values = np.array([float(v) for v in document["values"]], dtype=np.float64)  # type: ignore[attr-defined]
            length = int(document["length"])  # type: ignore[call-overload]
        except (KeyError, TypeError, ValueError) as error:
            raise BadInputError(where, f"is no program: {error!r}", "length and values") from None
        _check(values, length, where)
        return cls(values, length)

    def label(self, place: int) -> int:
        """Label of one segment."""
        return int(self.values[place * layout.SEGMENT_SIZE + layout.SEGMENT_ID])


def program_of(segments: Sequence[Segment]) -> Program:
    """Segments as arrays; BadInputError names the segment and what is wrong with it."""
    if not segments:
        raise BadInputError("plan", "holds no segment", "one or more")
    values = np.zeros(len(segments) * layout.SEGMENT_SIZE)
    tables: list[NDArray[np.float64]] = []
    free = len(values)
    for place, segment in enumerate(segments):
        at = place * layout.SEGMENT_SIZE
        values[at + layout.SEGMENT_ID], values[at + layout.DURATION_TICKS] = segment.label, segment.duration_ticks
        values[at + layout.RECORD_EVERY], values[at + layout.AFTERWARDS] = segment.record_every, float(segment.switch_off_afterwards)
        if len(segment.ends) > layout.END_CONDITIONS:
            raise BadInputError(f"segment {place}", f"{len(segment.ends)} end conditions", f"at most {layout.END_CONDITIONS}")
        for k, end in enumerate(segment.ends):
            e = at + layout.END + k * layout.END_SIZE
            values[e : e + layout.END_SIZE] = end.kind, end.axis, end.threshold, end.hold_ticks
        for axis, command in enumerate((segment.outer, segment.inner)):
            s = at + layout.AXIS_SEGMENT + axis * layout.AXIS_SEGMENT_SIZE
            values[s : s + layout.AXIS_SEGMENT_SIZE] = _axis_values(command, free, f"segment {place}, {('outer', 'inner')[axis]}")
            if command.shape is Shape.TABLE:
                tables.append(np.asarray(command.table, dtype=np.float64))
                free += len(tables[-1])
    if len({(segment.label, segment.record_every) for segment in segments}) > len({segment.label for segment in segments}):
        raise BadInputError("plan", "segments of one label with different decimation", "one record_every for each label")
    program = Program(np.ascontiguousarray(np.concatenate([values, *tables])), len(segments))
    _check(program.values, program.length, "plan")
    return program


def _axis_values(command: AxisCommand, free: int, where: str) -> list[float]:
    parameters = list(command.parameters)
    if command.shape is Shape.TABLE:
        if len(command.table) == 0:
            raise BadInputError(where, "a table without rows", "one row or more")
        parameters = [float(free), float(len(command.table)), *parameters]
    if len(parameters) != _PARAMETER_COUNT[command.shape]:
        raise BadInputError(where, f"{len(parameters)} parameters for {command.shape.name}", str(_PARAMETER_COUNT[command.shape]))
    guard = command.guard
    padded = parameters + [0.0] * (layout.MAX_SHAPE_PARAMETERS - len(parameters))
    return [
        float(command.mode),
        float(command.shape),
        float(command.origin),
        *padded,
        guard.low_rad,
        guard.high_rad,
        guard.rate_rad_s,
        guard.torque_nm,
    ]


def _check(values: NDArray[np.float64], length: int, where: str) -> None:
    """Refuse what the core could not follow: it indexes with these numbers, and it must never see a NaN."""
    size = layout.SEGMENT_SIZE
    if length < 1 or len(values) < length * size or np.any(np.isnan(values)):
        raise BadInputError(where, "is no program", "whole segments without NaN")
    if not np.all(np.isfinite(values[length * size :])):
        raise BadInputError(where, "a table holds infinite numbers", "finite numbers")
    for place in range(length):
        at, name = place * size, f"{where}: segment {place}"
        _check_header(values[at : at + layout.AXIS_SEGMENT], name)
        for axis in range(layout.AXES):
            s = at + layout.AXIS_SEGMENT + axis * layout.AXIS_SEGMENT_SIZE
            _check_axis(values[s : s + layout.AXIS_SEGMENT_SIZE], len(values), length * size, name)


def _check_header(header: NDArray[np.float64], name: str) -> None:
    whole = (layout.SEGMENT_ID, layout.DURATION_TICKS, layout.RECORD_EVERY)
    if not np.all(np.isfinite(header)) or any(header[k] != np.floor(header[k]) or not 0 <= header[k] < 2**53 for k in whole[1:]):
        raise BadInputError(name, "duration or decimation out of range", "whole numbers of ticks, 0 or more")
    if not 0 <= header[layout.SEGMENT_ID] < 2**31 or header[layout.SEGMENT_ID] % 1:
        raise BadInputError(name, f"label {header[layout.SEGMENT_ID]:g}", "a whole number from 0 to 2^31 - 1")
    for k in range(layout.END_CONDITIONS):
        kind, axis, _, hold = header[layout.END + k * layout.END_SIZE :][: layout.END_SIZE]
        if kind not in list(EndKind) or axis not in (0, 1) or hold < 0:
            raise BadInputError(name, "an end condition that does not exist", "a kind, an axis, a threshold")


def _check_axis(block: NDArray[np.float64], size: int, tables: int, name: str) -> None:
    mode, shape, origin = block[: layout.SHAPE_PARAMETERS]
    p = block[layout.SHAPE_PARAMETERS :]
    if mode not in list(Mode) or shape not in list(Shape) or origin not in list(Origin):
        raise BadInputError(name, "a mode, shape or origin that does not exist", "one of the lists in gimbal_hil.host")
    finite = [v for k, v in enumerate(p[: _PARAMETER_COUNT[Shape(int(shape))]]) if not (shape == Shape.RAMP and k == 2)]
    if not np.all(np.isfinite(finite)):
        raise BadInputError(name, "an infinite parameter", "finite numbers")
    positive = {Shape.TRAPEZOID: (1, 2), Shape.SMOOTH: (1,), Shape.PULSES: (2, 3), Shape.CHIRP: (2, 4), Shape.TABLE: (2,), Shape.SINE: (2,)}
    if any(p[k] <= 0.0 for k in positive.get(Shape(int(shape)), ())):
        raise BadInputError(name, f"{Shape(int(shape)).name} with a time, rate or frequency that is not positive", "positive numbers")
    if shape == Shape.TABLE and not (tables <= p[0] and p[1] >= 1 and p[0] + p[1] <= size and p[0] % 1 == 0 and p[1] % 1 == 0):
        raise BadInputError(name, "a table outside the program", "rows behind the segments")
