"""Configuration of the daemon: rate, link, axes, supervisor, recording, operator's door."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, ValidationError

from firmware_protocol.documents import Strict, read_yaml, refusal_of
from firmware_protocol.errors import BadInputError
from gimbal_hil.settings.axis import AxisSettings, NotNegative, Positive
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


_KEYS = [field.alias or name for name, field in DaemonSettings.model_fields.items()]


def load_settings(path: Path) -> DaemonSettings:
    """Read and check a configuration file; BadInputError names file, key and what was expected."""
    document = read_yaml(path, "a configuration file with the keys " + ", ".join(_KEYS))
    return settings_from_document(document, str(path), path.parent)


def settings_from_document(document: Any, where: str, folder: Path | None = None) -> DaemonSettings:
    """Check a configuration given as a mapping; BadInputError as in `load_settings`. A model's path counts from `folder`."""
    if not isinstance(document, dict):
        raise BadInputError(where, "holds no mapping", "the keys " + ", ".join(_KEYS))
    try:
        settings = DaemonSettings.model_validate(document)
    except ValidationError as error:
        raise refusal_of(error, where, DaemonSettings, LINK_KINDS) from None
    link = settings.link
    if not isinstance(link, EmbeddedAntenna):
        from firmware_protocol.links import require_link_carries

        require_link_carries(link, settings.rate_hz, f"{where}: rate_hz")
    elif folder is not None and link.embedded.is_file:
        found = EmbeddedAntenna(embedded=Embedded(model=str((folder / link.embedded.model).resolve()), seed=link.embedded.seed))
        return settings.model_copy(update={"link": found})
    return settings
