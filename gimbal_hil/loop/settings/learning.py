"""Configuration of what the loops take from a model, and of what they learn beside it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Self

import yaml
from pydantic import Field, model_validator

from firmware_protocol.documents import Strict, read_yaml, validated
from firmware_protocol.json_object import Json
from gimbal_hil.loop.control import LEARNED_BINS

Positive = Annotated[float, Field(gt=0.0)]
#: bin of the turn, torque in the positive and in the negative direction, N m
Entry = tuple[Annotated[int, Field(ge=0, lt=LEARNED_BINS)], float, float]


class ModelControl(Strict):
    """What the loops take from a model file; each part can be switched alone. References are shaped without delay by
    the prefilters' corner and limits.
    """

    model: str = Field(
        default="thesis", description="name of a shipped model, or path of a model file (relative to this file)"
    )
    document: Json | None = Field(default=None, description="the model itself, as a run keeps it, in place of `model`")
    bodies: bool = Field(
        default=True,
        description=(
            "torque for inertia, coupling, weight and base motion by the model's bodies, in place of "
            "`feedforward.moment_kg_m`"
        ),
    )
    friction: bool = Field(
        default=True,
        description="torque against the model's friction, in place of `feedforward.coulomb_nm` and its neighbours",
    )
    temperature: bool = Field(
        default=True,
        description=(
            "that friction at the motor's temperature, where the model says how it changes: `over_temperature`, "
            "`temperature_viscosity`"
        ),
    )
    position_torque: bool = Field(
        default=True, description="torque against cogging, cable spring and drive offset that the model names"
    )
    extrapolate_base: bool = Field(
        default=True, description="base motion extrapolated from its time of validity to now"
    )
    watch: bool = Field(
        default=True,
        description=(
            "fade out the feed-forward when the torque sent contradicts it, and leave the observer when its loops"
            " oscillate"
        ),
    )
    watch_time_s: Positive = Field(default=2.0, description="window of that judgement")


class FrictionLevels(Strict):
    """Levels of the sliding and the viscous part of `model_control.friction`, followed while the axis works."""

    window_s: Positive = Field(default=20.0, description="window of that judgement; only sliding counts")
    least: Annotated[float, Field(gt=0.0, le=1.0)] = Field(
        default=0.3, description="lower bound of both levels, times the model's"
    )
    largest: Annotated[float, Field(ge=1.0)] = Field(default=10.0, description="upper bound, likewise")


class LearnedTorque(Strict):
    """Table over the joint's position (half degrees of a turn) and direction: what the loops add to the torque that is
    fed forward is fed forward, too.
    """

    share: Annotated[float, Field(ge=0.0, le=0.5)] = Field(
        default=0.3, description="share of the loops' torque that a pass over a position adds to the table; 0: frozen"
    )
    largest_nm: Positive | None = Field(
        default=None, description="largest entry; a tenth of the torque limit unless given"
    )
    slowest_rad_s: Positive = Field(default=0.01, description="below this joint rate both directions are mixed")
    fastest_rad_s: Positive = Field(default=0.5, description="above it nothing is learned")
    table: str | None = Field(
        default=None,
        description="file that it begins with (relative to this file), as `replay RUN --learned FILE` writes it",
    )
    entries: tuple[Entry, ...] | None = Field(
        default=None, description="the table itself, as a run keeps it, in place of `table`"
    )

    @model_validator(mode="after")
    def _slow_and_fast(self) -> Self:
        if not self.slowest_rad_s < self.fastest_rad_s:
            raise ValueError("slowest_rad_s is not below fastest_rad_s")
        return self

    def entries_of(self, axis: str) -> tuple[Entry, ...]:
        """The table that it begins with; BadInputError for a file that has none for this axis."""
        if self.entries is not None:
            return self.entries
        return () if self.table is None else read_learned(Path(self.table), axis)


class LearnedFile(Strict):
    """A file of learned tables."""

    schema_: int = Field(alias="schema", ge=1, le=1, description="version of this format")
    axes: dict[str, tuple[Entry, ...]] = Field(
        description="by axis, rows of bin (half degrees), torque in the positive and the negative direction, N m"
    )


def read_learned(path: Path, axis: str) -> tuple[Entry, ...]:
    """Entries of one axis; BadInputError names file and key."""
    from firmware_protocol.errors import BadInputError

    document = read_yaml(path, "a file that replay --learned wrote, with the keys schema and axes")
    found = validated(LearnedFile, document, str(path))
    if axis not in found.axes:
        raise BadInputError(f"{path}: axes", f"has no {axis}", " and ".join(found.axes))
    return found.axes[axis]


def learned_text(entries: Mapping[str, Sequence[Entry]]) -> str:
    """Text of a file of learned tables."""
    lines = ["# Torque that the loops learned: bin (half degrees of a turn), positive, negative direction (N m)"]
    lines += ["schema: 1", "axes:" if entries else "axes: {}"]
    for axis, rows in entries.items():
        plain: Any = [[number, float(f"{one:.6g}"), float(f"{other:.6g}")] for number, one, other in rows]
        lines.append(f"  {axis}:" if plain else f"  {axis}: []")
        lines += [f"    - {yaml.safe_dump(row, default_flow_style=True, width=200).strip()}" for row in plain]
    return "\n".join(lines) + "\n"
