"""The compiled functions of the thesis, each called once with next to nothing, so that they are on disk afterwards."""

from __future__ import annotations

import numpy as np

from gimbal_hil.loop.control import Mode
from gimbal_hil.proof.thesis.closed_loop import AxisLoop, Gains, run_closed_loop
from gimbal_hil.proof.thesis.friction_curves import CurveFriction, friction_along
from gimbal_hil.proof.thesis.slip_effects import acceleration_errors
from sim_backend.model import shipped_model
from sim_backend.thesis_slips import Slip


def ask_for_kernels() -> None:
    """Compile what `experiment thesis` compiles, for this machine."""
    friction_along(CurveFriction(0.3, 0.2, 0.01, 400.0, 1.0, 0.1, 2.0), np.zeros(2), 1e-4)
    acceleration_errors(Slip.DERIVATIVE_SIGN, states=1)
    loop = AxisLoop(Mode.RATE, Gains(1.0, 0.0))
    run_closed_loop(shipped_model(), loop, loop, np.zeros((1, 2)))
