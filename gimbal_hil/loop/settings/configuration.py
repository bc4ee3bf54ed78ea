"""From settings to the host core's configuration array `C`."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.enumerations import StopReaction
from firmware_protocol.schema import TORQUE_STEP_NM, name_code
from gimbal_hil.loop.control import AntiWindup
from gimbal_hil.loop.control import layout as control
from gimbal_hil.loop.host import MOMENTUM_WINDOW_S, UnnamedAxis, layout
from gimbal_hil.loop.settings.axis import AntiWindupChoice, AxisSettings
from gimbal_hil.loop.settings.daemon import DaemonSettings
from gimbal_hil.loop.settings.model_control import fill_model_control

#: by how much of its path a gyro may be wrong: its scale, and the share of other rates that it reads
_SENSOR_SHARE = 0.05
#: of the rate at which an axis is too fast, what the loops ask for at most
_ASKED_SHARE = 0.8
#: motion against torque: by how much of its impulse a torque may be wrong, ticks that it may act late
_MODEL_SHARE, _LATE_TICKS = 0.5, 3
_ANTI_WINDUP = {
    AntiWindupChoice.NONE: AntiWindup.NONE,
    AntiWindupChoice.CLAMPING: AntiWindup.CLAMPING,
    AntiWindupChoice.BACK_CALCULATION: AntiWindup.BACK_CALCULATION,
}


def host_configuration(settings: DaemonSettings) -> NDArray[np.float64]:
    """`C` for these settings, float64 (C_SIZE,)."""
    supervisor, ticks = settings.supervisor, settings.ticks
    C = np.zeros(layout.C_SIZE)
    C[layout.STEP_S] = settings.step_s
    C[layout.CONNECT_TICKS], C[layout.LOST_TICKS] = supervisor.connect_ticks, supervisor.lost_ticks
    C[layout.DEBOUNCE_TICKS], C[layout.SET_POINT_LAG_TICKS] = supervisor.debounce_ticks, supervisor.set_point_lag_ticks
    C[layout.SYNCHRONISE_TICKS], C[layout.RESET_PULSE_TICKS] = (
        ticks(supervisor.synchronise_time_s),
        ticks(supervisor.reset_pulse_time_s),
    )
    C[layout.STOP_TICKS], C[layout.REST_TICKS] = ticks(supervisor.stop_time_s), ticks(supervisor.rest_time_s)
    C[layout.FOLLOWING_TICKS], C[layout.BASE_LOST_TICKS] = (
        ticks(supervisor.following_time_s),
        ticks(supervisor.base_lost_time_s),
    )
    C[layout.CONTROL_TICKS] = ticks(0.1)
    C[layout.DEADMAN_WINDOW] = supervisor.deadman.window_ticks
    C[layout.DEADMAN_REACTION] = StopReaction[supervisor.deadman.reaction.name]
    C[layout.UNNAMED_AXIS] = UnnamedAxis[supervisor.unnamed_axis.name]
    C[layout.AUTOMATIC_RECONNECT] = float(supervisor.automatic_reconnect)
    pointing = settings.pointing
    C[layout.MUTE_BEYOND], C[layout.MUTE_BELOW] = pointing.mute_beyond_rad, pointing.mute_below_rad
    C[layout.MUTE_TICKS], C[layout.COAST_TICKS] = ticks(pointing.silence_s), ticks(pointing.coast_time_s)
    pinned = settings.antenna
    C[layout.PINNED_NAME] = -1.0 if pinned.name is None else name_code(pinned.name)
    C[layout.PINNED_SERIAL] = -1.0 if pinned.serial_number is None else pinned.serial_number
    C[layout.PLAUSIBILITY_SHARE] = -math.expm1(-settings.step_s / supervisor.gyro_encoder_time_s)
    C[layout.DRIFT_KEPT], C[layout.DRIFT_SHARE] = (
        math.exp(-settings.step_s / supervisor.gyro_encoder_window_s),
        _SENSOR_SHARE,
    )
    if supervisor.one_sensor_window_s is not None:
        C[layout.LONG_KEPT] = math.exp(-settings.step_s / supervisor.one_sensor_window_s)
        C[layout.LONG_WINDOW_S] = supervisor.one_sensor_window_s
    C[layout.LATE_S] = _LATE_TICKS * settings.step_s
    C[layout.MOMENTUM_KEPT], C[layout.MODEL_SHARE] = math.exp(-settings.step_s / MOMENTUM_WINDOW_S), _MODEL_SHARE
    for axis, section in enumerate(settings.axes.values()):
        block = C[layout.axis_c(axis) : layout.axis_c(axis) + layout.AXIS_C_SIZE]
        _fill_law(block, section, settings.step_s)
        _fill_limits(block, section)
        if settings.model_control is not None:
            block[control.SHAPED] = 1.0
        if section.expectation is not None and any(section.expectation.moment_kg_m):
            C[layout.EXPECTS_WEIGHT] = 1.0
    if settings.model_control is not None:
        fill_model_control(C, settings, settings.model_control)
    return C


def _fill_law(block: NDArray[np.float64], axis: AxisSettings, step_s: float) -> None:
    position, rate, forward = axis.position_loop, axis.rate_loop, axis.feedforward
    block[control.POSITION_KP], block[control.POSITION_KI] = position.kp_per_s, position.ki_per_s2
    block[control.POSITION_ANTI_WINDUP], block[control.POSITION_TRACKING] = (
        _ANTI_WINDUP[position.anti_windup],
        position.tracking_time_s,
    )
    # a limit that was lowered slows a motion down, instead of ending it
    most_rad_s = _ASKED_SHARE * axis.limits.rate_rad_s
    block[control.RATE_REFERENCE_LIMIT] = min(position.rate_limit_rad_s, most_rad_s)
    block[control.RATE_KP], block[control.RATE_KI] = rate.kp_s_per_rad, rate.ki_per_rad
    block[control.RATE_ANTI_WINDUP], block[control.RATE_TRACKING] = _ANTI_WINDUP[rate.anti_windup], rate.tracking_time_s
    block[control.TORQUE_SCALE] = rate.torque_per_unit_nm
    # a whole number of steps of the wire, so that rounding cannot lead beyond the limit
    block[control.TORQUE_LIMIT] = math.floor(axis.limits.torque_nm / TORQUE_STEP_NM + 1e-9) * TORQUE_STEP_NM
    if axis.prefilter is not None:
        corner = axis.prefilter.den[1] / axis.prefilter.den[0]
        block[control.PREFILTER_GAIN] = axis.prefilter.num / axis.prefilter.den[1]
        block[control.PREFILTER_DECAY], block[control.PREFILTER_CORNER] = math.exp(-step_s * corner), corner
        block[control.PREFILTER_RATE] = min(axis.prefilter.rate_rad_s or 0.0, most_rad_s)
        block[control.PREFILTER_ACCELERATION] = axis.prefilter.acceleration_rad_s2 or 0.0
    block[control.RATE_FEEDFORWARD], block[control.BASE_RATE_SHARE] = forward.reference_rate, float(forward.base_rate)
    block[control.COULOMB], block[control.VISCOUS] = forward.coulomb_nm, forward.viscous_nm_s_per_rad
    block[control.SIGN_WIDTH] = forward.sign_width_rad_s
    block[control.MOMENT_X : control.MOMENT_Z + 1] = forward.moment_kg_m


def _fill_limits(block: NDArray[np.float64], axis: AxisSettings) -> None:
    limits = axis.limits
    turns = math.inf if limits.cable_wrap_turns is None else 2.0 * math.pi * limits.cable_wrap_turns
    block[layout.POSITION_LOW] = _or_none(limits.position_low_rad, -math.inf)
    block[layout.POSITION_HIGH] = _or_none(limits.position_high_rad, math.inf)
    block[layout.WRAP_LOW], block[layout.WRAP_HIGH] = -turns, turns
    block[layout.TRAVEL_MARGIN], block[layout.MAX_RATE] = limits.travel_margin_rad, limits.rate_rad_s
    block[layout.MAX_FOLLOWING_POSITION] = _or_none(limits.following_position_rad, math.inf)
    block[layout.MAX_FOLLOWING_RATE] = _or_none(limits.following_rate_rad_s, math.inf)
    block[layout.MAX_DISAGREEMENT] = _or_none(limits.gyro_encoder_rad_s, math.inf)
    block[layout.BRAKING_RAD_S2], block[layout.REST_RATE] = limits.braking_rad_s2, limits.rest_rate_rad_s
    block[layout.MAX_TEMPERATURE] = limits.winding_degc
    block[layout.MAX_DRIFT], block[layout.STUCK_TICKS] = (
        _or_none(limits.gyro_encoder_rad, math.inf),
        limits.stuck_gyro_ticks or 0,
    )
    if axis.expectation is not None:
        block[layout.EXPECTED_INERTIA] = axis.expectation.inertia_kg_m2
        block[layout.DISTURBANCE] = axis.expectation.disturbance_nm * MOMENTUM_WINDOW_S
        block[layout.EXPECTED_MOMENT : layout.EXPECTED_MOMENT + 3] = axis.expectation.moment_kg_m


def _or_none(value: float | None, otherwise: float) -> float:
    return otherwise if value is None else value
