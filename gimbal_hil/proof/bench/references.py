"""The same two-axis body in other people's engines, as references of speed. None where the engine is not installed."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from sim_backend.model import AntennaModel


def about_centre_of_mass(model: AntennaModel, axis: str) -> tuple[np.ndarray, np.ndarray, float]:
    """Inertia about the centre of mass (3, 3), centre of mass (3,) and mass of a body whose tensor the model gives
    about the pivot.
    """
    xx, yy, zz, xy, xz, yz = (model.number(axis, f"body.inertia.{k}") for k in ("xx", "yy", "zz", "xy", "xz", "yz"))
    pivot = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    cog = np.array([model.number(axis, f"body.cog.{k}") for k in "xyz"])
    mass = model.number(axis, "body.mass")
    return pivot - mass * (cog @ cog * np.eye(3) - np.outer(cog, cog)), cog, mass


def mujoco_steps(model: AntennaModel, steps: int) -> Callable[[], object] | None:
    """A call of `steps` MuJoCo steps of 0.1 ms (semi-implicit Euler, friction loss and damping in place of LuGre),
    looped in C.
    """
    try:
        import mujoco
    except ImportError:
        return None

    def body(axis: str, direction: str, inner: str = "") -> str:
        tensor, cog, mass = about_centre_of_mass(model, axis)
        six = " ".join(f"{tensor[i, j]:.17g}" for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)))
        place = " ".join(f"{x:.17g}" for x in cog)
        friction = (
            f'damping="{model.number(axis, "friction.viscous")}" '
            f'frictionloss="{model.number(axis, "friction.coulomb")}"'
        )
        return (
            f'<body><joint name="{axis}" type="hinge" axis="{direction}" {friction}/>'
            f'<inertial pos="{place}" mass="{mass}" fullinertia="{six}"/>{inner}</body>'
        )

    antenna = mujoco.MjModel.from_xml_string(
        '<mujoco><compiler angle="radian" balanceinertia="false"/><option timestep="0.0001" gravity="0 0 '
        f'-{model.file.gravity_m_s2}"/>'
        f"<worldbody>{body('outer', '0 0 1', body('inner', '0 1 0'))}</worldbody></mujoco>"
    )
    data = mujoco.MjData(antenna)
    data.qvel[:] = 0.05
    return lambda: mujoco.mj_step(antenna, data, nstep=steps)


def pinocchio_accelerations(model: AntennaModel, calls: int) -> Callable[[], object] | None:
    """A call of `calls` forward dynamics of Pinocchio through its Python binding (no integration, no friction)."""
    try:
        import pinocchio
    except ImportError:
        return None
    antenna = pinocchio.Model()
    antenna.gravity.linear = np.array([0.0, 0.0, -model.file.gravity_m_s2])
    parent = 0
    for axis, joint in (("outer", pinocchio.JointModelRZ()), ("inner", pinocchio.JointModelRY())):
        tensor, cog, mass = about_centre_of_mass(model, axis)
        parent = antenna.addJoint(parent, joint, pinocchio.SE3.Identity(), axis)
        antenna.appendBodyToJoint(parent, pinocchio.Inertia(mass, cog, tensor), pinocchio.SE3.Identity())
    data = antenna.createData()
    q, v, torque = np.zeros(2), np.full(2, 0.05), np.array([0.24, 1.15])

    def run() -> None:
        for _ in range(calls):
            pinocchio.aba(antenna, data, q, v, torque)

    return run
