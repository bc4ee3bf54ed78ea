"""What an experiment is: named steps for the host, what to measure in each, and what to conclude from all.

A step is one host segment with what it means (axis, speed, direction, pass). `measure` turns the signals of one step
into a table row as soon as the step is done, `conclude` turns the rows into report blocks. Both are pure, so a resumed
experiment ends with the same table as one that was never stopped.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.json_object import Json
from gimbal_hil.loop.host import AxisCommand, EndCondition, Mode, Program, Segment, Shape, program_of

if TYPE_CHECKING:
    from gimbal_hil.pages.report import Block

Signals = Mapping[str, NDArray[np.float64]]
Row = Json


@dataclass(frozen=True)
class Step:
    """One stretch of an experiment: what the host follows, and what it is for."""

    name: str
    segment: Segment
    #: what the step stands for: plain JSON, e.g. {"axis": "outer", "speed_rad_s": 0.01, "pass": 0}
    meaning: Mapping[str, Any] = field(default_factory=dict)
    #: whether `measure` is asked for a row
    measured: bool = False
    #: ticks in one row of its signals; the torque of a row is the mean over them, so that nothing of it is lost
    every: int = 1

    @cached_property
    def program(self) -> Program:
        """The segment compiled, once for every antenna that follows it; BadInputError where it makes no sense."""
        return program_of([self.segment])


@dataclass(frozen=True)
class Experiment:
    """A named sequence with its analysis."""

    name: str
    text: str
    steps: tuple[Step, ...]
    measure: Callable[[Step, Signals], Row | None]
    conclude: Callable[[Sequence[Row], Mapping[str, Signals]], list[Block]]
    #: steps whose signals `conclude` wants to draw (by name); others are not kept in memory
    drawn: frozenset[str] = frozenset()
    #: one log row in so many ticks; 1 keeps frames too, so that the run can be replayed
    every: int = 1
    #: `base:` section of the model that a virtual antenna is given for this experiment; None leaves the model's own
    base: Mapping[str, Any] | None = None
    #: the same steps as experiments of their own, for virtual antennas side by side; empty where one antenna has to do
    #: it all
    parts: tuple[Experiment, ...] = ()

    def duration_s(self, rate_hz: float) -> float:
        """Simulated or real time that the steps take when none ends early, s."""
        return sum(step.segment.duration_ticks for step in self.steps) / rate_hz


def position_hold(value_rad: float) -> AxisCommand:
    """Hold a joint position."""
    return AxisCommand(Mode.POSITION, Shape.HOLD, (value_rad,))


def move_to(target_rad: float, duration_s: float) -> AxisCommand:
    """Move smoothly to a joint position in a given time."""
    return AxisCommand(Mode.POSITION, Shape.SMOOTH, (target_rad, duration_s))


def axes_of(signals: Iterable[str]) -> tuple[str, ...]:
    """Names of the axes that signals (or their names) are of, in their order: the carrying one first."""
    return tuple(name.removesuffix(".position") for name in signals if name.endswith(".position"))


def step_of(
    name: str,
    rate_hz: float,
    duration_s: float,
    commands: Sequence[AxisCommand],
    meaning: Mapping[str, object] | None = None,
    measured: bool = False,
    ends: tuple[EndCondition, ...] = (),
) -> Step:
    """A step of `duration_s` seconds (at least one tick) at a tick rate; `commands` of the carrying axis and of the
    carried one.
    """
    ticks = max(1, round(duration_s * rate_hz))
    outer, inner = commands
    return Step(name, Segment(outer, inner, ticks, ends), dict(meaning or {}), measured)
