"""What the antenna's maker sets in its firmware: limits, travel, deadman, how it stops. Converted once to raw integers
in `Drive`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from firmware_protocol import mail as m
from firmware_protocol.enumerations import StopReaction
from firmware_protocol.errors import BadInputError
from firmware_protocol.schema import POSITION_STEP_RAD, RATE_STEP_RAD_S, TORQUE_STEP_NM, name_code
from sim_backend.device.records import DRIVE, DRIVE_WORDS, NO_SEQUENCE, SCALE, Drive, Joint
from sim_backend.layout import BRAKE_DAMPING, BRAKE_STIFFNESS, BRAKE_TORQUE, SHORT_DAMPING, STEP_S, axis_block
from sim_backend.model import ENDLESS, AntennaModel, ModelKind

#: largest torque and rate that the wire can carry, the torque with exponent 0
WIRE_TORQUE_NM = m.SET_POINT_TORQUE_OUTER_HIGH * TORQUE_STEP_NM
_MOST_EXPONENT = m.IDENTITY_UNIT_TORQUE_EXPONENT_OUTER_HIGH
WIRE_RATE_RAD_S = m.FEEDBACK_OUTER_RATE_HIGH * RATE_STEP_RAD_S
#: turns of the encoder that the wire can carry, in rad either way
WIRE_POSITION_RAD = m.FEEDBACK_OUTER_POSITION_HIGH * POSITION_STEP_RAD


#: window in which the runaway guard adds up momentum
_MOMENTUM_WINDOW_S = 0.03
#: how stiff a holding brake is: the natural frequency of the axis on it
_BRAKE_BANDWIDTH_RAD_S = 500.0


class TravelReaction(IntEnum):
    """What the drive does beyond a travel limit; torque that leads further out is cut in any case."""

    CUT_TORQUE = 0
    FAULT = 1


@dataclass(frozen=True)
class DriveAxisSettings:
    """Limits of one axis and what its stopping law is tuned for. A linear axis reads N for N m, m for rad, kg for kg
    m2.
    """

    torque_limit_nm: float
    inertia_kg_m2: float
    #: joint positions at which torque outward is cut; infinite without a limit
    travel_low_rad: float = -math.inf
    travel_high_rad: float = math.inf
    #: joint rate beyond which torque that drives on is cut, and rate (joint or gyro) that is a fault
    rate_limit_rad_s: float = 15.0
    overspeed_rad_s: float = 18.0
    max_temperature_degc: float = 120.0
    #: deceleration of a quick stop
    deceleration_rad_s2: float = 10.0
    #: damping of the shorted motor in N m s/rad
    brake_damping: float = 0.0
    #: torque of the holding brake; 0 without one
    holding_torque_nm: float = 0.0
    #: most torque that is not the motor's, on any base: weight, friction, coupling; more is a runaway, 0 for no such
    #: guard
    strange_torque_nm: float = 0.0
    #: torques on the wire count `TORQUE_STEP_NM` times two to this
    torque_exponent: int = 0

    def check(self, where: str) -> None:
        """BadInputError names the first key that cannot be."""
        for key in ("torque_limit_nm", "inertia_kg_m2", "rate_limit_rad_s", "overspeed_rad_s", "deceleration_rad_s2"):
            _require(getattr(self, key) > 0.0, f"{where}.{key}", getattr(self, key), "a positive number")
        _require(
            0 <= self.torque_exponent <= _MOST_EXPONENT,
            f"{where}.torque_exponent",
            self.torque_exponent,
            f"0 to {_MOST_EXPONENT}",
        )
        most = WIRE_TORQUE_NM * 2.0**self.torque_exponent
        _require(
            self.torque_limit_nm <= most,
            f"{where}.torque_limit_nm",
            self.torque_limit_nm,
            f"at most {most:g}, or a torque_exponent",
        )
        _require(self.holding_torque_nm >= 0.0, f"{where}.holding_torque_nm", self.holding_torque_nm, "0 or more")
        _require(
            self.overspeed_rad_s <= WIRE_RATE_RAD_S,
            f"{where}.overspeed_rad_s",
            self.overspeed_rad_s,
            f"at most {WIRE_RATE_RAD_S:g}",
        )
        _require(
            self.travel_low_rad < self.travel_high_rad,
            f"{where}.travel_low_rad",
            self.travel_low_rad,
            "a number below travel_high_rad",
        )
        _require(self.strange_torque_nm >= 0.0, f"{where}.strange_torque_nm", self.strange_torque_nm, "0 or more")
        _require(self.brake_damping >= 0.0, f"{where}.brake_damping", self.brake_damping, "0 or more")


@dataclass(frozen=True)
class FirmwareSettings:
    """Settings of the drive; `for_model` gives what suits an antenna."""

    axes: tuple[DriveAxisSettings, ...]
    #: who the antenna says it is
    name: str = ""
    serial_number: int = 1
    #: deadman until the host sends its own
    deadman_window_ticks: int = 10
    deadman_reaction: StopReaction = StopReaction.BRAKE
    #: what the drive does in a fault that is not the link's; holding needs sensors and supply, without them it brakes
    fault_reaction: StopReaction = StopReaction.BRAKE
    travel_reaction: TravelReaction = TravelReaction.FAULT
    #: self-test after power-up, at least one tick
    startup_ticks: int = 10
    #: drive_control unheard for so long while torque is on is a fault; 0 switches this off
    control_silence_ticks: int = 1000
    supply_v: float = 28.0
    min_supply_v: float = 18.0
    #: encoder and gyro that differ by more are a fault: more than any base turns
    disagreement_rad_s: float = 4.0
    #: and by more than this while the drive stops: it stops without them
    stop_disagreement_rad_s: float = 1.0
    #: an axis is at rest below this joint rate for rest_s; then it is held for hold_s
    rest_rate_rad_s: float = 0.01
    rest_s: float = 0.05
    hold_s: float = 2.0
    #: a fault reaction that has not come to rest after this time lets go
    reaction_timeout_s: float = 2.0
    #: triple pole of the stopping law
    stop_bandwidth_rad_s: float = 25.0
    #: what a holding brake takes to close
    brake_closing_s: float = 0.02

    @classmethod
    def for_model(cls, model: AntennaModel) -> FirmwareSettings:
        """Torque limits and travel of the model, stopping tuned for its inertia with half the torque for
        deceleration.
        """
        return cls(tuple(_axis_for(model, index, axis) for index, axis in enumerate(model.axes)), name=model.name)

    def check(self, where: str = "firmware") -> None:
        """BadInputError names the first key that cannot be."""
        _require(
            1 <= self.deadman_window_ticks <= 255,
            f"{where}.deadman_window_ticks",
            self.deadman_window_ticks,
            "1 to 255",
        )
        _require(self.startup_ticks >= 1, f"{where}.startup_ticks", self.startup_ticks, "1 or more")
        for field in fields(self):
            value = getattr(self, field.name)
            if isinstance(value, int | float):
                _require(
                    value >= 0 and math.isfinite(value), f"{where}.{field.name}", value, "a finite number, 0 or more"
                )
        for index, axis in enumerate(self.axes):
            axis.check(f"{where}.axes.{index}")


def _require(holds: bool, where: str, value: float, expected: str) -> None:
    if not holds:
        raise BadInputError(where, f"{value:g} cannot be", expected)


def _axis_for(model: AntennaModel, index: int, axis: str) -> DriveAxisSettings:
    inertia = model.number(axis, model.own_inertia_path(axis))
    if model.kind is ModelKind.GIMBAL and index == 0:
        # the outer joint carries the inner gimbal along
        inertia += model.number(model.axes[1], "body.inertia.zz")
    limit = model.number(axis, "actuator.limit")
    torque = limit if limit > 0.0 else WIRE_TORQUE_NM
    exponent = max(0, math.ceil(math.log2(torque / WIRE_TORQUE_NM)))
    ends = abs(model.number(axis, "travel.low")) < ENDLESS or abs(model.number(axis, "travel.high")) < ENDLESS
    return DriveAxisSettings(
        torque_limit_nm=torque,
        inertia_kg_m2=inertia,
        travel_low_rad=model.number(axis, "travel.low") if ends else -math.inf,
        travel_high_rad=model.number(axis, "travel.high") if ends else math.inf,
        deceleration_rad_s2=0.5 * torque / inertia,
        brake_damping=20.0 * inertia,
        holding_torque_nm=torque if _weight_moves(model, index, axis) else 0.0,
        strange_torque_nm=_heaviest(model, index, axis),
        torque_exponent=exponent,
    )


def _heaviest(model: AntennaModel, index: int, axis: str) -> float:
    """Most torque that weight and friction have on an axis, however the base stands, at the rate at which torque is
    cut.
    """
    friction = (
        model.number(axis, "friction.breakaway")
        + model.number(axis, "friction.viscous") * DriveAxisSettings.rate_limit_rad_s
    )
    if model.kind is ModelKind.LINEAR:
        return friction + model.number(axis, "body.mass") * model.file.gravity_m_s2
    # a lever along the outer axis counts no weight; what it carries may be turned anyhow
    moment = _moment(model, axis, "xy" if index == 0 else "xyz")
    if model.kind is ModelKind.GIMBAL and index == 0:
        moment += _moment(model, model.axes[1], "xyz")
    return friction + moment * model.file.gravity_m_s2


def _moment(model: AntennaModel, axis: str, along: str) -> float:
    """Mass times distance of an axis' centre of gravity, kg m, counted along these axes of the body."""
    return math.hypot(*(model.number(axis, f"body.cog.{x}") for x in along)) * model.number(axis, "body.mass")


def _weight_moves(model: AntennaModel, index: int, axis: str) -> bool:
    """Whether an axis may fall when nothing holds it on a level base: the inner one of a gimbal, whose weight is more
    than its friction.
    """
    if model.kind is not ModelKind.GIMBAL or index == 0:
        return False
    lever = math.hypot(model.number(axis, "body.cog.x"), model.number(axis, "body.cog.z"))
    return lever * model.number(axis, "body.mass") * model.file.gravity_m_s2 > model.number(axis, "friction.breakaway")


def settings_to_state(settings: FirmwareSettings, rate_hz: float) -> NDArray[np.int64]:
    """Words of a `Drive` that has just got its supply: int64 (DRIVE_WORDS,), settings in raw integers for ticks at
    `rate_hz`.
    """
    settings.check()
    words = np.zeros(DRIVE_WORDS, dtype=np.int64)
    drive: Drive = words.view(DRIVE)[0]
    drive.last_sequence = NO_SEQUENCE
    drive.window, drive.reaction = settings.deadman_window_ticks, settings.deadman_reaction
    # an edge needs a level that was seen low before
    drive.reset_level = 1
    drive.supply = round(settings.supply_v / m.MOTOR_STATUS_OUTER_SUPPLY_STEP)
    drive.min_supply = round(settings.min_supply_v / m.MOTOR_STATUS_OUTER_SUPPLY_STEP)
    drive.startup_ticks, drive.control_silence_ticks = settings.startup_ticks, settings.control_silence_ticks
    drive.travel_reaction, drive.fault_reaction = settings.travel_reaction, settings.fault_reaction
    drive.rest_rate = round(settings.rest_rate_rad_s / RATE_STEP_RAD_S)
    drive.max_disagreement = round(settings.disagreement_rad_s / RATE_STEP_RAD_S)
    drive.stop_disagreement = round(settings.stop_disagreement_rad_s / RATE_STEP_RAD_S)
    drive.rest_ticks, drive.hold_ticks = round(settings.rest_s * rate_hz), round(settings.hold_s * rate_hz)
    drive.reaction_ticks = round(settings.reaction_timeout_s * rate_hz)
    drive.rate_of_count = round(POSITION_STEP_RAD * rate_hz / RATE_STEP_RAD_S * SCALE)
    drive.count_of_rate = round(RATE_STEP_RAD_S / (POSITION_STEP_RAD * rate_hz) * SCALE)
    drive.name_code, drive.serial_number = name_code(settings.name), settings.serial_number
    drive.momentum_kept = round(math.exp(-1.0 / (_MOMENTUM_WINDOW_S * rate_hz)) * SCALE)
    drive.brake_ticks = round(settings.brake_closing_s * rate_hz)
    for index, axis in enumerate(settings.axes):
        _fill_joint(drive.joints[index], axis, settings, rate_hz)
    return words


def settings_to_plant(settings: FirmwareSettings, P: np.ndarray) -> None:
    """Fill in what the plant has from the drive: shorted windings and holding brakes."""
    for index, axis in enumerate(settings.axes):
        block = axis_block(index)
        # as stiff as a step of the plant can follow
        bandwidth = min(_BRAKE_BANDWIDTH_RAD_S, 0.3 / P[STEP_S])
        P[block + SHORT_DAMPING] = min(axis.brake_damping, 0.2 * axis.inertia_kg_m2 / P[STEP_S])
        P[block + BRAKE_TORQUE] = axis.holding_torque_nm
        P[block + BRAKE_STIFFNESS] = bandwidth * bandwidth * axis.inertia_kg_m2
        P[block + BRAKE_DAMPING] = bandwidth * axis.inertia_kg_m2


def _fill_joint(joint: Joint, axis: DriveAxisSettings, settings: FirmwareSettings, rate_hz: float) -> None:
    step = TORQUE_STEP_NM * 2**axis.torque_exponent
    joint.exponent, joint.torque_limit = (
        axis.torque_exponent,
        math.floor(axis.torque_limit_nm / step + 1e-9),
    )
    if axis.holding_torque_nm > 0.0:
        # a brake holds without power: it is closed when the drive wakes up
        joint.has_brake, joint.brake_state = 1, m.BRAKE_STATE_RELEASED
        joint.brake_age = round(settings.brake_closing_s * rate_hz)
    joint.travel_low = _counts(axis.travel_low_rad)
    joint.travel_high = _counts(axis.travel_high_rad)
    joint.rate_limit, joint.overspeed = (
        round(axis.rate_limit_rad_s / RATE_STEP_RAD_S),
        round(axis.overspeed_rad_s / RATE_STEP_RAD_S),
    )
    joint.max_winding = round(axis.max_temperature_degc / m.MOTOR_STATUS_OUTER_TEMPERATURE_STEP)
    # torque from rate, count, and count and tick; a triple pole at w: I (3 w, 3 w^2, w^3). A torque that is held for a
    # tick and a rate that is low-passed over four cannot be faster than this share of the tick rate
    per_rate = SCALE * RATE_STEP_RAD_S / step
    per_count = SCALE * POSITION_STEP_RAD / step
    inertia, w = axis.inertia_kg_m2, min(settings.stop_bandwidth_rad_s, rate_hz / 40.0)
    joint.stop_rate_gain = round(3.0 * w * inertia * per_rate)
    joint.stop_position_gain = round(3.0 * w * w * inertia * per_count)
    joint.stop_integral_gain = round(w * w * w * inertia * per_count / rate_hz)
    joint.impulse_of_rate = round(inertia * rate_hz * per_rate)
    # held within the torque of the axis times the window, so that a number that is too large is a guard that never
    # trips
    strange = min(axis.strange_torque_nm, 100.0 * axis.torque_limit_nm)
    joint.strange_impulse = round(strange / step * _MOMENTUM_WINDOW_S * rate_hz * SCALE)
    joint.stop_rate_per_tick = max(1, round(axis.deceleration_rad_s2 / rate_hz / RATE_STEP_RAD_S))


def _counts(position_rad: float) -> int:
    """Raw position; a limit beyond the wire's range, or an infinite one, is never reached."""
    if abs(position_rad) >= WIRE_POSITION_RAD:
        return int(math.copysign(1 << 40, position_rad))
    return round(position_rad / POSITION_STEP_RAD)
