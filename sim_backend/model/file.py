"""The form of a model file, validated when it is read: unknown keys, wrong units and impossible bodies are refused.

Every number may be plain (then it is in the unit of the table in `numbers.py`) or `{value, unit, source, uncertainty}`;
`source` says where it comes from: measured, printed, CAD, inferred, assumed; `uncertainty` how well it is known (see
`uncertainty.py`).
"""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import ConfigDict, Field, field_validator, model_validator

from firmware_protocol.documents import Strict, read_yaml
from firmware_protocol.json_object import Json
from sim_backend.boresight import Boresight
from sim_backend.carrying import in_order, require_plain_names
from sim_backend.model.laws import LawKind
from sim_backend.model.uncertainty import StatedUncertainty

#: key of an axis that names the axis which carries it
PARENT = "parent"


class Quantity(Strict):
    """A number with its unit, where it comes from and how well it is known."""

    value: float
    unit: str | None = None
    source: str | None = None
    uncertainty: StatedUncertainty | None = None


class ModelKind(StrEnum):
    """What moves: a two-axis gimbal, or one axis."""

    GIMBAL = "gimbal"
    ROTARY = "rotary"
    LINEAR = "linear"


class BaseMotionKind(StrEnum):
    """How the base moves."""

    FIXED = "fixed"
    CONSTANT_RATE = "constant_rate"
    SINUSOID = "sinusoid"
    RECORDED = "recorded"
    CASE = "case"


class Angles(Strict):
    """Roll, pitch, yaw in rad (or their amplitudes, frequencies in Hz, phases)."""

    roll: float = 0.0
    pitch: float = 0.0
    yaw: float = 0.0


class Rates(Strict):
    """Body rates in rad/s."""

    p: float = 0.0
    q: float = 0.0
    r: float = 0.0


class BaseSection(Strict):
    """Base motion; which keys count depends on `motion`."""

    motion: BaseMotionKind = BaseMotionKind.FIXED
    attitude_rad: Angles = Angles()
    rate_rad_s: Rates = Rates()
    amplitude_rad: Angles = Angles()
    frequency_hz: Angles = Angles()
    phase_rad: Angles = Angles()
    #: recorded: CSV with columns time_s, roll, pitch, yaw (rad) and, where the pivot accelerates, ax, ay, az (m/s^2,
    #: base axes, gravity not included), constant rate; the path is relative to the model file
    file: str | None = None
    #: case: a row of table 3.1 or 3.2 of the thesis
    table: Literal["3.1", "3.2"] | None = None
    case: int | None = None
    #: how old attitude, rates and acceleration of the base are when the antenna sends them
    ins_age_s: Annotated[float, Field(ge=0.0, le=0.1)] = 0.0


class EffectSection(Strict):
    """One entry of `effects:`; the other keys are the effect's parameters, or what a law of the file's own consists
    of (`kind`).
    """

    model_config = ConfigDict(extra="allow", frozen=True)
    name: str
    axis: str
    kind: LawKind | None = None

    @model_validator(mode="before")
    @classmethod
    def _law_without_name(cls, given: Any) -> Any:
        """A law needs no name."""
        if isinstance(given, dict) and "kind" in given and "name" not in given:
            return {**given, "name": str(given["kind"])}
        return given

    def amounts(self) -> Json:
        """The parameters as they stand in the file."""
        return dict(self.model_extra or {})


class ModelFile(Strict):
    """A whole model file."""

    schema_: Literal[1] = Field(alias="schema")
    name: str
    text: str = ""
    kind: ModelKind
    #: of every number that states none of its own
    uncertainty: StatedUncertainty | None = None
    plant_step_s: Annotated[float, Field(gt=0.0, le=0.01)] = 1e-4
    gravity_m_s2: Annotated[float, Field(ge=0.0, le=100.0)] = 9.81
    gravity_reading: Literal["separate_bodies", "total_mass"] = "separate_bodies"
    #: rotary: sine of the axis' tilt from the vertical (1 is a horizontal axis); linear: sine of the slope
    incline_sine: Annotated[float, Field(ge=-1.0, le=1.0)] = 0.0
    #: gimbals: which way is up
    boresight: Boresight = Boresight.AHEAD
    base: BaseSection = BaseSection()
    #: axis name -> nested numbers, checked against the table in numbers.py, and `parent:`, the axis that carries this
    #: one; in the order in which they carry one another, whatever the file's
    axes: dict[str, Json]
    effects: tuple[EffectSection, ...] = ()
    thesis_slips: tuple[str, ...] = ()

    @field_validator("axes")
    @classmethod
    def _carrying_first(cls, axes: dict[str, Json]) -> dict[str, Json]:
        require_plain_names(axes)
        parents = {name: section.get(PARENT) for name, section in axes.items()}
        if any(parent is not None and not isinstance(parent, str) for parent in parents.values()):
            raise ValueError("a parent is no name: expected the name of the axis that carries this one")
        return {name: axes[name] for name in in_order(parents)} if len(axes) == 2 else axes


def read_document(path: Path) -> Json:
    """The YAML document of a file as a mapping; BadInputError names the file and the line where it cannot be read."""
    return read_yaml(path, "a model file with the keys schema, name, kind, axes")
