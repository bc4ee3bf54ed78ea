"""From a model file to the numbers that the loops take from it: bodies, friction, sensors, delay, observer gains."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.errors import BadInputError
from gimbal_hil.loop.control import ObservedJoint
from gimbal_hil.loop.control import layout as control
from gimbal_hil.loop.host import layout
from gimbal_hil.loop.settings.axis import AxisSettings, JointObserver
from gimbal_hil.loop.settings.daemon import DaemonSettings
from gimbal_hil.loop.settings.learning import ModelControl

if TYPE_CHECKING:
    from sim_backend.model import AntennaModel, EffectEntry

_FRICTION = ("breakaway", "coulomb", "stribeck_velocity", "sigma0", "sigma1", "viscous", "shape")
#: watch over the model: time in which it fades; least rms of what is fed forward that is judged, over the torque limit;
#: window for loops that shake (s), and the rms at which their torque may change, torque limits a second
_FADE_S, _LEAST_TOLD, _SHAKING_S, _MOST_SHAKING_PER_S = 0.5, 0.005, 0.25, 40.0
#: a sensor without noise or steps is still not believed beyond this
_LEAST_NOISE_RAD, _LEAST_NOISE_RAD_S = 1e-7, 1e-5
#: largest entry of a learned table over the torque limit, unless it is given
_LARGEST_LEARNED = 0.1
#: the temperature that a model's plain numbers hold for
_COOL_DEGC = 20.0


def fill_model_control(C: NDArray[np.float64], settings: DaemonSettings, chosen: ModelControl) -> None:
    """Put what `chosen` asks for into `C`; BadInputError for a model that is not of two axes."""
    from firmware_protocol.compiling import interpreted
    from sim_backend.model import ModelKind, model_from_document, model_named, plant_arrays
    from sim_backend.rigid_body import body_numbers

    kept = chosen.document
    key = "model_control.model"
    model = model_named(chosen.model, key) if kept is None else model_from_document(kept, chosen.model)
    if model.kind is not ModelKind.GIMBAL:
        raise BadInputError(key, f"{model.name} is {model.kind.value}", "a gimbal of two axes")
    C[layout.EXTRAPOLATES_BASE] = float(chosen.extrapolate_base)
    C[layout.FEEDS_BODIES] = float(chosen.bodies)
    arrays = plant_arrays(model, settings.rate_hz)
    P = arrays.P
    C[layout.MODEL_TENSOR : layout.MODEL_BODY] = P[: layout.MODEL_BODY - layout.MODEL_TENSOR]
    numbers = interpreted(body_numbers)(P, arrays.K, (0.0, 1.0))
    flat = [value for part in numbers for value in part]
    C[layout.MODEL_BODY : layout.MODEL_BODY + len(flat)] = flat
    for place, (name, (called, section)) in enumerate(zip(model.axes, settings.axes.items(), strict=True)):
        block = C[layout.axis_c(place) : layout.axis_c(place) + layout.AXIS_C_SIZE]
        block[control.INERTIA] = model.number(name, model.own_inertia_path(name)) + (
            model.number(model.axes[1], "body.inertia.zz") if place == 0 else 0.0
        )
        block[control.FRICTION_FORWARD] = float(chosen.friction)
        block[control.FRICTION : control.FRICTION + len(_FRICTION)] = [
            model.number(name, f"friction.{key}") for key in _FRICTION
        ]
        if chosen.watch:
            limit, step_s = section.limits.torque_nm, settings.step_s
            block[control.WATCH_SHARE], block[control.FADE_STEP] = step_s / chosen.watch_time_s, step_s / _FADE_S
            block[control.LEAST_TOLD] = (_LEAST_TOLD * limit) ** 2
            block[control.SHAKING_SHARE] = step_s / _SHAKING_S
            block[control.MOST_SHAKING] = (_MOST_SHAKING_PER_S * step_s * limit) ** 2
        if chosen.temperature:
            _fill_temperature(block, model, name)
        if chosen.position_torque:
            _fill_position_torque(block, model, name)
        _fill_learning(block, section, called, settings.step_s)
        block[control.DELAY_TICKS] = delay_ticks(model, name, settings.step_s, section.observer)
        if section.observer is not None:
            joint = observed_joint(model, name, settings.step_s, section.observer)
            block[control.OBSERVED] = 1.0
            own = section.observer
            block[control.OBSERVER_POSITION_KP] = own.position_kp_per_s or section.position_loop.kp_per_s
            block[control.OBSERVER_RATE_KP] = own.rate_kp_s_per_rad or section.rate_loop.kp_s_per_rad
            block[control.GYRO_LAG : control.GYRO_LAG + 6] = joint.gyro_lag
            block[control.OBSERVER_GAIN : control.OBSERVER_GAIN + 2 * control.OBSERVER_STATES] = _gains(joint)


def _fill_temperature(block: NDArray[np.float64], model: AntennaModel, axis: str) -> None:
    """How friction changes with the motor's temperature, where the model says so."""
    rows = model.friction_over_temperature.get(axis, ())
    block[control.FRICTION_ROWS] = len(rows)
    for number, row in enumerate(rows):
        place = control.FRICTION_TABLE + number * control.FRICTION_ROW_SIZE
        block[place : place + len(row)] = row
    if rows and block[control.FRICTION_TC] == 0.0:
        # limits of sliding and of the watch are those of a cool joint
        table = np.array(rows)
        block[control.FRICTION : control.FRICTION + len(_FRICTION)] = [
            np.interp(_COOL_DEGC, table[:, 0], column) for column in table[:, 1:].T
        ]
    block[control.VISCOSITY_FALL] = sum(
        entry.value("temperature_coefficient") for entry in _effects(model, axis, "temperature_viscosity")
    )


def _fill_position_torque(block: NDArray[np.float64], model: AntennaModel, axis: str) -> None:
    """Torque over position that the model names; BadInputError for more ripples than there is room for."""
    ripples = _effects(model, axis, "cogging")
    if len(ripples) > control.MOST_RIPPLES:
        raise BadInputError(
            f"{model.where}: effects",
            f"{len(ripples)} cogging ripples of {axis} to be fed forward",
            f"at most {control.MOST_RIPPLES}, or model_control.position_torque: false",
        )
    block[control.NAMED_FORWARD] = 1.0
    block[control.RIPPLE_COUNT] = len(ripples)
    for number, entry in enumerate(ripples):
        place = control.RIPPLES + number * control.RIPPLE_SIZE
        block[place : place + control.RIPPLE_SIZE] = [entry.value(key) for key in ("amplitude", "order", "phase")]
    pull = 0.0
    for entry in _effects(model, axis, "cable_spring"):
        block[control.CABLE_STIFFNESS] += entry.value("stiffness")
        pull += entry.value("stiffness") * entry.value("rest_position")
    if block[control.CABLE_STIFFNESS] > 0.0:
        block[control.CABLE_REST] = pull / block[control.CABLE_STIFFNESS]
    block[control.DRIVE_OFFSET] = model.number(axis, "actuator.offset")


def _fill_learning(block: NDArray[np.float64], section: AxisSettings, axis: str, step_s: float) -> None:
    """What an axis takes from its residual."""
    levels, learned = section.friction_levels, section.learned
    if levels is not None:
        block[control.ADAPT_SHARE] = step_s / levels.window_s
        block[control.LEAST_LEVEL], block[control.LARGEST_LEVEL] = levels.least, levels.largest
    if learned is not None:
        largest = learned.largest_nm or _LARGEST_LEARNED * section.limits.torque_nm
        block[control.LEARNS], block[control.LEARN_SHARE], block[control.LARGEST_LEARNED] = 1.0, learned.share, largest
        block[control.SLOWEST_LEARNED], block[control.FASTEST_LEARNED] = learned.slowest_rad_s, learned.fastest_rad_s
        for number, forward, backward in learned.entries_of(axis):
            for side, torque in enumerate((forward, backward)):
                place = control.GIVEN_TABLE + side * control.LEARNED_BINS + number
                block[place] = min(max(torque, -largest), largest)


def _effects(model: AntennaModel, axis: str, name: str) -> list[EffectEntry]:
    return [entry for entry in model.effects if entry.effect.name == name and entry.axis == axis]


def observed_joint(model: AntennaModel, axis: str, step_s: float, observer: JointObserver) -> ObservedJoint:
    """What the observer of one joint is made of: the sensors' noises and lag by the model."""
    from sim_backend.model import gyro_filter

    def noise(sensor: str, least: float) -> float:
        step = model.number(axis, f"{sensor}.step")
        return max(least, math.hypot(model.number(axis, f"{sensor}.noise"), step / math.sqrt(12.0)))

    bandwidth = model.number(axis, "gyro.bandwidth")
    lag = gyro_filter(bandwidth, model.number(axis, "gyro.damping"), step_s) if bandwidth > 0.0 else (0.0,) * 6
    return ObservedJoint(
        step_s,
        noise("encoder", _LEAST_NOISE_RAD),
        noise("gyro", _LEAST_NOISE_RAD_S),
        observer.bandwidth_rad_s,
        observer.offset_walk_rad_s,
        lag,
        observer.gusts_above_rad_s or math.inf,
    )


def delay_ticks(model: AntennaModel, axis: str, step_s: float, observer: JointObserver | None = None) -> int:
    """Whole ticks from a torque to its effect: transport delays and the actuator's lag."""
    if observer is not None and observer.delay_ticks is not None:
        return observer.delay_ticks
    late_s = model.number(axis, "actuator.time_constant")
    late_s += sum(e.value("delay") for e in model.effects if e.effect.name == "transport_delay" and e.axis == axis)
    return min(round(late_s / step_s), control.MOST_DELAY_TICKS)


@lru_cache(maxsize=64)
def _gains(joint: ObservedJoint) -> tuple[float, ...]:
    return tuple(joint.gains().ravel().tolist())
