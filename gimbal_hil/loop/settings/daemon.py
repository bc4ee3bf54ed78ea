"""Configuration of the daemon: rate, link, axes, supervisor, recording, operator's door."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, Self

from pydantic import Field, field_validator, model_validator

from firmware_protocol.documents import Strict, read_yaml, validated
from firmware_protocol.errors import BadInputError, refused_below
from firmware_protocol.links import AdapterLinkConfig
from gimbal_hil.loop.settings.axis import AxisSettings, NotNegative, Positive
from gimbal_hil.loop.settings.learning import ModelControl
from gimbal_hil.loop.settings.link import LINK_KINDS, EmbeddedAntenna, LinkSettings, is_model_file
from gimbal_hil.loop.settings.pointing import Pointing
from sim_backend.boresight import Boresight
from sim_backend.carrying import INNER, OUTER, in_order, require_plain_names

if TYPE_CHECKING:
    from sim_backend.model import AntennaModel


class Reaction(StrEnum):
    """What the drive does when set-points stay away."""

    COAST = "coast"
    BRAKE = "brake"
    DECELERATE_AND_HOLD = "decelerate_and_hold"


class FirstTestChoice(StrEnum):
    """When an antenna is tried with a small torque on each axis before it may be moved."""

    ALWAYS = "always"
    REAL_LINK = "real_link"
    NEVER = "never"


class UnnamedAxisChoice(StrEnum):
    """What holds an axis that a plan does not name."""

    POSITION = "position"
    BRAKE = "brake"
    FREE = "free"


class Deadman(Strict):
    """The drive's deadman, sent to it at connection."""

    window_ticks: Annotated[int, Field(ge=1, le=255)] = Field(
        default=20, description="ticks without a fresh set-point before the drive reacts"
    )
    reaction: Reaction = Field(default=Reaction.DECELERATE_AND_HOLD, description="what it does then")


class Supervisor(Strict):
    """Times and counts of the supervisor; times become whole ticks."""

    connect_ticks: Annotated[int, Field(ge=1)] = Field(
        default=5, description="complete feedback sets in a row that make a connection"
    )
    lost_ticks: Annotated[int, Field(ge=0, le=100)] = Field(
        default=5, description="ticks without feedback after which it is lost: torque zero, fault"
    )
    debounce_ticks: Annotated[int, Field(ge=1)] = Field(
        default=5, description="ticks in a row that a limit must be broken"
    )
    set_point_lag_ticks: Annotated[int, Field(ge=0, le=500)] = Field(
        default=10, description="set-points that the drive's echo may lag behind"
    )
    synchronise_time_s: Positive = Field(default=5.0, description="longest time from connection to operation enabled")
    reset_pulse_time_s: Positive = Field(default=0.05, description="length of a pulse of `fault_reset`")
    stop_time_s: Positive = Field(
        default=5.0,
        description="longest time of a stop: under control, then `STOP_TIMEOUT`; by the drive, then it is switched off",
    )
    rest_time_s: Positive = Field(default=0.05, description="how long both axes must be at rest for a stop to be over")
    following_time_s: Positive = Field(default=0.5, description="how long a following error must last")
    base_lost_time_s: Positive = Field(
        default=0.5, description="time without `base_rate` after which the base counts as fixed"
    )
    gyro_encoder_time_s: Positive = Field(
        default=0.05, description="time constant of the filters that compare gyro and encoder"
    )
    service_timeout_s: Positive = Field(
        default=5.0,
        description="a service process (recorder, operator's socket) that does not work for so long ends the daemon",
    )
    gyro_encoder_window_s: Positive = Field(
        default=2.0, description="window in which gyro and encoder are held against each other as angles"
    )
    one_sensor_window_s: Positive | None = Field(
        default=None,
        description="longer window for `SENSOR_DRIFT` where one sensor tells position and rate; null with gyros",
    )
    automatic_reconnect: bool = Field(
        default=True,
        description="connect again by itself when feedback returns; torque stays off until the next command",
    )
    first_test: FirstTestChoice = Field(
        default=FirstTestChoice.REAL_LINK,
        description=(
            "test each axis with a small torque before the first motion, once after a daemon's start; a virtual "
            "antenna in the daemon's own process, or one in lockstep, is no `real_link`"
        ),
    )
    unnamed_axis: UnnamedAxisChoice = Field(
        default=UnnamedAxisChoice.POSITION,
        description=(
            "what holds an axis that a plan does not name beside one that it moves: its loops, where it stands; its "
            "holding `brake`; nothing (`free`: what is out of balance falls)"
        ),
    )
    deadman: Deadman = Field(default=Deadman(), description="the drive's deadman, sent to it at connection")

    @field_validator("unnamed_axis", mode="before")
    @classmethod
    def _no_short_circuit_of_one_axis(cls, value: object) -> object:
        if value == "short_circuit":
            raise ValueError(
                "a shorted winding slows an axis that its weight moves, and holds nothing; no drive here shorts one "
                "axis beside one that moves: expected position, brake or free"
            )
        return value


class Recording(Strict):
    """What a run folder keeps."""

    frames: bool = Field(default=True, description="keep the frames of both directions")
    every_ticks: Annotated[int, Field(ge=1)] = Field(default=1, description="one tick row in so many")
    segment_mb: Annotated[float, Field(ge=1.0)] = Field(
        default=512.0,
        description="a new segment of the log begins when both streams of one hold this much together, MiB",
    )
    keep_mb: Annotated[float, Field(ge=1.0)] | None = Field(
        default=None,
        description="delete the oldest segments as long as the newer ones hold this much, MiB; without it all are kept",
    )
    warn_below_mb: Annotated[float, Field(ge=0.0)] = Field(
        default=2000.0, description="free space on the disk from which the run warns, MiB"
    )
    stop_below_mb: Annotated[float, Field(ge=0.0)] = Field(
        default=100.0, description="free space below which the run is ended and sealed, MiB"
    )


class Operator(Strict):
    """The operator's socket."""

    enabled: bool = Field(default=True, description="whether there is a socket for commands")
    lease_s: Positive = Field(
        default=3.0,
        description=(
            "a client whose motion is leased (`experiment --run`, `point --run`) and who says nothing for so long "
            "counts as gone: the axes brake to rest; a closed connection ends the motion at once"
        ),
    )


class Observer(Strict):
    """The model beside the antenna, in the service process: it tells the torque that the model lacks, while it runs."""

    enabled: bool = Field(default=True, description="whether there is one, where a model is known")
    model: str | None = Field(
        default=None,
        description=(
            "model file (relative to this file) or shipped name; without it that of a virtual antenna in the daemon's "
            "own process, and none on a link"
        ),
    )
    bandwidth_hz: Annotated[float, Field(gt=0.0, le=50.0)] = Field(
        default=5.0, description="how fast it follows, but no faster than a twentieth of the rate; slower is quieter"
    )
    least_share: Annotated[float, Field(gt=0.0, lt=1.0)] = Field(
        default=0.0005, description="share of the torque limit below which a change is never told"
    )


AxisNames = tuple[str, str]


class ExpectedAntenna(Strict):
    """The only antenna that may get torque; what is left out may be any."""

    name: Annotated[str, Field(min_length=1)] | None = Field(
        default=None, description="its name, as `identity` tells it"
    )
    serial_number: Annotated[int, Field(ge=0, lt=2**31)] | None = Field(
        default=None, description="its serial number, as `identity_unit` tells it"
    )


class DaemonSettings(Strict):
    """A whole configuration file."""

    schema_: Literal[1] = Field(alias="schema", description="version of this format")
    rate_hz: Annotated[float, Field(ge=10.0, le=20000.0)] = Field(
        default=1000.0, description="ticks a second of host and antenna"
    )
    link: LinkSettings = Field(default=EmbeddedAntenna(), description="where the antenna is: see the examples")
    antenna: ExpectedAntenna = Field(
        default=ExpectedAntenna(), description="the only antenna that may get torque; what is left out may be any"
    )
    axes: dict[str, AxisSettings] = Field(
        description="two axes by name, in any order: one on the base, and one that it carries"
    )
    model_control: ModelControl | None = Field(
        default=None, description="what the loops use of a model file; nothing without it"
    )
    supervisor: Supervisor = Field(
        default=Supervisor(), description="times and counts of the supervisor; times become whole ticks"
    )
    pointing: Pointing = Field(default=Pointing(), description="how a direction in space is held")
    recording: Recording = Field(default=Recording(), description="what a run folder keeps")
    operator: Operator = Field(default=Operator(), description="the operator's socket")
    observer: Observer = Field(default=Observer(), description="the model beside the antenna")

    @field_validator("axes")
    @classmethod
    def _carrying_first(cls, axes: dict[str, AxisSettings]) -> dict[str, AxisSettings]:
        if len(axes) != 2:
            raise ValueError(f"{len(axes)} axes, not two: one on the base, and one that it carries")
        require_plain_names(axes)
        return {name: axes[name] for name in in_order({name: axis.parent for name, axis in axes.items()})}

    @model_validator(mode="after")
    def _what_a_model_needs(self) -> Self:
        for name, axis in self.axes.items():
            if axis.observer is not None and self.model_control is None:
                raise ValueError(f"axes.{name}.observer: needs model_control, which says whose numbers it takes")
            if self.model_control is not None and (axis.prefilter is None or axis.prefilter.rate_rad_s is None):
                raise ValueError(f"axes.{name}.prefilter: expected with rate_rad_s, because of model_control")
            if (axis.learned is not None or axis.friction_levels is not None) and self.model_control is None:
                raise ValueError(f"axes.{name}: learned and friction_levels need model_control: they add to it")
            if axis.friction_levels is not None and self.model_control is not None and not self.model_control.friction:
                raise ValueError(f"axes.{name}.friction_levels: are levels of model_control.friction, which is off")
        return self

    @property
    def axis_names(self) -> AxisNames:
        """Names of the axes, the carrying one first."""
        outer, inner = self.axes
        return outer, inner

    def for_axes(self, names: Sequence[str], where: str) -> DaemonSettings:
        """These settings for an antenna whose axes have these names: a configuration of `outer` and `inner` fits any
        antenna.

        Other names must be the antenna's own; BadInputError, which names `where` the antenna's stand, when they are
        not.
        """
        # a single axis is the carrying one of two, and the other one is not there
        outer, inner = (*names, INNER)[:2]
        if (outer, inner) == self.axis_names:
            return self
        if self.axis_names != (OUTER, INNER):
            expected = (
                f"{' and '.join(names)}, as in {where}, or {OUTER} and {INNER}, which fit any antenna of two axes"
            )
            raise BadInputError("axes", f"are {' and '.join(self.axis_names)}", expected)
        carried = self.axes[INNER].model_copy(update={"parent": outer})
        return self.model_copy(update={"axes": {outer: self.axes[OUTER], inner: carried}})

    def with_model(self) -> DaemonSettings:
        """These settings for a run: the model of `model_control` is in them, and which way is up, so that they stay
        what they are whatever a file says later. BadInputError for a file of other axes; shipped models fit by place.
        """
        from sim_backend.model import model_named

        control = self.model_control
        if control is None or control.document is not None:
            return self.looking(None)
        axes = {name: axis.with_entries(name) for name, axis in self.axes.items()}
        key = "model_control.model"
        model = model_named(control.model, key)
        if is_model_file(control.model) and self.axis_names not in ((OUTER, INNER), model.axes):
            problem = f"{control.model} has the axes {' and '.join(model.axes)}"
            raise BadInputError(key, problem, f"a model of {' and '.join(self.axis_names)}")
        # how its base moves, perhaps by a file of its own, is nothing that a loop takes
        document = {key: value for key, value in model.document.items() if key != "base"}
        kept = control.model_copy(update={"document": document})
        return self.model_copy(update={"model_control": kept, "axes": axes}).looking(None)

    def looking(self, antenna: AntennaModel | None) -> DaemonSettings:
        """These settings with the boresight of an antenna, else of the model that they name, said in them;
        BadInputError where they say another one.
        """
        from sim_backend.model import model_named

        said, named = self.pointing.boresight, self.observed_model or (self.model_control and self.model_control.model)
        if antenna is None and named:
            antenna = model_named(named, "observer.model")
        found = antenna.file.boresight if antenna is not None else said or Boresight.AHEAD
        if said not in (None, found) and antenna is not None:
            raise BadInputError(
                "pointing.boresight", f"is {said}, and {antenna.where} says {found}", f"{found}, or none"
            )
        return self.model_copy(update={"pointing": self.pointing.model_copy(update={"boresight": found})})

    @property
    def observed_model(self) -> str | None:
        """The model beside the antenna, a shipped name or a path; None where there is none."""
        if not self.observer.enabled:
            return None
        own = self.link.embedded.model if isinstance(self.link, EmbeddedAntenna) else None
        return self.observer.model or own

    @property
    def observer_bandwidth_hz(self) -> float:
        """How fast the model beside the antenna follows: at a rate that is not far above, it would be unstable."""
        return min(self.observer.bandwidth_hz, self.rate_hz / 20.0)

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


def settings_from_document(document: object, where: str, folder: Path | None = None) -> DaemonSettings:
    """Check a configuration given as a mapping; BadInputError as in `load_settings`. A model's path counts from
    `folder`.
    """
    if not isinstance(document, dict):
        raise BadInputError(where, "holds no mapping", "the keys " + ", ".join(_KEYS))
    settings = validated(DaemonSettings, document, where, LINK_KINDS)
    observed = settings.observer.model
    if folder is not None and observed is not None and is_model_file(observed):
        found = settings.observer.model_copy(update={"model": str((folder / observed).resolve())})
        settings = settings.model_copy(update={"observer": found})
    control = settings.model_control
    if control is not None and folder is not None and is_model_file(control.model):
        update = {"model": str((folder / control.model).resolve())}
        settings = settings.model_copy(update={"model_control": control.model_copy(update=update)})
    if folder is not None:
        axes = {name: axis.with_paths_from(folder) for name, axis in settings.axes.items()}
        settings = settings.model_copy(update={"axes": axes})
    link = settings.link
    if not isinstance(link, EmbeddedAntenna):
        from firmware_protocol.links import require_link_carries

        require_link_carries(link, settings.rate_hz, f"{where}: rate_hz")
        if isinstance(link, AdapterLinkConfig):
            return adapted(settings, link, where, folder)
    elif folder is not None and is_model_file(link.embedded.model):
        embedded = link.embedded.model_copy(update={"model": str((folder / link.embedded.model).resolve())})
        return settings.model_copy(update={"link": EmbeddedAntenna(embedded=embedded)})
    return settings


def with_changes(settings: DaemonSettings, changes: Mapping[str, object], where: str = "changes") -> DaemonSettings:
    """Settings in which the values at dotted keys (`axes.outer.rate_loop.kp_s_per_rad`) are others; BadInputError where
    they do not fit together.
    """
    document = settings.model_dump(mode="json", by_alias=True)
    for key, value in changes.items():
        *parents, last = key.split(".")
        section = document
        for name in parents:
            section = section[name]
        section[last] = value
    return settings_from_document(document, where)


#: guards of an axis that hold a rate against its position, and say nothing where the rate is made of it
_TWO_NUMBER_GUARDS = ("gyro_encoder_rad_s", "gyro_encoder_rad", "stuck_gyro_ticks")


def adapted(settings: DaemonSettings, link: AdapterLinkConfig, where: str, folder: Path | None) -> DaemonSettings:
    """Settings whose drives know rate and deadman; paths count from `folder`.

    BadInputError for a drive that is none, for torque that a drive must not give, and for guards that need a sensor
    which the drive does not have: a guard that cannot trip is none.
    """
    from firmware_protocol.adapters import Gives, gives_of, require_drives

    def found(path: Path | None) -> Path | None:
        return path if path is None or folder is None else (folder / path).resolve()

    if settings.supervisor.unnamed_axis is UnnamedAxisChoice.BRAKE:
        problem = f"drives of another make (`{link.drive}`) have no brake that this side closes"
        raise BadInputError(f"{where}: supervisor.unnamed_axis", problem, "position or free")
    drives = tuple(drive.model_copy(update={"map": found(drive.map)}) for drive in link.drives)
    given = link.model_fields_set
    follows: dict[str, object] = {"drives": drives}
    if "rate_hz" not in given:
        follows["rate_hz"] = settings.rate_hz
    if "watchdog_s" not in given:
        follows["watchdog_s"] = settings.supervisor.deadman.window_ticks * settings.step_s
    for drive, (name, axis) in zip(drives, settings.axes.items(), strict=True):
        place = f"{where}: axes.{name}.limits"
        if axis.limits.torque_nm > drive.torque_nm:
            expected = f"at most {drive.torque_nm:g} N m, the drive's torque_nm"
            raise BadInputError(f"{place}.torque_nm", f"{axis.limits.torque_nm:g} N m", expected)
        with refused_below(where):
            given_by_drive = gives_of(link.drive, drive)
        if Gives.GYRO not in given_by_drive and Gives.RATE not in given_by_drive:
            guard = next((one for one in _TWO_NUMBER_GUARDS if getattr(axis.limits, one) is not None), None)
            if guard is not None:
                problem = f"drive {link.drive} tells no rate, so this guard could never trip"
                raise BadInputError(f"{place}.{guard}", problem, "no such key")
    with refused_below(where):
        require_drives(link.drive, drives)
    return settings.model_copy(update={"link": link.model_copy(update=follows)})
