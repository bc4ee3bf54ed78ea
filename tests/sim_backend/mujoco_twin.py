"""The same two-axis antenna in MuJoCo, as a body that shares no code with ours."""

from __future__ import annotations

import mujoco
import numpy as np

from sim_backend.model import AntennaModel


def _principal(model: AntennaModel, axis: str) -> tuple[np.ndarray, np.ndarray, float]:
    """Tensor about the centre of mass (3, 3), centre of mass (3,) and mass of a body whose tensor is given about the
    pivot.
    """
    n = {path: model.number(axis, path) for path in (f"body.inertia.{k}" for k in ("xx", "yy", "zz", "xy", "xz", "yz"))}
    xx, yy, zz, xy, xz, yz = n.values()
    pivot = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    cog = np.array([model.number(axis, f"body.cog.{k}") for k in "xyz"])
    mass = model.number(axis, "body.mass")
    return pivot - mass * (cog @ cog * np.eye(3) - np.outer(cog, cog)), cog, mass


def mujoco_antenna(model: AntennaModel) -> mujoco.MjModel:
    """An MjModel with a free base of three slides (x, y, z of the world) and three hinges (yaw, pitch, roll), then
    azimuth and elevation.
    """

    def inertial(axis: str) -> str:
        tensor, cog, mass = _principal(model, axis)
        t = " ".join(f"{tensor[i, j]:.17g}" for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)))
        return f'<inertial pos="{cog[0]:.17g} {cog[1]:.17g} {cog[2]:.17g}" mass="{mass:.17g}" fullinertia="{t}"/>'

    def frame(name: str, axis: str, inner: str, kind: str = "hinge") -> str:
        # massless frames are given a vanishing inertia that MuJoCo insists on; the base is driven, so it does not
        # matter
        return (
            f'<body name="{name}"><joint name="{name}" type="{kind}" axis="{axis}"/>'
            f'<inertial pos="0 0 0" mass="1e-9" diaginertia="1e-9 1e-9 1e-9"/>{inner}</body>'
        )

    elevation = f'<body name="inner"><joint name="inner" type="hinge" axis="0 1 0"/>{inertial("inner")}</body>'
    azimuth = f'<body name="outer"><joint name="outer" type="hinge" axis="0 0 1"/>{inertial("outer")}{elevation}</body>'
    chain = frame("yaw", "0 0 1", frame("pitch", "0 1 0", frame("roll", "1 0 0", azimuth)))
    for name, along in (("z", "0 0 1"), ("y", "0 1 0"), ("x", "1 0 0")):
        chain = frame(name, along, chain, "slide")
    return mujoco.MjModel.from_xml_string(
        f'<mujoco><compiler angle="radian" balanceinertia="false" boundmass="0" boundinertia="0"/>'
        f'<option gravity="0 0 -{model.file.gravity_m_s2}"/><worldbody>{chain}</worldbody></mujoco>'
    )


def mujoco_accelerations(
    antenna: mujoco.MjModel,
    euler: np.ndarray,
    euler_rate: np.ndarray,
    euler_acceleration: np.ndarray,
    pivot_acceleration: np.ndarray,
    q: np.ndarray,
    v: np.ndarray,
    torque: np.ndarray,
) -> np.ndarray:
    """Joint accelerations (2,) for a base driven with given Euler angles (yaw, pitch, roll), rates and accelerations,
    and with an acceleration of the pivot in axes of the world (m/s^2).
    """
    data = mujoco.MjData(antenna)
    data.qpos[:] = np.concatenate([np.zeros(3), euler, q])
    data.qvel[:] = np.concatenate([np.zeros(3), euler_rate, v])
    mujoco.mj_forward(antenna, data)
    full = np.zeros((antenna.nv, antenna.nv))
    try:
        mujoco.mj_fullM(antenna, data, full)
    except TypeError:  # MuJoCo 3 takes the sparse matrix itself
        mujoco.mj_fullM(antenna, full, data.qM)
    # M qacc + bias = applied: the base rows are driven, the joint rows are solved
    driven = np.concatenate([pivot_acceleration, euler_acceleration])
    right = torque - data.qfrc_bias[6:] - full[6:, :6] @ driven
    return np.linalg.solve(full[6:, 6:], right)
