"""Scenarios as data: what the axes are asked for, how the base moves meanwhile, and what counts.

    schema: 1
    name: steps
    scenarios:
      - {name: outer 0.5 rad, outer: {value_rad: 0.5}, score: step, axis: outer, duration_s: 3.0}

Each axis does what an axis of a plan segment does; `position` is its mode unless another one is given, and an axis that
is not named holds zero.
"""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Discriminator, Field, Tag, field_validator, model_validator

from firmware_protocol.documents import Strict, read_yaml, validated
from firmware_protocol.errors import BadInputError
from gimbal_hil.knowledge.experiments import AxisPlan
from gimbal_hil.loop.control import Mode
from gimbal_hil.pointing.arena.base_motions import AircraftMotion, Manoeuvre, Swing, Turbulence
from sim_backend.model import BaseSection
from sim_backend.shipped import shipped_file

_AIRCRAFT: dict[str, type[AircraftMotion]] = {"turbulence": Turbulence, "manoeuvre": Manoeuvre, "swing": Swing}


def _kind(base: object) -> str:
    motion = base.get("motion") if isinstance(base, dict) else getattr(base, "motion", None)
    return motion if isinstance(motion, str) and motion in _AIRCRAFT else "model"


ScenarioBase = Annotated[
    Annotated[BaseSection, Tag("model")]
    | Annotated[Turbulence, Tag("turbulence")]
    | Annotated[Manoeuvre, Tag("manoeuvre")]
    | Annotated[Swing, Tag("swing")],
    Discriminator(_kind),
]


class Score(StrEnum):
    """What counts in a scenario."""

    #: the error while it lasts
    TRACK = "track"
    #: overshoot, settling, and the error at rest
    STEP = "step"
    #: the error, and its peaks after a reversal
    REVERSAL = "reversal"


class Scenario(Strict):
    """One row of the arena."""

    name: str
    text: str = ""
    outer: AxisPlan
    inner: AxisPlan
    base: ScenarioBase = BaseSection()
    score: Score = Score.TRACK
    #: of a step: the axis that makes it
    axis: Literal["outer", "inner"] | None = None
    duration_s: Annotated[float, Field(gt=0.0, le=600.0)]
    #: time before the reference begins, at its first value, and time after that which does not count
    lead_s: Annotated[float, Field(ge=0.5)] = 2.5
    settle_s: Annotated[float, Field(ge=0.0)] = 2.0

    @model_validator(mode="before")
    @classmethod
    def _held_axes(cls, section: object) -> object:
        if not isinstance(section, dict):
            return section
        held = {axis: {"mode": "position"} | (section.get(axis) or {}) for axis in ("outer", "inner")}
        return {**section, **held}

    @model_validator(mode="after")
    def _a_step_has_an_axis(self) -> Scenario:
        if (self.score is Score.STEP) != (self.axis is not None):
            raise ValueError("axis: expected with score step, and only there")
        return self

    @property
    def points(self) -> bool:
        """Whether a direction in space is held."""
        return self.outer.mode is Mode.POINTING

    @model_validator(mode="after")
    def _a_direction_is_held_on_an_aircraft(self) -> Scenario:
        modes = {self.outer.mode is Mode.POINTING, self.inner.mode is Mode.POINTING}
        if True in modes:
            held = all(getattr(axis.reference, "shape", "") == "hold" for axis in (self.outer, self.inner))
            if len(modes) > 1 or not held or not isinstance(self.base, AircraftMotion):
                raise ValueError("mode pointing: expected on both axes, held, and on a base of the arena's own")
        return self


class ScenarioFile(Strict):
    """A file of scenarios."""

    schema_: Literal[1] = Field(alias="schema")
    name: str
    text: str = ""
    scenarios: Annotated[tuple[Scenario, ...], Field(min_length=1)]

    @field_validator("scenarios")
    @classmethod
    def _once(cls, scenarios: tuple[Scenario, ...]) -> tuple[Scenario, ...]:
        names = [one.name for one in scenarios]
        if len(set(names)) < len(names):
            raise ValueError("two scenarios of one name")
        return scenarios


def load_scenarios(path: Path) -> tuple[Scenario, ...]:
    """Scenarios of a file, called `file: scenario`; BadInputError names file, key and what was expected."""
    document = read_yaml(path, "a file of scenarios with the keys schema, name, scenarios")
    file = validated(ScenarioFile, document, str(path))
    return tuple(one.model_copy(update={"name": f"{file.name}: {one.name}"}) for one in file.scenarios)


def shipped_scenarios() -> tuple[Scenario, ...]:
    """Every scenario that comes with the project."""
    found = sorted(shipped_file("scenarios").glob("*.yaml"))
    return tuple(scenario for path in found for scenario in load_scenarios(path))


def chosen(scenarios: tuple[Scenario, ...], pattern: str | None) -> tuple[Scenario, ...]:
    """Those whose name holds `pattern`; BadInputError where there is none."""
    found = tuple(one for one in scenarios if pattern is None or pattern in one.name)
    if not found:
        raise BadInputError("--scenario", f"nothing has {pattern!r} in its name", ", ".join(s.name for s in scenarios))
    return found
