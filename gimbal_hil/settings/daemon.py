"""Configuration of the daemon: rate, link, axes, supervisor, recording, operator's door."""

from __future__ import annotations

import difflib
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any, Literal

import yaml
from pydantic import BaseModel, Field, ValidationError

from firmware_protocol.errors import BadInputError
from gimbal_hil.settings.axis import AxisSettings, NotNegative, Positive, Strict
from gimbal_hil.settings.link import LINK_KINDS, Embedded, EmbeddedAntenna, LinkSettings


class Reaction(StrEnum):
    """What the drive does when set-points stay away."""

    COAST = "coast"
    BRAKE = "brake"
    DECELERATE_AND_HOLD = "decelerate_and_hold"


class Deadman(Strict):
    """The drive's deadman, sent to it at connection."""

    window_ticks: Annotated[int, Field(ge=1, le=255)] = 20
    reaction: Reaction = Reaction.DECELERATE_AND_HOLD


class Supervisor(Strict):
    """Times and counts of the supervisor; times become whole ticks."""

    #: complete feedback sets in a row that make a connection
    connect_ticks: Annotated[int, Field(ge=1)] = 5
    #: ticks without feedback after which it is lost: torque zero, fault
    lost_ticks: Annotated[int, Field(ge=0, le=100)] = 5
    #: ticks in a row that a limit must be broken
    debounce_ticks: Annotated[int, Field(ge=1)] = 5
    #: set-points that the drive may lag behind
    set_point_lag_ticks: Annotated[int, Field(ge=0, le=500)] = 10
    synchronise_time_s: Positive = 5.0
    reset_pulse_time_s: Positive = 0.05
    stop_time_s: Positive = 5.0
    rest_time_s: Positive = 0.05
    following_time_s: Positive = 0.5
    base_lost_time_s: Positive = 0.5
    #: time constant of the filters that compare gyro and encoder
    gyro_encoder_time_s: Positive = 0.05
    #: connect again by itself when feedback returns; torque stays off until the next command
    automatic_reconnect: bool = True
    deadman: Deadman = Deadman()


class Recording(Strict):
    """What a run folder keeps."""

    frames: bool = True
    #: one tick row in so many
    every_ticks: Annotated[int, Field(ge=1)] = 1


class Operator(Strict):
    """The operator's socket."""

    enabled: bool = True


class Axes(Strict):
    """Both axes."""

    outer: AxisSettings
    inner: AxisSettings


class DaemonSettings(Strict):
    """A whole configuration file."""

    schema_: Literal[1] = Field(alias="schema")
    rate_hz: Annotated[float, Field(ge=10.0, le=20000.0)] = 1000.0
    link: LinkSettings = EmbeddedAntenna()
    axes: Axes
    supervisor: Supervisor = Supervisor()
    recording: Recording = Recording()
    operator: Operator = Operator()

    @property
    def step_s(self) -> float:
        """One tick."""
        return 1.0 / self.rate_hz

    def ticks(self, time_s: NotNegative) -> int:
        """A time in whole ticks, at least one."""
        return max(1, round(time_s * self.rate_hz))


def load_settings(path: Path) -> DaemonSettings:
    """Read and check a configuration file; BadInputError names file, key and what was expected."""
    try:
        document = yaml.safe_load(path.read_text())
    except FileNotFoundError:
        raise BadInputError(str(path), "no such file", "a configuration file (YAML)") from None
    except (OSError, UnicodeDecodeError) as error:
        raise BadInputError(str(path), f"cannot be read ({error})", "a configuration file (YAML)") from None
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        place = f" at line {mark.line + 1}" if mark else ""
        raise BadInputError(str(path), f"is not YAML{place}: {getattr(error, 'problem', error)}", "a configuration file") from None
    return settings_from_document(document, str(path), path.parent)


def settings_from_document(document: Any, where: str, folder: Path | None = None) -> DaemonSettings:
    """Check a configuration given as a mapping; BadInputError as in `load_settings`. A model's path counts from `folder`."""
    if not isinstance(document, dict):
        raise BadInputError(where, "holds no mapping", "the keys " + ", ".join(_keys(DaemonSettings)))
    try:
        settings = DaemonSettings.model_validate(document)
    except ValidationError as error:
        raise _first_error(error, where) from None
    link = settings.link
    if not isinstance(link, EmbeddedAntenna):
        from firmware_protocol.links import require_link_carries

        require_link_carries(link, settings.rate_hz, f"{where}: rate_hz")
    elif folder is not None and link.embedded.is_file:
        found = EmbeddedAntenna(embedded=Embedded(model=str((folder / link.embedded.model).resolve()), seed=link.embedded.seed))
        return settings.model_copy(update={"link": found})
    return settings


def _first_error(error: ValidationError, where: str) -> BadInputError:
    # a misspelt key tells more than the one that is missing because of it
    first = min(error.errors(), key=lambda one: one["type"] != "extra_forbidden")
    tagged = [str(part) for part in first["loc"]]
    kind = LINK_KINDS.get(tagged[1]) if tagged[:1] == ["link"] and len(tagged) > 1 else None
    path = tagged if kind is None else tagged[:1] + tagged[2:]
    more = f" (and {error.error_count() - 1} more)" if error.error_count() > 1 else ""
    place = f"{where}: {'.'.join(path)}" if path else where
    if first["type"] == "extra_forbidden":
        known = _keys(kind if kind is not None and len(path) == 2 else _section(path[:-1]))
        near = difflib.get_close_matches(path[-1], known, 1)
        return BadInputError(place, f"unknown key{more}", f"{near[0]}?" if near else "one of " + ", ".join(known))
    if first["type"] == "missing":
        return BadInputError(place, f"is missing{more}", "a value")
    message = str(first["msg"]).removeprefix("Value error, ")
    return BadInputError(place, f"{first['input']!r}: {message}{more}" if not isinstance(first["input"], dict) else f"{message}{more}")


def _section(path: list[str]) -> type[BaseModel]:
    """The model of the section at `path`; the innermost one that is known."""
    model: type[BaseModel] = DaemonSettings
    for name in path:
        if name == "embedded":
            return Embedded
        found = model.model_fields.get(name)
        kinds = [found.annotation, *getattr(found.annotation, "__args__", ())] if found else []
        inner = [kind for kind in kinds if isinstance(kind, type) and issubclass(kind, BaseModel)]
        if inner:
            model = inner[0]
    return model


def _keys(model: type[BaseModel]) -> list[str]:
    return [field.alias or name for name, field in model.model_fields.items()]
