"""A list of segments as the host core takes it: numbers only, so that it can be recorded, sent and replayed bit for
bit.
"""

from __future__ import annotations

import base64
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import NoReturn

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.errors import BadInputError
from gimbal_hil.loop.control import Mode
from gimbal_hil.loop.host import layout
from gimbal_hil.loop.host.program_check import PARAMETER_COUNT, TABLES, require_program
from gimbal_hil.loop.host.states import AxisOff, EndKind, ReferenceOrigin, Shape, UnnamedAxis

#: a program of more numbers than this goes into JSON as base64: a person would not read them, and a machine reads them
#: 50 times faster
_MOST_LISTED = 2000
_INFINITE = {"inf": math.inf, "-inf": -math.inf}


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

    A TABLE gives its rows in `table` and (seconds per row, scale) as parameters, a TIMETABLE a first tick too.
    """

    mode: Mode = Mode.OFF
    shape: Shape = Shape.HOLD
    parameters: tuple[float, ...] = (0.0,)
    origin: ReferenceOrigin = ReferenceOrigin.ABSOLUTE
    guard: Guard = Guard()
    table: tuple[float, ...] | NDArray[np.float64] = ()


#: an axis that a plan does not name: what holds it is the host's to say
UNNAMED = AxisCommand(parameters=(float(AxisOff.UNNAMED),))


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
        """For JSON, exact: `values` with all their digits (infinities as text), or many of them as `float64_base64`
        (little endian).
        """
        if len(self.values) > _MOST_LISTED:
            return {
                "length": self.length,
                "float64_base64": base64.b64encode(self.values.astype("<f8").tobytes()).decode(),
            }
        return {"length": self.length, "values": [v if math.isfinite(v) else str(v) for v in self.values.tolist()]}

    @classmethod
    def from_document(cls, document: Mapping[str, object], where: str = "command") -> Program:
        """The program of `as_document`; BadInputError when it cannot be one."""
        length, packed, listed = document.get("length"), document.get("float64_base64"), document.get("values")
        if not isinstance(length, int) or isinstance(length, bool):
            raise BadInputError(f"{where}: length", "is no whole number", "how many segments the program has")
        try:
            if isinstance(packed, str):
                values = np.frombuffer(base64.b64decode(packed, validate=True), "<f8").astype(np.float64)
            elif isinstance(listed, list):
                values = np.array([_listed(v) for v in listed], dtype=np.float64)
            else:
                raise ValueError("neither values nor float64_base64")
        except (TypeError, ValueError, OverflowError) as error:
            raise BadInputError(where, f"is no program: {error!r}", "length, and values or float64_base64") from None
        require_program(values, length, where)
        return cls(values, length)

    def holding(self, unnamed: UnnamedAxis) -> NDArray[np.float64]:
        """Values in which axes that are not named are held as configured beside one that is under torque; where neither
        is, both stay off, as without a plan.
        """
        axes = self._axes(self.values)
        off = axes[:, :, layout.SEGMENT_MODE] == Mode.OFF
        waiting = off & (axes[:, :, layout.SHAPE_PARAMETERS] == AxisOff.UNNAMED)
        if not waiting.any():
            return self.values
        values = self.values.copy()
        axes, held = self._axes(values), waiting & ~off[:, ::-1]
        axes[waiting, layout.SHAPE_PARAMETERS] = AxisOff.FREE
        if unnamed is UnnamedAxis.BRAKE:
            axes[held, layout.SHAPE_PARAMETERS] = AxisOff.BRAKED
        elif unnamed is UnnamedAxis.POSITION:
            axes[held, layout.SEGMENT_MODE] = Mode.POSITION
            axes[held, layout.ORIGIN] = ReferenceOrigin.START
        return values

    def _axes(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """The blocks of both axes, a view (length, AXES, AXIS_SEGMENT_SIZE)."""
        segments = values[: self.length * layout.SEGMENT_SIZE].reshape(self.length, layout.SEGMENT_SIZE)
        return np.lib.stride_tricks.as_strided(
            segments[:, layout.AXIS_SEGMENT :],
            (self.length, layout.AXES, layout.AXIS_SEGMENT_SIZE),
            (segments.strides[0], layout.AXIS_SEGMENT_SIZE * values.itemsize, values.itemsize),
        )

    @property
    def record_every(self) -> set[int]:
        """Ticks between log rows that segments ask for, where they ask."""
        wanted = self.values[layout.RECORD_EVERY : self.length * layout.SEGMENT_SIZE : layout.SEGMENT_SIZE]
        return {int(every) for every in wanted if every > 0}

    def label(self, place: int) -> int:
        """Label of one segment."""
        return int(self.values[place * layout.SEGMENT_SIZE + layout.SEGMENT_ID])


def _listed(value: object) -> float:
    if isinstance(value, str):
        return _INFINITE[value] if value in _INFINITE else _refuse(value)
    return float(value) if isinstance(value, float | int) and not isinstance(value, bool) else _refuse(value)


def _refuse(value: object) -> NoReturn:
    raise ValueError(f"{value!r:.40} is no number")


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
        values[at + layout.RECORD_EVERY], values[at + layout.AFTERWARDS] = (
            segment.record_every,
            float(segment.switch_off_afterwards),
        )
        if len(segment.ends) > layout.END_CONDITIONS:
            raise BadInputError(
                f"segment {place}", f"{len(segment.ends)} end conditions", f"at most {layout.END_CONDITIONS}"
            )
        for k, end in enumerate(segment.ends):
            e = at + layout.END + k * layout.END_SIZE
            values[e : e + layout.END_SIZE] = end.kind, end.axis, end.threshold, end.hold_ticks
        for axis, command in enumerate((segment.outer, segment.inner)):
            s = at + layout.AXIS_SEGMENT + axis * layout.AXIS_SEGMENT_SIZE
            values[s : s + layout.AXIS_SEGMENT_SIZE] = _axis_values(
                command, free, f"segment {place}, {('outer', 'inner')[axis]}"
            )
            if command.shape in TABLES:
                tables.append(np.asarray(command.table, dtype=np.float64))
                free += len(tables[-1])
    if len({(segment.label, segment.record_every) for segment in segments}) > len(
        {segment.label for segment in segments}
    ):
        raise BadInputError(
            "plan", "segments of one label with different decimation", "one record_every for each label"
        )
    program = Program(np.ascontiguousarray(np.concatenate([values, *tables])), len(segments))
    require_program(program.values, program.length, "plan")
    return program


def _axis_values(command: AxisCommand, free: int, where: str) -> list[float]:
    parameters = list(command.parameters)
    if command.shape in TABLES:
        if len(command.table) == 0:
            raise BadInputError(where, "a table without rows", "one row or more")
        parameters = [float(free), float(len(command.table)), *parameters]
    if len(parameters) != PARAMETER_COUNT[command.shape]:
        raise BadInputError(
            where, f"{len(parameters)} parameters for {command.shape.name}", str(PARAMETER_COUNT[command.shape])
        )
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
