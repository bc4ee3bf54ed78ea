"""How large a hidden cause is in units of the noise that its trace stands in, and the size that gives it a
magnitude.
"""

from __future__ import annotations

import numpy as np
from scipy.signal import butter, sosfiltfilt

from tests.blind.causes import CAPS, LEAST, Array, Cause
from tests.blind.scene import Scene

BAND_HZ = 30.0  # in which magnitude is counted
_TRIALS = 5


def torque_floors(scene: Scene) -> Array:
    """Torque floors (outer, inner) and rate-error floor in the band, from first principles."""
    dt, quantum = scene.rig.step_s, scene.rig.encoder_step / np.sqrt(12)
    share = 2 * BAND_HZ * dt
    w = 2 * np.pi * BAND_HZ
    acceleration = quantum * w**2 * np.sqrt(share / 5)
    rate = quantum * w * np.sqrt(share / 3)
    torque = np.hypot(scene.rig.inertia * acceleration, scene.torque_noise * np.sqrt(share))
    return np.array([torque[0], torque[1], np.hypot(scene.gyro_noise * np.sqrt(share), rate)])


def _low_pass(x: Array, dt: float) -> Array:
    return np.asarray(sosfiltfilt(butter(4, BAND_HZ, fs=1 / dt, output="sos"), x, axis=0))


def strength(x: Array, cause: Cause, floors: Array, scene: Scene) -> float:
    """Size of the cause in floors: the largest over its torque and its rate error."""
    a = 0 if cause.axis == "outer" else 1
    dt = scene.rig.step_s
    settled = round(2.0 / dt)
    if cause.name in ("encoder_eccentricity", "encoder_subdivision"):
        slip = _low_pass(x[settled:, 2 + a] - x[settled:, 16 + a], dt)
        rate = np.gradient(slip, dt)
        return float(max(np.std(rate) / floors[2], scene.rig.inertia[a] * np.std(np.gradient(rate, dt)) / floors[a]))
    lack = _low_pass(x[settled:, 14 + a], dt)
    return float(np.sqrt(np.mean(lack**2))) / floors[a]


def scaled_to(scene: Scene, goals: list[float], floors: Array) -> list[tuple[float, float]]:
    """Scale of every cause, so that it stands its goal high, and the floors it reached; wrong numbers stay as drawn."""
    found: list[tuple[float, float]] = []
    for k, cause in enumerate(scene.causes):
        if cause.number:
            found.append((1.0, _reached(scene, k, 1.0, floors)))
        elif cause.name.startswith("gyro"):
            found.append(_gyro_scale(cause, goals[k], floors))
        elif cause.name == "saturation":
            found.append(_saturation_scale(scene, k, goals[k], floors))
        else:
            found.append(_scale(scene, k, goals[k], floors))
    return found


def _alone(scene: Scene, k: int, scale: float, floors: Array) -> float:
    scales = [scale if j == k else 0.0 for j in range(len(scene.causes))]
    return strength(scene.run(0, scales, 1, trial=True), scene.causes[k], floors, scene)


def _reached(scene: Scene, k: int, scale: float, floors: Array) -> float:
    """What the cause does beyond what the antenna's own noise leaves without it."""
    return float(np.sqrt(max(_alone(scene, k, scale, floors) ** 2 - _alone(scene, k, 0.0, floors) ** 2, 0.0)))


def _scale(scene: Scene, k: int, goal: float, floors: Array) -> tuple[float, float]:
    name, scale = scene.causes[k].name, 1.0
    least, cap = LEAST.get(name, 0.0), CAPS.get(name, 30.0)
    for _ in range(_TRIALS):
        reached = _reached(scene, k, scale, floors)
        if not np.isfinite(reached) or reached > 30.0 * goal:
            # the loop of the bench did not stand it: try far less
            new, cap = 0.2 * scale, 0.5 * scale
        elif abs(np.log(max(reached, 1e-9) / goal)) < 0.1:
            return scale, reached
        else:
            new = float(min(cap, scale * np.clip(goal / max(reached, 1e-9), 0.02, 50.0)))
        new = max(new, least)
        if new == scale:
            return scale, reached
        scale = new
    return scale, _reached(scene, k, scale, floors)


def _gyro_scale(cause: Cause, goal: float, floors: Array) -> tuple[float, float]:
    unit = {"gyro_bias": 0.005, "gyro_scale": 0.01 * 0.6, "gyro_misalignment": 0.03 * 0.12}[cause.name]
    return float(goal * floors[2] / unit), goal


def _saturation_scale(scene: Scene, k: int, goal: float, floors: Array) -> tuple[float, float]:
    x = scene.run(0, [0.0] * len(scene.causes), 1, trial=True)
    a = 0 if scene.causes[k].axis == "outer" else 1
    level, reached = float(np.abs(x[:, a]).max()), 0.0
    for quantile in (0.995, 0.99, 0.98, 0.96, 0.93):
        level = float(np.quantile(np.abs(x[:, a]), quantile))
        reached = _reached(scene, k, level, floors)
        if reached > goal:
            break
    return level, reached
