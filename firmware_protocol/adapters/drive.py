"""What a drive of somebody else must be able to do for an axis, and what stands in the configuration for one.

A drive is sans-IO: it answers the frames to send and is given the frames that came. Its numbers are those of its own
shaft and signs; `on_the_joint` makes them the joint's.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import Enum
from typing import Protocol, runtime_checkable

from firmware_protocol.links import CanFrame, DriveSection

#: of a drive that does not say how fast it answers, s
_ANSWERS_S = 0.25


class Power(Enum):
    """Whether the drive applies torque, and whose."""

    #: none
    OFF = "off"
    #: that of the set-points
    ON = "on"
    #: its own: it stops, or holds after a stop; set-points count for nothing
    STOPPING = "stopping, still under torque"
    #: its own after a fault, or it cannot be told whether
    REACTING = "in fault, still under torque"
    #: none, and none until it is reset
    FAULT = "in fault"

    @property
    def is_faulty(self) -> bool:
        """Whether a fault is told."""
        return self in (Power.REACTING, Power.FAULT)

    @property
    def is_powered(self) -> bool:
        """Whether there may be torque."""
        return self not in (Power.OFF, Power.FAULT)


class Gives(Enum):
    """What a drive may tell; the value says what is missing without it."""

    GYRO = (
        "inertial rate: the drive's own rate stands in, right on a base that rests, also in the guards that hold gyro "
        "against encoder; absent is the reaction gyro_stop"
    )
    RATE = (
        "rate: this side differentiates the position; absent are the guards gyro_encoder_rad_s, gyro_encoder_rad and "
        "stuck_gyro_ticks, which need two numbers"
    )
    SHORT = (
        "shorted winding: a stop that may use no sensor switches torque off instead; the axis coasts, or falls, unless "
        "a brake of the drive's closes"
    )
    DEADMAN_ECHO = (
        "deadman margin: this side counts by itself; what stops a drive whose host is gone is the drive's own watchdog"
    )
    SEQUENCE = "echo of the set-point's number: a set-point counts as acted on when the drive's next feedback comes"
    TORQUE = "measured torque"
    TEMPERATURE = "winding temperature: absent is the guard winding_degc"
    SUPPLY = "supply voltage"


@dataclass(frozen=True)
class DriveTiming:
    """Time between set-points, and how long a set-point may be kept, both s."""

    period_s: float
    watchdog_s: float


@dataclass(frozen=True)
class AxisSample:
    """What a drive last said; None for what it never says. `updates` counts new positions, `power_updates` new words
    on power, None where each position comes with one.
    """

    updates: int = 0
    position_rad: float = 0.0
    rate_rad_s: float | None = None
    gyro_rad_s: float | None = None
    torque_nm: float | None = None
    temperature_degc: float | None = None
    supply_v: float | None = None
    power: Power = Power.OFF
    #: the drive's own word for its fault, as its manual lists it; empty where it told none
    fault: str = ""
    #: what speaks against relying on it though it works
    caution: str = ""
    power_updates: int | None = None

    @property
    def words(self) -> int:
        """How often it has said whether it is under torque."""
        return self.updates if self.power_updates is None else self.power_updates


class ForeignDrive(Protocol):
    """One drive; every method answers the frames that are to be sent for it."""

    gives: frozenset[Gives]
    sample: AxisSample
    #: whether each sample answers a question; else the drive sends by itself
    is_asked: bool

    def __init__(self, section: DriveSection, timing: DriveTiming) -> None:
        """From its section of the configuration."""

    def begin(self) -> list[CanFrame]:
        """After the bus was opened: whatever must be set once; no torque."""

    def ask(self) -> list[CanFrame]:
        """Ask for a sample; nothing for a drive that sends by itself."""

    def enable(self) -> list[CanFrame]:
        """One step towards torque, called each tick until `sample.power` is ON."""

    def command(self, torque_nm: float) -> list[CanFrame]:
        """A torque at the drive's shaft, which is to feed its watchdog, and the question for the next sample."""

    def release(self) -> list[CanFrame]:
        """No torque any more; repeated until `sample.power` says so."""

    def stop(self) -> list[CanFrame]:
        """The drive's own quick stop; `release` where it has none. Repeated while `sample.power` is ON."""

    def reset(self) -> list[CanFrame]:
        """Clear a latched fault; no torque."""

    def take(self, frame: CanFrame) -> bool:
        """Whether a frame is of this drive and was understood; `sample` is new then."""


@runtime_checkable
class StopsUnfed(Protocol):
    """A drive that can be told to stop, and asked, by frames that do not feed its watchdog. One without these gets no
    frame at all once it does not do as told, and has a quarter of a second for its word.
    """

    #: how long after an order its word may still be that from before, s
    answers_s: float

    def starve(self) -> list[CanFrame]:
        """Frames of a tick in which it does not do as told: no torque, and nothing that feeds its watchdog."""

    def leave(self) -> list[CanFrame]:
        """The last frames of a host that goes: its watchdog waits for nobody any more. Only where it has no torque."""


@runtime_checkable
class ShortsWindings(Protocol):
    """A drive that can short its motor's winding: it slows the axis and uses no sensor."""

    def short(self) -> list[CanFrame]:
        """Short it, without torque of the drive's own; repeated until `sample.power` says that there is none."""


def on_the_joint(sample: AxisSample, section: DriveSection) -> AxisSample:
    """A sample of the drive's shaft as one of the joint: gear, sign and zero."""
    sign, gear = section.sign, section.gear

    def turned(value: float | None, factor: float) -> float | None:
        return None if value is None else value * factor

    return replace(
        sample,
        position_rad=section.zero_rad + sign * sample.position_rad / gear,
        rate_rad_s=turned(sample.rate_rad_s, sign / gear),
        gyro_rad_s=turned(sample.gyro_rad_s, sign),
        torque_nm=turned(sample.torque_nm, sign * gear),
    )


def shaft_torque(torque_nm: float, section: DriveSection) -> float:
    """A torque at the joint as one at the drive's shaft, held at the largest; none where it is no number."""
    if not math.isfinite(torque_nm):
        return 0.0
    held = min(max(torque_nm, -section.torque_nm), section.torque_nm)
    return (section.sign) * held / section.gear


def starved(drive: ForeignDrive) -> list[CanFrame]:
    """Frames for a drive that is to be stopped by its own watchdog."""
    return drive.starve() if isinstance(drive, StopsUnfed) else []


def stopped_blindly(drive: ForeignDrive) -> list[CanFrame]:
    """Frames for a stop that uses no sensor: a shorted winding, or no torque where the drive cannot."""
    return drive.short() if isinstance(drive, ShortsWindings) else drive.release()


def farewell(drive: ForeignDrive) -> list[CanFrame]:
    """The last frames for a drive; one under torque keeps its watchdog."""
    return drive.leave() if isinstance(drive, StopsUnfed) and not drive.sample.power.is_powered else []


def answer_time_s(drive: ForeignDrive) -> float:
    """How long after an order a drive's word may still be that from before, s."""
    return drive.answers_s if isinstance(drive, StopsUnfed) else _ANSWERS_S


def missing_text(gives: frozenset[Gives]) -> list[str]:
    """What a drive that gives these does not give, each in a line for people."""
    return [f"not given: {one.value}" for one in Gives if one not in gives]
