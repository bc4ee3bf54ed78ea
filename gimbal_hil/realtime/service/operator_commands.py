"""The requests of an operator: every one is checked to be one of these, with these keys and no others."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, TypeAdapter, ValidationError

from firmware_protocol.documents import Strict
from firmware_protocol.errors import BadInputError
from firmware_protocol.json_object import Json
from gimbal_hil.loop.control import Mode
from gimbal_hil.loop.host import AXIS_NAMES, UNNAMED, AxisCommand, Program, ReferenceOrigin, Segment, Shape, program_of

_MODES = {mode.name.lower(): mode for mode in Mode}
_SHAPES = {shape.name.lower(): shape for shape in Shape}
_ORIGINS = {origin.name.lower(): origin for origin in ReferenceOrigin}
ModeName = Literal["off", "torque", "rate", "position", "inertial_rate", "pointing"]
ShapeName = Literal["hold", "ramp", "sine", "chirp", "trapezoid", "smooth", "pulses", "table"]


class _Request(Strict):
    """Base of the requests."""


class _MotionRequest(_Request):
    """Base of what makes the antenna move. With `lease` the motion ends, braked to rest, when whoever asked is gone."""

    lease: bool = False


class SetPointRequest(_MotionRequest):
    """Both axes to a value in one mode and hold it: at once, or as a smooth move of `over_s` seconds."""

    command: Literal["set_point"]
    mode: ModeName
    outer: float = 0.0
    inner: float = 0.0
    over_s: float = Field(0.0, ge=0.0)

    def program(self, _period_s: float) -> Program:
        """One segment that never ends."""
        if self.mode == "pointing" and self.over_s > 0.0:
            expected = "0 in mode pointing: the joints go there as fast as they may"
            raise BadInputError("over_s (set --over)", f"is {self.over_s:g} s", expected)
        return program_of([Segment(self._axis(self.outer), self._axis(self.inner))])

    def _axis(self, value: float) -> AxisCommand:
        if self.over_s > 0.0:
            return AxisCommand(_MODES[self.mode], Shape.SMOOTH, (value, self.over_s))
        return AxisCommand(_MODES[self.mode], Shape.HOLD, (value,))


class ModeRequest(_MotionRequest):
    """Each axis to a mode, without a bump: it holds what it does when the mode begins."""

    command: Literal["mode"]
    outer: ModeName
    inner: ModeName

    def program(self, _period_s: float) -> Program:
        """One segment that never ends and counts from where each axis is."""
        outer, inner = (
            AxisCommand(_MODES[name], Shape.HOLD, (0.0,), ReferenceOrigin.START) for name in (self.outer, self.inner)
        )
        return program_of([Segment(outer, inner)])


class AxisRequest(_Request):
    """What one axis follows during a segment; parameters in the order that `gimbal_hil.loop.host.references` lists."""

    mode: ModeName = "off"
    shape: ShapeName = "hold"
    parameters: tuple[float, ...] = (0.0,)
    origin: Literal["absolute", "start"] = "absolute"
    table: tuple[float, ...] = ()

    def axis_command(self) -> AxisCommand:
        """The same for the host."""
        table = np.array(self.table, dtype=np.float64)
        parameters = self.parameters
        if self.mode == "off" and self.shape == "hold":
            # what an axis that is off holds is the host's own mark of an unnamed axis: nobody sets it from outside
            parameters = (0.0,) * len(parameters)
        return AxisCommand(_MODES[self.mode], _SHAPES[self.shape], parameters, _ORIGINS[self.origin], table=table)


class SegmentRequest(_Request):
    """One stretch; without `duration_s` it lasts until something else is asked."""

    outer: AxisRequest = AxisRequest()
    inner: AxisRequest = AxisRequest()
    duration_s: float = Field(0.0, ge=0.0)
    label: int = Field(0, ge=0)
    switch_off_afterwards: bool = False

    def axis_command(self, axis: str) -> AxisCommand:
        """What an axis follows; one that is not named is the host's to hold."""
        request: AxisRequest = getattr(self, axis)
        return request.axis_command() if axis in self.model_fields_set else UNNAMED


class SegmentsRequest(_MotionRequest):
    """Segments one after the other."""

    command: Literal["segments"]
    segments: list[SegmentRequest] = Field(min_length=1)

    def program(self, period_s: float) -> Program:
        """All segments with their tables."""
        return program_of(
            [
                Segment(
                    request.axis_command("outer"),
                    request.axis_command("inner"),
                    round(request.duration_s / period_s),
                    label=request.label,
                    switch_off_afterwards=request.switch_off_afterwards,
                )
                for request in self.segments
            ]
        )


class StartRequest(_MotionRequest):
    """A program as `Program.as_document` gives it: how experiments hand in what they have compiled."""

    command: Literal["start"]
    document: Json = Field(alias="program")
    #: also record where the host stands, so that a run that begins here can be computed again
    with_image: bool = False

    def program(self, _period_s: float) -> Program:
        """The program, checked."""
        return Program.from_document(self.document)


class PlainRequest(_Request):
    """A request without parameters."""

    command: Literal[
        "stop",
        "quick_stop",
        "fault_reset",
        "shut_down",
        "status",
        "adjustable",
        "adjust_back",
        "learn_anew",
        "renew",
        "release",
    ]


class AdjustRequest(_Request):
    """Other gains and limits: for each axis keys as `rate_loop.kp_s_per_rad` with their values."""

    command: Literal["adjust"]
    outer: dict[str, float] = Field(default={})
    inner: dict[str, float] = Field(default={})

    def changes(self, axes: Sequence[str]) -> dict[str, dict[str, float]]:
        """Axis, key, value."""
        return {axis: values for axis, values in zip(axes, (self.outer, self.inner), strict=True) if values}


ProgramRequest = SetPointRequest | ModeRequest | SegmentsRequest | StartRequest
Request = ProgramRequest | PlainRequest | AdjustRequest
_REQUEST: TypeAdapter[Request] = TypeAdapter(Annotated[Request, Field(discriminator="command")])


def parse_request(line: Json, axes: Sequence[str] = AXIS_NAMES) -> Request:
    """The request in a line (its `id` aside), which calls the axes by their names; BadInputError in one line that names
    the key.
    """
    try:
        asked = {key: value for key, value in line.items() if key != "id"}
        if isinstance(asked.get("segments"), list):
            asked["segments"] = [_by_place(one, axes) for one in asked["segments"]]
        return _REQUEST.validate_python(_by_place(asked, axes))
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        own = dict(zip(AXIS_NAMES, axes, strict=True))
        where = ".".join(own.get(str(part), str(part)) for part in first["loc"]) or "command"
        raise BadInputError(where, str(first["msg"])) from None


def _by_place(asked: Any, axes: Sequence[str]) -> Any:
    """A request whose axes have the names of the fields above; a name that is not this antenna's stays, and is refused
    as unknown.
    """
    if not isinstance(asked, dict) or tuple(axes) == AXIS_NAMES:
        return asked
    places = dict(zip(axes, AXIS_NAMES, strict=True))
    unknown = {name: f"{name} (expected {' or '.join(axes)})" for name in AXIS_NAMES if name not in axes}
    return {places.get(key, unknown.get(key, key)): value for key, value in asked.items()}
