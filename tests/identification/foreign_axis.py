"""A single axis of another simulator: the LuGre equations as they stand in the paper, by Runge and Kutta's classical
method with steps so small that they count as exact; nothing of the product's own bristle step. Friction may wander.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from firmware_protocol.compiling import entry_point
from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.identification import Log, LugreFriction, Stretch, TorqueSource, stretches_of_table
from tests.identification.one_axis_rig import ENCODER_STEP, pulses, reversing_multisine, slow_ramp, there_and_back

AXIS = "only"
PERIOD_S = 1e-3
#: steps of a row: 100 us each, at which the bristles relax by a hundredth of themselves
_STEPS = 10
#: seconds in which a wandering level forgets where it was
_WANDER_S = 5.0
#: gains of the rate loop a unit of inertia: 1/s of the rate error, and 1/s2 of its integral
_KP, _KI = 120.0, 1800.0


@dataclass(frozen=True)
class ForeignAxis:
    """Truth of one axis; the level of its sliding friction wanders by a share `wander`, rms."""

    friction: LugreFriction
    inertia: float
    wander: float = 0.0
    gyro_noise: float = 2e-4
    seed: int = 0


@entry_point
def _rk4(
    feed: np.ndarray, reference: np.ndarray, noise: np.ndarray, level: np.ndarray, numbers: np.ndarray, out: np.ndarray
) -> None:
    """PI on the noisy rate where `feed` is NaN, else the torque in `feed`, held over a row; out (n, 2): torque,
    position, before the row.
    """
    ts, tc, vs, sigma2, delta, s0, s1 = (
        numbers[0],
        numbers[1],
        numbers[2],
        numbers[3],
        numbers[4],
        numbers[5],
        numbers[6],
    )
    inertia, h, kp, ki, period = numbers[7], numbers[8], numbers[9], numbers[10], numbers[11]
    steps = int(round(period / h))
    q, v, z, integral = 0.0, 0.0, 0.0, 0.0
    kq, kv, kz = np.zeros(4), np.zeros(4), np.zeros(4)
    part = np.array([0.0, 0.5, 0.5, 1.0])
    for k in range(feed.shape[0]):
        torque = feed[k]
        if np.isnan(torque):
            error = reference[k] - v - noise[k]
            integral += ki * period * error
            torque = kp * error + integral
        out[k, 0], out[k, 1] = torque, q
        for _ in range(steps):
            for i in range(4):
                before = max(i - 1, 0)
                vi = v + part[i] * h * kv[before] if i > 0 else v
                zi = z + part[i] * h * kz[before] if i > 0 else z
                speed = abs(vi)
                steady = level[k] * (tc + (ts - tc) * np.exp(-((speed / vs) ** delta)))
                kz[i] = vi - s0 * speed * zi / steady
                kq[i] = vi
                kv[i] = (torque - s0 * zi - s1 * kz[i] - sigma2 * vi) / inertia
            q += h * (kq[0] + 2.0 * kq[1] + 2.0 * kq[2] + kq[3]) / 6.0
            v += h * (kv[0] + 2.0 * kv[1] + 2.0 * kv[2] + kv[3]) / 6.0
            z += h * (kz[0] + 2.0 * kz[1] + 2.0 * kz[2] + kz[3]) / 6.0


def motion(axis: ForeignAxis, feed: np.ndarray, reference: np.ndarray, seed: int) -> np.ndarray:
    """Torque and exact position, (n, 2), under a torque (n,), or under the rate loop where that is NaN."""
    rng = np.random.default_rng((axis.seed, seed))
    n = len(feed)
    noise, drive = axis.gyro_noise * rng.standard_normal(n), rng.standard_normal(n)
    keep = float(np.exp(-PERIOD_S / _WANDER_S))
    wandering, state = np.empty(n), float(rng.standard_normal())
    for k, push in enumerate((np.sqrt(1.0 - keep**2) * drive).tolist()):
        state = keep * state + push
        wandering[k] = state
    loop = (_KP * axis.inertia, _KI * axis.inertia)
    numbers = np.array([*axis.friction.values(), axis.inertia, PERIOD_S / _STEPS, *loop, PERIOD_S])
    out = np.zeros((n, 2))
    _rk4(feed, reference, noise, 1.0 + axis.wander * wandering, numbers, out)
    return out


def driven(axis: ForeignAxis, torque: np.ndarray, name: str, seed: int) -> Log:
    """Torque commanded directly, as a log."""
    table = _table(motion(axis, torque, np.zeros(len(torque)), seed), {}, name)
    return Log(name, table, {AXIS: (Stretch(name, 0, len(table), TorqueSource.TORQUE),)})


def following(axis: ForeignAxis, reference: np.ndarray, name: str, seed: int) -> Log:
    """A rate loop follows a reference, as a log."""
    moved = motion(axis, np.full(len(reference), np.nan), reference, seed)
    table = _table(moved, {f"{AXIS}.rate_ref": reference}, name)
    return Log(name, table, {AXIS: stretches_of_table(table, AXIS)})


def bending_logs(axis: ForeignAxis) -> list[Log]:
    """Plateaus there and back, loops and pulses below break-away: what `sliding` and `presliding` record."""
    level = axis.friction.static.breakaway
    speeds = np.geomspace(0.001, 0.1, 12)
    return [
        following(axis, there_and_back(speeds, least_s=5.0, least_rad=0.03), "sliding", 0),
        driven(axis, slow_ramp(0.7 * level, 25.0), "loop 1", 1),
        driven(axis, slow_ramp(0.7 * level, 25.0), "loop 2", 2),
        driven(axis, pulses(0.45 * level, 6.0), "pulses", 3),
    ]


def torque_logs(axis: ForeignAxis) -> list[Log]:
    """Torque alone, no loop: a multisine that reverses and slides, a loop and pulses below break-away."""
    level = axis.friction.static.breakaway
    return [
        driven(axis, reversing_multisine(1.8 * level, 14.0, axis.seed), "multisine", 0),
        driven(axis, slow_ramp(0.7 * level, 6.0), "loop", 1),
        driven(axis, pulses(0.45 * level, 6.0), "pulses", 2),
    ]


def _table(moved: np.ndarray, more: dict[str, np.ndarray], name: str) -> SignalsTable:
    encoder = np.round(moved[:, 1] / ENCODER_STEP) * ENCODER_STEP
    columns = {f"{AXIS}.torque": moved[:, 0], f"{AXIS}.position": encoder, **more}
    return SignalsTable.of((AXIS,), np.arange(len(moved)) * PERIOD_S, columns, source=name)
