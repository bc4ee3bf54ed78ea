"""One axis with LuGre friction under a known torque: the forward simulation of the output-error fit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from firmware_protocol.compiling import entry_point
from gimbal_hil.knowledge.identification.averaging import Vector
from gimbal_hil.knowledge.identification.stribeck import LugreFriction
from sim_backend.friction import BUMP_GONE, lugre_step, stribeck_level


@dataclass(frozen=True)
class AxisRecord:
    """A stretch of measured motion of one axis, from rest.

    `torque` (n,): what drives inertia and friction, held over [t_k, t_k+1): the applied torque minus what gravity, base
    and the other axis take along the *measured* motion. `position` (n,): encoder at t_k. `step_s`: sample period.
    """

    label: str
    step_s: float
    torque: Vector
    position: Vector


def simulate_axis(
    record: AxisRecord,
    inertia: float,
    friction: LugreFriction,
    offset: float = 0.0,
    substep_s: float = 5e-4,
    finer: int = 1,
) -> tuple[Vector, Vector]:
    """Position and rate at t_k, each (n,), of `inertia q'' = torque + offset - F` from the record's first position at
    rest.

    The bristles start in balance with the first torque (within break-away). Same integration as the plant (leapfrog
    with the exact bristle update), with steps of at most `substep_s`, each of them cut
    into `finer`.
    """
    n = len(record.torque)
    position, rate = np.zeros(n), np.zeros(n)
    steps = finer * max(1, int(np.ceil(record.step_s / substep_s - 1e-9)))
    limit = 0.98 * min(friction.static.breakaway, friction.static.coulomb)
    held = float(np.clip(record.torque[0] + offset, -limit, limit))
    _respond(
        np.ascontiguousarray(record.torque),
        offset,
        inertia,
        friction.values(),
        record.step_s / steps,
        steps,
        float(record.position[0]),
        held,
        position,
        rate,
    )
    return position, rate


@entry_point
def _respond(
    torque: np.ndarray,
    offset: float,
    inertia: float,
    friction: np.ndarray,
    h: float,
    steps: int,
    start: float,
    held: float,
    position: np.ndarray,
    rate: np.ndarray,
) -> None:
    ts, tc, vs, sigma2, delta, sigma0, sigma1 = (
        friction[0],
        friction[1],
        friction[2],
        friction[3],
        friction[4],
        friction[5],
        friction[6],
    )
    gone = vs * BUMP_GONE ** (1.0 / delta)
    q, v, a = start, 0.0, 0.0
    z = held / sigma0 if sigma0 > 0.0 else 0.0
    for k in range(torque.shape[0]):
        position[k], rate[k] = q, v
        drive = torque[k] + offset
        for _ in range(steps):
            middle = v + 0.5 * h * a
            level = tc if abs(middle) > gone else stribeck_level(abs(middle), ts, tc, vs, delta)
            z, opposing = lugre_step(z, middle, h, level, sigma0, sigma1, sigma2)
            a = (drive - opposing) / inertia
            q += h * (v + 0.5 * h * a)
            v += h * a
