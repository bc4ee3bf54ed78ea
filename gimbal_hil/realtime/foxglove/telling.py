"""From a daemon's `status` answer to what Foxglove is sent: pure functions, without the SDK."""

from __future__ import annotations

import math

from firmware_protocol.json_object import Json
from sim_backend.boresight import Boresight

#: (x, y, z, w)
Quaternion = tuple[float, float, float, float]
#: of an event's kind, by the names of the SDK's `LogLevel`
_LEVELS = {"fault": "Error", "link": "Warning", "state": "Info"}


def state_message(status: Json) -> Json:
    """Topic `/state`: where the daemon stands, its misses and what holds it."""
    statistics, trouble = status["statistics"], status.get("trouble")
    return {
        **{key: status[key] for key in ("tick", "host_state", "cause", "guard", "link", "drive_state", "drive_fault")},
        "segment": status["segment"],
        "stopped": "" if trouble is None else ": ".join(trouble[key] for key in ("what", "why") if trouble[key]),
        "pointing": status["pointing"]["state"],
        "muted": status["pointing"]["muted"],
        "missed_ticks": statistics["missed"],
        "latency_p99_us": statistics["latency_us"]["p99"],
        "rejected_frames": status["rejected_frames"],
    }


def axis_message(status: Json, axis: str) -> Json:
    """Topic `/axes/NAME`: rad, rad/s and N m, angles in degrees too; null where nothing was heard."""
    position, reference = status["position_rad"][axis], status["position_ref_rad"][axis]
    observed = status["observer"].get("axes", {}).get(axis) or {}
    return {
        "mode": status["mode"][axis],
        "position_rad": position,
        "position_deg": None if position is None else math.degrees(position),
        "position_ref_rad": reference,
        "position_ref_deg": None if reference is None else math.degrees(reference),
        "rate_rad_s": status["rate_rad_s"][axis],
        "torque_nm": status["torque_nm"][axis],
        "missing_torque_rms_nm": observed.get("rms_nm"),
    }


def rotations(status: Json) -> dict[str, tuple[str, Quaternion]]:
    """Frame -> (its parent, its rotation in that): `base` in `world`, the first axis about z, the second about y, and
    the same two axes at their references (`NAME_reference`) where there are any.
    """
    first, second = status["position_rad"]
    at, wanted = status["position_rad"], status["position_ref_rad"]
    base = status.get("base_attitude_rad") or {"roll": 0.0, "pitch": 0.0, "yaw": 0.0}
    yaw, pitch, roll = _about(2, base["yaw"]), _about(1, base["pitch"]), _about(0, base["roll"])
    found = {
        "base": ("world", _product(_product(yaw, pitch), roll)),
        first: ("base", _about(2, at[first] or 0.0)),
        second: (first, _about(1, at[second] or 0.0)),
    }
    if wanted[first] is not None or wanted[second] is not None:
        angles = [wanted[axis] if wanted[axis] is not None else at[axis] or 0.0 for axis in (first, second)]
        found[f"{first}_reference"] = ("base", _about(2, angles[0]))
        found[f"{second}_reference"] = (f"{first}_reference", _about(1, angles[1]))
    return found


def along_boresight(looks: Boresight) -> tuple[Quaternion, Quaternion]:
    """How a cylinder, which stands along z, and an arrow, which points along x, are turned in the inner body to lie
    where the antenna looks.
    """
    half = 0.5 * math.pi
    return (_about(1, half), _about(2, 0.0)) if looks is Boresight.AHEAD else (_about(1, -half), _about(2, math.pi))


def log_level(event: Json) -> str:
    """Name of the SDK's `LogLevel` for an event."""
    return _LEVELS.get(str(event.get("kind")), "Info")


def _about(place: int, angle: float) -> Quaternion:
    found = [0.0, 0.0, 0.0, math.cos(0.5 * angle)]
    found[place] = math.sin(0.5 * angle)
    return found[0], found[1], found[2], found[3]


def _product(a: Quaternion, b: Quaternion) -> Quaternion:
    """Hamilton's product: first b, then a."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )
