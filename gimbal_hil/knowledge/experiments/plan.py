"""Plans as data: a YAML file of segments, validated, and compiled to what the host follows.

    schema: 1
    name: two speeds
    segments:
      - {name: to the start, outer: {mode: position, shape: smooth, target_rad: 0.0, over_s: 2.0}, duration_s: 2.5}
      - name: slow
        outer: {mode: rate, value_rad_s: 0.01}
        inner: {mode: position, from_start: true}
        duration_s: 30.0
        end: [{axis: outer, position_above_rad: 1.3}]
        guards: {outer: {rate_rad_s: 0.5}}
        measure: true

An axis that is not named beside one that is, is held as `supervisor.unnamed_axis` says. The axes have the names of the
model file, or `outer` (which carries) and `inner`.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, ValidationInfo, field_validator, model_validator

from firmware_protocol.documents import Strict, read_yaml, validated
from firmware_protocol.errors import BadInputError
from gimbal_hil.knowledge.experiments.references import ANY_REFERENCE, SHAPES, AnyReference, without_units
from gimbal_hil.loop.control import Mode
from gimbal_hil.loop.host import (
    AXIS_NAMES,
    UNNAMED,
    AxisCommand,
    EndCondition,
    EndKind,
    Guard,
    Program,
    Segment,
    program_of,
)

#: a program of so many takes 40 MB
_MOST_SEGMENTS = 100_000
_END_KEYS = {
    "rate_above_rad_s": EndKind.RATE_ABOVE,
    "rate_below_rad_s": EndKind.RATE_BELOW,
    "position_above_rad": EndKind.POSITION_ABOVE,
    "position_below_rad": EndKind.POSITION_BELOW,
    "torque_above_nm": EndKind.TORQUE_ABOVE,
}


class AxisPlan(Strict):
    """What one axis does in a segment: a mode, and a reference whose keys carry the mode's unit."""

    mode: Mode = Mode.OFF
    reference: AnyReference | None = None

    @model_validator(mode="before")
    @classmethod
    def _split(cls, section: object) -> object:
        if not isinstance(section, dict) or "reference" in section:
            return section
        name = str(section.get("mode", "off"))
        if name.upper() not in Mode.__members__:
            raise ValueError(f"no mode {name!r}: expected " + ", ".join(mode.name.lower() for mode in Mode))
        mode = Mode[name.upper()]
        rest = {key: value for key, value in section.items() if key != "mode"}
        if mode is Mode.OFF:
            if rest:
                raise ValueError(f"mode off takes no {next(iter(rest))}")
            return {"mode": mode}
        return {"mode": mode, "reference": ANY_REFERENCE.validate_python(without_units({"shape": "hold"} | rest, mode))}

    def command(self, guard: Guard, step_s: float) -> AxisCommand:
        """What the host follows."""
        return AxisCommand(guard=guard) if self.reference is None else self.reference.command(self.mode, guard, step_s)


class End(Strict):
    """One condition that ends a segment early, once it has held for a time."""

    axis: str = Field(description="name of the axis that is looked at")
    rate_above_rad_s: Annotated[float, Field(ge=0.0)] | None = Field(default=None, description="joint rate, by size")
    rate_below_rad_s: Annotated[float, Field(gt=0.0)] | None = Field(default=None, description="joint rate, by size")
    position_above_rad: float | None = Field(default=None, description="joint position, by value")
    position_below_rad: float | None = Field(default=None, description="joint position, by value")
    torque_above_nm: Annotated[float, Field(ge=0.0)] | None = Field(
        default=None, description="torque asked for, by size"
    )
    for_s: Annotated[float, Field(ge=0.0)] = Field(default=0.0, description="how long it must hold without a break")

    @model_validator(mode="after")
    def _one(self) -> End:
        if self.axis not in AXIS_NAMES:
            raise ValueError(f"no axis {self.axis!r}: expected the name of an axis")
        if sum(getattr(self, key) is not None for key in _END_KEYS) != 1:
            raise ValueError("expected exactly one of " + ", ".join(_END_KEYS))
        return self

    def condition(self, rate_hz: float) -> EndCondition:
        """For the host."""
        key = next(key for key in _END_KEYS if getattr(self, key) is not None)
        return EndCondition(
            _END_KEYS[key], AXIS_NAMES.index(self.axis), getattr(self, key), max(1, round(self.for_s * rate_hz))
        )


class GuardPlan(Strict):
    """What an axis may do while a segment runs; looked at before its first torque. A guard ends the whole plan."""

    low_rad: float | None = Field(default=None, description="lowest joint position")
    high_rad: float | None = Field(default=None, description="highest joint position")
    rate_rad_s: Annotated[float, Field(gt=0.0)] | None = Field(default=None, description="largest joint rate, by size")
    torque_nm: Annotated[float, Field(gt=0.0)] | None = Field(default=None, description="largest torque, by size")

    def guard(self) -> Guard:
        """For the host."""
        return Guard(
            -math.inf if self.low_rad is None else self.low_rad,
            math.inf if self.high_rad is None else self.high_rad,
            math.inf if self.rate_rad_s is None else self.rate_rad_s,
            math.inf if self.torque_nm is None else self.torque_nm,
        )


class Guards(Strict):
    """Guards of both axes."""

    outer: GuardPlan = GuardPlan()
    inner: GuardPlan = GuardPlan()


class SegmentPlan(Strict):
    """One stretch of a plan; it needs a duration, which is its longest where it has end conditions."""

    name: str = Field(default="", description="step's name in tables; `segment N` without one")
    outer: AxisPlan = AxisPlan()
    inner: AxisPlan = AxisPlan()
    duration_s: Annotated[float, Field(gt=0.0)] = Field(
        description="how long it lasts, or at most where it has `end` conditions"
    )
    end: Annotated[tuple[End, ...], Field(max_length=2)] = Field(
        default=(), description="conditions that end it early, two at most; the first that holds counts"
    )
    guards: Guards = Field(default=Guards(), description="by axis: what it may do meanwhile")
    record_every_ticks: Annotated[int, Field(ge=0)] = Field(
        default=0, description="one log row in so many; 0 leaves it to the run"
    )
    measure: bool = Field(default=False, description="whether the report has a table row of it")
    meaning: dict[str, str | int | float | bool] = Field(
        default_factory=dict, description="plain values that go with the segment into events and tables"
    )

    def segment(self, label: int, rate_hz: float, last: bool) -> Segment:
        """For the host; after the last segment torque is switched off."""
        return Segment(
            self._command("outer", rate_hz),
            self._command("inner", rate_hz),
            max(1, round(self.duration_s * rate_hz)),
            tuple(end.condition(rate_hz) for end in self.end),
            label,
            self.record_every_ticks,
            last,
        )

    def _command(self, axis: str, rate_hz: float) -> AxisCommand:
        guard: Guard = getattr(self.guards, axis).guard()
        if axis not in self.model_fields_set:
            return replace(UNNAMED, guard=guard)
        plan: AxisPlan = getattr(self, axis)
        return plan.command(guard, 1.0 / rate_hz)


class Plan(Strict):
    """A whole plan; `laps` repeats its segments."""

    schema_: Literal[1] = Field(alias="schema", description="version of this format")
    name: str = Field(description="name of the experiment")
    text: str = Field(default="", description="what it is for")
    laps: Annotated[int, Field(ge=1, le=10000)] = Field(default=1, description="how often the segments are repeated")
    segments: Annotated[tuple[SegmentPlan, ...], Field(min_length=1)] = Field(description="one after the other")

    @field_validator("segments")
    @classmethod
    def _named(cls, segments: tuple[SegmentPlan, ...], info: ValidationInfo) -> tuple[SegmentPlan, ...]:
        laps = info.data.get("laps", 1)
        if laps * len(segments) > _MOST_SEGMENTS:
            raise ValueError(f"{laps} laps of {len(segments)} segments: expected {_MOST_SEGMENTS} in all at most")
        return tuple(
            one if one.name else one.model_copy(update={"name": f"segment {place}"})
            for place, one in enumerate(segments)
        )

    def in_order(self) -> list[tuple[int, SegmentPlan]]:
        """Lap and segment, as they are run; the place in this list is the segment's label."""
        return [(lap, segment) for lap in range(self.laps) for segment in self.segments]

    def host_segments(self, rate_hz: float) -> list[Segment]:
        """All segments for the host, labelled by their place."""
        ordered = self.in_order()
        return [
            segment.segment(label, rate_hz, label == len(ordered) - 1) for label, (_, segment) in enumerate(ordered)
        ]

    def program(self, rate_hz: float) -> Program:
        """The plan as one program for the host."""
        return program_of(self.host_segments(rate_hz))

    @property
    def longest_s(self) -> float:
        """How long it takes when no segment ends early."""
        return self.laps * sum(segment.duration_s for segment in self.segments)


def load_plan(path: Path, axes: Sequence[str] = AXIS_NAMES) -> Plan:
    """Read and check a plan file for an antenna with these axes; BadInputError names file, key and what was
    expected.
    """
    return plan_from_document(read_yaml(path, "a plan file with the keys schema, name, segments"), str(path), axes)


def plan_from_document(document: object, where: str, axes: Sequence[str] = AXIS_NAMES) -> Plan:
    """Check a plan given as a mapping; BadInputError as in `load_plan`. `outer` and `inner` are understood whatever the
    axes' names.
    """
    if not isinstance(document, dict):
        raise BadInputError(where, "holds no mapping", "the keys schema, name, segments")
    placed = _by_place(document, axes)
    try:
        return validated(Plan, placed, where, SHAPES)
    except BadInputError as refusal:
        raise _in_own_words(refusal, document, axes) from None


def _in_own_words(refusal: BadInputError, document: dict[str, object], axes: Sequence[str]) -> BadInputError:
    """The refusal with the axes called as the file calls them."""
    if tuple(axes) == AXIS_NAMES:
        return refusal
    where = re.sub(
        rf"(?<=\.)({'|'.join(AXIS_NAMES)})(?=\.|$)",
        lambda found: dict(zip(AXIS_NAMES, axes, strict=True))[found[1]],
        refusal.where,
    )
    others = [_in_own_words(other, document, axes) for other in refusal.others]
    return BadInputError(where, refusal.problem, refusal.expected, others)


def _by_place(document: dict[str, object], axes: Sequence[str]) -> dict[str, object]:
    """A plan in which the axes are called `outer` and `inner`, as the fields above are; the other names in it stay."""
    places = dict(zip(axes, AXIS_NAMES, strict=True))

    def renamed(section: object) -> object:
        return {places.get(key, key): value for key, value in section.items()} if isinstance(section, dict) else section

    def of_segment(segment: object) -> object:
        if not isinstance(segment, dict):
            return segment
        ends = segment.get("end")
        if isinstance(ends, list):
            segment = segment | {
                "end": [
                    one | {"axis": places.get(one["axis"], one["axis"])} if _names_axis(one) else one for one in ends
                ]
            }
        return renamed(segment | ({"guards": renamed(segment["guards"])} if "guards" in segment else {}))

    segments = document.get("segments")
    return document | {"segments": [of_segment(one) for one in segments]} if isinstance(segments, list) else document


def _names_axis(end: object) -> bool:
    return isinstance(end, dict) and isinstance(end.get("axis"), str)
