"""Model, configuration and plan of a described antenna, as the documents that their files hold.

Loops: the rate loop crosses at 120 rad/s where the rate allows it (0.12 rad/s for each hertz), its integrator a sixth
below, the position loop a sixth below that: as in the shipped configuration (docs/explanation/control.md). What limits
a step is the torque: the prefilter's corner is where a step of 1 rad just asks for most of it.
"""

from __future__ import annotations

import math

from firmware_protocol.json_object import Json
from gimbal_hil.surface.starting.description import ASSUMED, AntennaDescription, AxisDescription, friction_of
from sim_backend.model import ModelKind

Document = Json
_CROSSING_RAD_S, _CROSSING_SHARE = 120.0, 0.12
_GRAVITY = 9.81
#: what a mass off its axis and friction may ask for, at least, over the torque limit
_LEAST_DISTURBANCE = 0.3
_BRAKING_SHARE, _PREFILTER_SHARE = 0.4, 0.8
_FASTEST_PREFILTER = 8.0
#: speed of a long motion over what the position loop may ask for: the rest is for catching up
_MOTION_SHARE = 0.8
#: what may be changed while the daemon runs: bounds over the configured number
_ADJUSTABLE = {
    ("position_loop", "kp_per_s"): (0.5, 1.25),
    ("position_loop", "ki_per_s2"): (0.0, 1.5),
    ("rate_loop", "kp_s_per_rad"): (0.67, 1.33),
    ("rate_loop", "ki_per_rad"): (0.5, 1.33),
    ("limits", "torque_nm"): (0.2, 1.0),
    ("limits", "rate_rad_s"): (0.1, 1.0),
}


def _rounded(value: float) -> float:
    return float(f"{value:.4g}")


def model_document(antenna: AntennaDescription) -> Document:
    """The model: told numbers with a source that says so, the others assumed."""
    linear = antenna.kind is ModelKind.LINEAR
    lies = {"incline_sine": _rounded(math.sin(math.radians(antenna.tilt_deg)))}
    which_way = {"boresight": antenna.boresight.value} if antenna.kind is ModelKind.GIMBAL else lies
    return {
        "schema": 1,
        "name": antenna.name,
        "text": f"Written by gimbal-hil init. Numbers whose source is '{ASSUMED}' stand in until they are measured."
        + ("" if antenna.kind is ModelKind.GIMBAL or antenna.tilt_told else f" So does incline_sine ({ASSUMED})."),
        "kind": antenna.kind.value,
        **which_way,
        "axes": {axis.name: _model_axis(axis, linear, antenna, place) for place, axis in enumerate(antenna.axes)},
        "effects": [],
    }


def _model_axis(axis: AxisDescription, linear: bool, antenna: AntennaDescription, place: int) -> Document:
    torque = "N" if linear else "N m"
    angle = "m" if linear else "rad"
    units = {
        "coulomb": torque,
        "breakaway": torque,
        "stribeck_velocity": f"{angle}/s",
        "shape": "1",
        "sigma0": f"{torque}/{angle}",
        "sigma1": "N s/m" if linear else "N m s/rad",
        "viscous": "N s/m" if linear else "N m s/rad",
    }
    assert axis.mass_kg and axis.inertia_kg_m2 and axis.torque_nm and axis.encoder_counts
    step = 1e-3 / axis.encoder_counts if linear else 2.0 * math.pi / axis.encoder_counts
    body: Document = {"mass": _number(axis.mass_kg, "kg", axis.source("mass_kg"))}
    if not linear:
        about = axis.source("inertia_kg_m2", "mass_kg")
        body["inertia"] = {key: _number(axis.inertia_kg_m2, "kg m2", about) for key in ("xx", "yy", "zz")}
    actuator = {"limit": _number(axis.torque_nm, torque, axis.source("torque_nm"))}
    if axis.torque_constant_nm_a is not None:
        source = axis.source("torque_constant_nm_a")
        actuator["torque_constant"] = _number(axis.torque_constant_nm_a, f"{torque}/A", source)
    if axis.offset_m:
        body["cog"] = {"x": _number(axis.offset_m, "m", axis.source("offset_m"))}
    friction = friction_of(axis, antenna.kind)
    section: Document = {"parent": antenna.axes[0].name} if place else {}
    section |= {
        "body": body,
        "friction": {key: _number(value, units[key], source) for key, (value, source) in friction.items()},
        "actuator": actuator,
        "encoder": {"step": {"value": step, "unit": angle, "source": axis.source("encoder_counts"), "uncertainty": 0}},
    }
    if antenna.kind is ModelKind.GIMBAL and antenna.has_gyro:
        section["gyro"] = {
            "noise": _number(2.0e-4, "rad/s", ASSUMED),
            "step": {"value": 1.0e-5, "unit": "rad/s", "source": "the wire's", "uncertainty": 0},
        }
    return section


def _number(value: float, unit: str, source: str) -> Document:
    return {"value": _rounded(value), "unit": unit, "source": source}


def configuration_document(antenna: AntennaDescription, model_file: str, link: Document | None) -> Document:
    """The configuration of a gimbal; without a link section on the virtual antenna of `model_file`."""
    return {
        "schema": 1,
        "rate_hz": antenna.rate_hz,
        "link": link or {"embedded": {"model": model_file, "seed": 1}},
        "axes": {axis.name: _loops(antenna, place) for place, axis in enumerate(antenna.axes)},
        "supervisor": _supervisor(antenna, antenna.link.is_simulated and link is not None),
        "recording": {"frames": True, "every_ticks": 1},
        "operator": {"enabled": True},
        # what the model lacks shows while the antenna runs
        "observer": {"model": model_file},
    }


def _supervisor(antenna: AntennaDescription, simulated: bool) -> Document:
    """How long either end waits for the other. Both ends of a simulation are stopped by the machine for 20 to 200 ms
    now and then, and there is nothing to protect; hardware keeps its time, and its deadman is short.
    """
    lost_ticks, lag_ticks, window_ticks = (100, 200, 250) if simulated else (5, 10, 20)
    section: Document = {
        "lost_ticks": lost_ticks,
        "set_point_lag_ticks": lag_ticks,
        "deadman": {"window_ticks": window_ticks, "reaction": "decelerate_and_hold"},
    }
    # a rate that is the encoder's own has no bias that adds up
    own_rate = antenna.link.tells_rate and not antenna.has_gyro
    return section | ({"one_sensor_window_s": 60.0} if own_rate else {})


def link_document(antenna: AntennaDescription) -> Document | None:
    """The `link` section: none for a virtual antenna; drives of another make with ids 1 and 2 and the axes' torques."""
    if antenna.link.is_virtual:
        return None
    if not antenna.link.is_drives:
        return antenna.link.section
    drives = []
    for number, axis in enumerate(antenna.axes, 1):
        drive: Document = {"id": number, "torque_nm": _rounded(axis.torque_nm or 0.0), "sign": 1, "gear": 1.0}
        if antenna.link.word == "cia402":
            drive |= {"counts_per_turn": axis.encoder_counts, "rated_torque_nm": _rounded(axis.torque_nm or 0.0)}
        drives.append(drive)
    return antenna.link.section | {"name": antenna.name, "drives": drives}


def moved_inertia(antenna: AntennaDescription, place: int) -> float:
    """What an axis moves: the carrying one both bodies, kg m2."""
    return sum(axis.inertia_kg_m2 or 0.0 for axis in antenna.axes[place:])


def _loops(antenna: AntennaDescription, place: int) -> Document:
    axis = antenna.axes[place]
    assert axis.torque_nm and axis.rate_rad_s and axis.breakaway_nm is not None and axis.mass_kg is not None
    inertia = moved_inertia(antenna, place)
    crossing = min(_CROSSING_RAD_S, _CROSSING_SHARE * antenna.rate_hz)
    position = crossing / 6.0
    unbalance = sum((one.mass_kg or 0.0) * _GRAVITY * (one.offset_m or 0.0) for one in antenna.axes[place:])
    disturbance = max(_LEAST_DISTURBANCE * axis.torque_nm, 2.0 * axis.breakaway_nm + 1.5 * unbalance)
    corner = min(_FASTEST_PREFILTER, position / 2.5, _PREFILTER_SHARE * math.sqrt(axis.torque_nm / inertia))
    rate_limit = 0.5 * axis.rate_rad_s
    limits: Document = {"torque_nm": _rounded(axis.torque_nm), "rate_rad_s": _rounded(axis.rate_rad_s)}
    if axis.travel_rad is not None:
        low, high = axis.travel_rad
        limits |= {"position_low_rad": low, "position_high_rad": high}
    elif place == 0:
        limits["cable_wrap_turns"] = 2.0
    limits |= {
        "following_position_rad": 0.5,
        "following_rate_rad_s": _rounded(0.5 * axis.rate_rad_s),
        "braking_rad_s2": _rounded(_BRAKING_SHARE * axis.torque_nm / inertia),
    }
    if antenna.has_gyro:
        limits |= {"gyro_encoder_rad_s": 0.5, "gyro_encoder_rad": 0.03, "stuck_gyro_ticks": 64}
    elif antenna.link.tells_rate:
        # a drive's own rate lags and is coarse; it need not have noise
        limits |= {"gyro_encoder_rad_s": 2.0, "gyro_encoder_rad": 0.1, "stuck_gyro_ticks": 64}
    section: Document = {"parent": antenna.axes[0].name} if place else {}
    section |= {
        "position_loop": {
            "kp_per_s": _rounded(position),
            "ki_per_s2": _rounded(position),
            "rate_limit_rad_s": _rounded(rate_limit),
            "anti_windup": "clamping",
        },
        "rate_loop": {
            "kp_s_per_rad": _rounded(crossing * inertia),
            "ki_per_rad": _rounded(crossing * inertia * crossing / 6.0),
            "anti_windup": "clamping",
        },
        "prefilter": {
            "num": _rounded(corner),
            "den": [1.0, _rounded(corner)],
            # a step of any size becomes a motion that the loops can follow
            "rate_rad_s": _rounded(_MOTION_SHARE * rate_limit),
            "acceleration_rad_s2": limits["braking_rad_s2"],
        },
        "limits": limits,
        "expectation": {"inertia_kg_m2": _rounded(inertia), "disturbance_nm": _rounded(disturbance)},
    }
    section["adjustable"] = {
        f"{part}.{name}": [_rounded(share * section[part][name]) for share in shares]
        for (part, name), shares in _ADJUSTABLE.items()
    }
    return section


def plan_document(antenna: AntennaDescription) -> Document:
    """A first plan: both axes to their start, then a slow pass of each there and back."""
    names = [axis.name for axis in antenna.axes]
    to_start = {"mode": "position", "shape": "smooth", "target_rad": 0.0, "over_s": 2.0}
    segments: list[Document] = [{"name": "to the start", **dict.fromkeys(names, to_start), "duration_s": 2.5}]
    for name in names:
        (other,) = (one for one in names if one != name)
        for way, slope in (("there", 0.05), ("back", -0.05)):
            ramp = {"mode": "position", "shape": "ramp", "from_start": True, "slope_rad_s": slope, "span_rad": 0.2}
            segments.append(
                {
                    "name": f"{name} slowly {way}",
                    name: ramp,
                    other: {"mode": "position"},
                    "duration_s": 4.5,
                    "measure": True,
                    "meaning": {"axis": name, "speed_rad_s": slope},
                }
            )
    return {
        "schema": 1,
        "name": "first_look",
        "text": "A slow pass of each axis, there and back.",
        "segments": segments,
    }
