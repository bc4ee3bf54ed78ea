"""An arm of six joints as a URDF, moved by MuJoCo: its log is made by somebody else's equations and friction."""

from __future__ import annotations

from pathlib import Path

import numpy as np

JOINTS = ("base", "shoulder", "elbow", "roll", "wrist", "flange")
#: axis of each joint, length (m) and mass (kg) of the link behind it
_LINKS = (
    ("0 0 1", 0.30, 6.0),
    ("0 1 0", 0.45, 5.0),
    ("0 1 0", 0.40, 3.0),
    ("1 0 0", 0.15, 1.2),
    ("0 1 0", 0.12, 0.8),
    ("1 0 0", 0.08, 0.3),
)
#: what the elbow has beside its links: Coulomb and viscous friction, and a ripple, N m, N m s/rad
COULOMB, VISCOUS, RIPPLE, ORDER, PHASE = 0.8, 0.5, 0.4, 9.0, 0.4
STEP_S, EVERY = 2.5e-4, 8


def urdf() -> str:
    """The arm."""
    parts = ['<robot name="six"><link name="root"/>']
    parent = "root"
    for k, (name, (axis, length, mass)) in enumerate(zip(JOINTS, _LINKS, strict=True)):
        along, across = mass * length**2 / 12.0 + 2e-3, 0.02 * mass / 10.0 + 1e-3
        behind = 0.0 if k == 0 else _LINKS[k - 1][1]
        friction = f'<dynamics damping="{VISCOUS}" friction="{COULOMB}"/>' if name == "elbow" else ""
        parts.append(
            f'<link name="{name}_link"><inertial><origin xyz="{length / 2} 0.01 0.02"/><mass value="{mass}"/>'
            f'<inertia ixx="{across}" iyy="{along}" izz="{along}" ixy="0" ixz="0" iyz="0"/></inertial></link>'
            f'<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{name}_link"/>'
            f'<origin xyz="{behind} 0 0"/><axis xyz="{axis}"/>'
            f'<limit lower="-6" upper="6" effort="300" velocity="20"/>{friction}</joint>'
        )
        parent = f"{name}_link"
    return "".join([*parts, "</robot>"])


def moved(path: Path, seed: int, seconds: float = 24.0, ripple: float = RIPPLE) -> None:
    """A log as a bag of joint states has it: seconds, and of each joint `position[name]` and `effort[name]`; 500 Hz."""
    import mujoco

    random = np.random.default_rng(seed)
    model = mujoco.MjModel.from_xml_string(urdf())
    model.opt.timestep, model.opt.integrator = STEP_S, mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
    data = mujoco.MjData(model)
    sizes, hertz = random.uniform(0.2, 0.5, (6, 2)), random.uniform(0.08, 0.5, (6, 2))
    phases = random.uniform(0.0, 2.0 * np.pi, (6, 2))
    sizes[2] = random.uniform(0.5, 0.8, 2)
    stiff, damp = np.array([900.0, 1200.0, 600.0, 60.0, 60.0, 20.0]), np.array([60.0, 90.0, 40.0, 3.0, 3.0, 1.0])
    rows = []
    elbow, effort = JOINTS.index("elbow"), np.zeros(6)
    for step in range(int(seconds / STEP_S)):
        if step % EVERY == 0:
            t = step * STEP_S
            angle = 2.0 * np.pi * hertz * t + phases
            begun = min(t, 1.0) ** 2
            wanted = begun * np.sum(sizes * (np.sin(angle) - np.sin(phases)), axis=1)
            speed = begun * np.sum(sizes * 2.0 * np.pi * hertz * np.cos(angle), axis=1)
            effort = data.qfrc_bias + stiff * (wanted - data.qpos) + damp * (speed - data.qvel)
            rows.append([t, *(np.round(data.qpos / 1e-5) * 1e-5), *np.round(effort, 4)])
        data.qfrc_applied[:] = effort
        data.qfrc_applied[elbow] += ripple * np.sin(ORDER * data.qpos[elbow] + PHASE)
        mujoco.mj_step(model, data)
    names = ["t", *(f"position[{name}]" for name in JOINTS), *(f"effort[{name}]" for name in JOINTS)]
    text = "\n".join(",".join(f"{number:.9g}" for number in row) for row in rows)
    path.write_text(",".join(names) + "\n" + text + "\n")
