"""What each slip of the thesis does: to the acceleration at random states on a moving base, and to the runs of chapter
3.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from firmware_protocol.compiling import entry_point
from gimbal_hil.proof.thesis.inferred import LEVEL
from gimbal_hil.proof.thesis.unbalance import Unbalance, UnbalanceRun, run_unbalance
from sim_backend.layout import SLIPS
from sim_backend.model import plant_arrays
from sim_backend.rigid_body import equations_of_motion
from sim_backend.thesis_slips import Slip, slip_torque


@dataclass(frozen=True)
class SlipEffect:
    """One slip: relative error of the joint acceleration over random states, and the chapter 3 runs with it."""

    slip: Slip
    where: str
    #: error of the acceleration over its magnitude: median and largest over the states
    median_error: float
    largest_error: float
    #: outer and inner axis at 0.1 rad/s: table 3.1 case 5 with dynamic, table 3.2 case 4 with static unbalance
    dynamic: tuple[UnbalanceRun, UnbalanceRun]
    static: tuple[UnbalanceRun, UnbalanceRun]


WHERE: dict[Slip, str] = {
    Slip.MISSING_ELEVATION_RATE: "eq. 2.58, 3.3, 3.4: derivative of R_oi without the elevation rate",
    Slip.DERIVATIVE_SIGN: "eq. 2.13, 2.22, 2.23: derivative of R_io and R_ob with the wrong sign",
    Slip.GRAVITY_ROW: "eq. 3.10: y row of r x g for the torque about z, total mass",
    Slip.INNER_FRICTION_ON_OUTER: "eq. 2.54, 2.58: friction of the inner joint on the outer axis",
    Slip.FRICTION_ADDED: "eq. 2.42, 2.55: friction added to the motor's torque",
}


@entry_point
def _accelerations(P: np.ndarray, K: np.ndarray, states: np.ndarray, found: np.ndarray) -> None:
    """For each state (q, v, torque, gravity, base rate, base acceleration) the joint accelerations without and with the
    slips in K.
    """
    for i in range(states.shape[0]):
        s = states[i]
        q, v = (s[0], s[1]), (s[2], s[3])
        base = ((s[6], s[7], s[8]), (s[9], s[10], s[11]), (s[12], s[13], s[14]))
        mass, bias, _, _, _ = equations_of_motion(P, K, q, v, base)
        extra = slip_torque(P, K, q, v, base)
        determinant = mass[0] * mass[2] - mass[1] * mass[1]
        for k in range(2):
            b0, b1 = s[4] + bias[0] + k * extra[0], s[5] + bias[1] + k * extra[1]
            found[i, 2 * k] = (mass[2] * b0 - mass[1] * b1) / determinant
            found[i, 2 * k + 1] = (mass[0] * b1 - mass[1] * b0) / determinant


def acceleration_errors(slip: Slip, states: int = 4000, seed: int = 1) -> np.ndarray:
    """Relative error of the acceleration (states,) that a slip makes at random states on a moving base.

    Joint rates to 1 rad/s, base rates as in table 3.1 case 5, motor torques to 1 N m. Gravity is left out for the two
    slips of the kinematics, which it would only hide.
    """
    arrays = plant_arrays(LEVEL.antenna())
    arrays.K[SLIPS] = int(slip)
    draw = np.random.default_rng(seed)
    spread = np.concatenate(
        [[np.pi, np.pi / 2], [1.0, 1.0], [1.0, 1.0], [0.0] * 3, np.deg2rad([60.0, 75.0, 85.0]), [0.5] * 3]
    )
    rows = draw.uniform(-1.0, 1.0, (states, len(spread))) * spread
    down = draw.normal(size=(states, 3))
    gravity = 0.0 if slip in (Slip.MISSING_ELEVATION_RATE, Slip.DERIVATIVE_SIGN) else 9.81
    rows[:, 6:9] = gravity * down / np.linalg.norm(down, axis=1, keepdims=True)
    found = np.zeros((states, 4))
    _accelerations(arrays.P, arrays.K, rows, found)
    return np.asarray(np.linalg.norm(found[:, 2:] - found[:, :2], axis=1) / np.linalg.norm(found[:, :2], axis=1))


def slip_effects() -> tuple[SlipEffect, ...]:
    """Every slip, measured both ways."""
    return tuple(_effect(slip) for slip in WHERE)


def _effect(slip: Slip) -> SlipEffect:
    errors = acceleration_errors(slip)
    return SlipEffect(
        slip,
        WHERE[slip],
        float(np.median(errors)),
        float(errors.max()),
        (
            run_unbalance(Unbalance.DYNAMIC, "outer", 0.1, 5, slip),
            run_unbalance(Unbalance.DYNAMIC, "inner", 0.1, 5, slip),
        ),
        (
            run_unbalance(Unbalance.STATIC, "outer", 0.1, 4, slip),
            run_unbalance(Unbalance.STATIC, "inner", 0.1, 4, slip),
        ),
    )
