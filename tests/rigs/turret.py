"""Two-axis gimbals drawn at random and simulated by MuJoCo, on a base that stands or turns, with gyros or without; the
logs and the first model of a stranger, who has measured no bristle.

    python -m tests.rigs.turret FOLDER --seed 1 --rigs 64 --motions sines,moves --workers 2

Each hides one thing from its model file, or none. A name counts with its axis.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from tests.rigs.drawn import COULOMB_PATHS, GRAVITY_M_S2, MOTIONS, TYPICAL_RAD_S2, VISCOUS, Hidden, one
from tests.rigs.many import Chosen, ask_many, judged
from tests.rigs.rig import Rig, measured, write_log, write_model
from tests.rigs.told import Row, ask

AXES = ("azimuth", "elevation")
#: where each axis has its own moment of inertia
OWN = {"azimuth": "body.inertia.zz", "elevation": "body.inertia.yy"}
LOG_S, SUBSTEPS, BANDWIDTH = 40.0, 20, 20.0
#: armature of the base's driven joints over what the gimbal weighs: nothing that the gimbal does moves them
_HELD = 1e6
_INERTIAS = ("xx", "yy", "zz", "xy", "xz", "yz")


#: as for single joints; a number of the file that is called "own" is the axis' own moment
HIDDEN: dict[str, Hidden] = {
    "nothing": one(),
    "viscous halved": one("viscous", file={VISCOUS: 0.5}),
    "viscous doubled": one("viscous", file={VISCOUS: 2.0}),
    "inertia too small": one("inertia", file={"own": 0.7}),
    "inertia too large": one("inertia", file={"own": 1.4}),
    "dry friction halved": one("coulomb", file=dict.fromkeys(COULOMB_PATHS, 0.5)),
    "dry friction doubled": one("coulomb", file=dict.fromkeys(COULOMB_PATHS, 2.0)),
    "unbalance": one("static_unbalance", unbalance=0.4),
    "ripple": one("cogging", ripple=0.1),
    "spring": one("cable_spring", spring=0.4),
    "offset": one("torque_offset", offset=0.1),
    "gain": one("torque_gain", gain=0.8),
    "late command": one("transport_delay", delay=4.0),
    "lagging actuator": one("actuator_lag", lag=5.0),
    "friction by direction": one("coulomb_asymmetry", drag=0.25),
    "drag of air": one("quadratic_drag", air=0.2),
    "gyro scale": one("gyro_scale", gyro_scale=0.02),
    "gyro bias": one("gyro_bias", gyro_bias=0.01),
    # no effect of the catalogue does these
    "hardening stop": one(stop=3.0),
    "friction that switches": one(switching=0.5),
}


@dataclass(frozen=True)
class Turret:
    """One drawn rig: SI units, radians; pairs are azimuth, elevation."""

    rate_hz: float
    #: moments about the pivot of either body: xx, yy, zz, xy, xz, yz
    bodies: tuple[tuple[float, ...], tuple[float, ...]]
    masses: tuple[float, float]
    coulomb: tuple[float, float]
    viscous: tuple[float, float]
    counts: int
    orders: int
    #: noise of a gyro, rad/s; zero: there is none
    gyro: float
    softness_s: float
    #: amplitude of the base's roll, pitch and yaw, rad; zero: it stands
    sway: float
    motion: str = "sines"

    @property
    def inertia(self) -> tuple[float, float]:
        """What each motor turns about its own axis, kg m2."""
        outer, inner = self.bodies
        return outer[2] + inner[2], inner[1]

    def typical(self, axis: int) -> float:
        """The torque that sizes are told in, N m."""
        return self.inertia[axis] * TYPICAL_RAD_S2


def drawn_turret(dice: np.random.Generator) -> Turret:
    """Between a camera's gimbal and a radar's."""
    outer = float(np.exp(dice.uniform(np.log(0.01), np.log(3.0))))
    inner = outer * float(dice.uniform(0.15, 0.5))

    def body(own: float) -> tuple[float, ...]:
        products = own * dice.uniform(-0.06, 0.06, 3)
        return (*(own * dice.uniform(0.8, 1.2, 3)), *products)

    bodies = body(outer), body(inner)
    turns = np.array([bodies[0][2] + bodies[1][2], bodies[1][1]]) * TYPICAL_RAD_S2
    dry, wet = (turns * dice.uniform(0.08, 0.3, 2) for _ in range(2))
    return Turret(
        rate_hz=float(dice.choice([250.0, 500.0])),
        bodies=bodies,
        masses=(30.0 * outer**0.6, 30.0 * inner**0.6),
        coulomb=(float(dry[0]), float(dry[1])),
        viscous=(float(wet[0]), float(wet[1])),
        counts=int(2 ** dice.integers(18, 23)),
        orders=int(dice.integers(5, 37)),
        gyro=float(dice.choice([0.0, 3e-4, 3e-3])),
        softness_s=float(dice.choice([0.002, 0.02])),
        sway=float(dice.choice([0.0, 0.1])),
    )


def _spec(turret: Turret, sizes: Mapping[str, float], axis: int) -> str:
    """The rig as MuJoCo reads it: yaw, pitch and roll of a base that is far too heavy to be moved, then two joints."""

    def inertial(which: int) -> str:
        xx, yy, zz, xy, xz, yz = turret.bodies[which]
        tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        heavy = sizes.get("unbalance", 0.0) * turret.typical(which) if which == axis else 0.0
        cog = np.array([heavy / (turret.masses[which] * GRAVITY_M_S2), 0.0, 0.0])
        own = tensor - turret.masses[which] * (cog @ cog * np.eye(3) - np.outer(cog, cog))
        six = " ".join(f"{own[i, j]:.17g}" for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)))
        return f'<inertial pos="{cog[0]:.17g} 0 0" mass="{turret.masses[which]}" fullinertia="{six}"/>'

    def joint(which: int) -> str:
        spring = sizes.get("spring", 0.0) * turret.typical(which) if which == axis else 0.0
        return (
            f'<joint name="{AXES[which]}" type="hinge" axis="{("0 0 1", "0 1 0")[which]}" '
            f'damping="{turret.viscous[which]}" frictionloss="{turret.coulomb[which]}" '
            f'solreffriction="{turret.softness_s} 1" stiffness="{spring}"/><site name="{AXES[which]}"/>'
        )

    chain = f"<body>{joint(0)}{inertial(0)}<body>{joint(1)}{inertial(1)}</body></body>"
    held = _HELD * max(turret.inertia)
    for along, name in (("1 0 0", "roll"), ("0 1 0", "pitch"), ("0 0 1", "yaw")):
        site = '<site name="base"/>' if name == "roll" else ""
        chain = (
            f'<body><joint name="{name}" type="hinge" axis="{along}" armature="{held}"/>{site}'
            f'<inertial pos="0 0 0" mass="1e-6" diaginertia="1e-6 1e-6 1e-6"/>{chain}</body>'
        )
    gyros = "".join(f'<gyro site="{site}"/>' for site in ("base", *AXES))
    return (
        f'<mujoco><compiler balanceinertia="true"/><option timestep="{1.0 / turret.rate_hz / SUBSTEPS}" '
        f'gravity="0 0 -{GRAVITY_M_S2}" integrator="implicitfast"/><worldbody>{chain}</worldbody>'
        f"<sensor>{gyros}</sensor></mujoco>"
    )


def simulated(turret: Turret, hidden: Hidden, axis: int, seed: int) -> dict[str, np.ndarray]:
    """The columns of one log: a position loop on each axis follows sines or moves."""
    import mujoco

    dice, sizes, period = np.random.default_rng(seed), hidden.rig, 1.0 / turret.rate_hz
    model = mujoco.MjModel.from_xml_string(_spec(turret, sizes, axis))
    data = mujoco.MjData(model)
    rows = int(LOG_S * turret.rate_hz)
    time = period * np.arange(rows)
    reference = np.column_stack([MOTIONS[turret.motion](dice, time) for _ in AXES]) * np.array([1.0, 0.6])
    hz, phase = dice.uniform(0.08, 0.4, 3), dice.uniform(0.0, 2.0 * np.pi, 3)
    step, inertia = 2.0 * np.pi / turret.counts, np.array(turret.inertia)
    typical = inertia * TYPICAL_RAD_S2
    late, lag = int(sizes.get("delay", 0.0)), sizes.get("lag", 0.0) * period
    follow = 1.0 - np.exp(-period / SUBSTEPS / lag) if lag else 1.0
    torque, position, rates, base = np.zeros((rows, 2)), np.zeros((rows, 2)), np.zeros((rows, 2)), np.zeros((rows, 6))
    sent, acting, before, rate, total, grip = [0.0] * (late + 1), 0.0, np.zeros(2), np.zeros(2), np.zeros(2), 1.0
    held = model.dof_armature[:3].copy()
    swing = turret.sway * (2.0 * np.pi * hz)
    for k in range(rows):
        # sensors of this instant
        mujoco.mj_forward(model, data)
        seen = step * np.round(data.qpos[3:] / step)
        yaw, pitch, roll = data.qpos[:3]
        base[k] = (roll, pitch, yaw, *data.sensordata[:3])
        gyro = np.array([data.sensordata[5], data.sensordata[7]]) + turret.gyro * dice.normal(size=2)
        gyro[axis] = gyro[axis] * (1.0 + sizes.get("gyro_scale", 0.0)) + sizes.get("gyro_bias", 0.0)
        rate += 0.3 * ((seen - before) / period - rate) if k else 0.0
        before = seen
        total += 0.5 * BANDWIDTH * (reference[k] - seen) * period
        command = inertia * (BANDWIDTH**2 * (reference[k] - seen + total) - 1.4 * BANDWIDTH * rate)
        torque[k] = np.clip(command, -3.0 * typical, 3.0 * typical)
        position[k], rates[k] = seen, gyro
        sent = [*sent[1:], float(torque[k, axis])]
        if dice.random() < period / 3.0:
            grip = 1.0 + sizes.get("switching", 0.0) * float(dice.choice([-1.0, 0.0, 1.0]))
        for _ in range(SUBSTEPS):
            t = data.time
            grown = 1.0 - np.exp(-((t / 1.5) ** 2))
            if turret.sway:
                # the base goes where it should, whatever hangs on it
                angle = 2.0 * np.pi * hz * t + phase
                goal = turret.sway * grown * np.sin(angle)
                speed = grown * swing * np.cos(angle) + turret.sway * np.sin(angle) * (1.0 - grown) * t / 1.125
                wanted = 400.0 * (goal - data.qpos[:3]) + 40.0 * (speed - data.qvel[:3])
                data.qfrc_applied[:3] = held * (wanted - grown * swing * (2.0 * np.pi * hz) * np.sin(angle))
            acting += (sent[0] - acting) * follow
            q, v = float(data.qpos[3 + axis]), float(data.qvel[3 + axis])
            model.dof_frictionloss[3 + axis] = turret.coulomb[axis] * grip * (1.0 + sizes.get("drag", 0.0) * np.sign(v))
            data.qfrc_applied[3:] = torque[k]
            data.qfrc_applied[3 + axis] = sizes.get("gain", 1.0) * acting + typical[axis] * (
                sizes.get("offset", 0.0)
                + sizes.get("ripple", 0.0) * np.sin(turret.orders * q + 1.0)
                - sizes.get("stop", 0.0) * np.sign(q) * max(abs(q) - 0.4, 0.0) ** 3 * 10.0
                - sizes.get("air", 0.0) * v * abs(v)
            )
            mujoco.mj_step(model, data)
    columns = {"time_s": time}
    for i, name in enumerate(AXES):
        columns |= {f"{name}.torque": torque[:, i], f"{name}.position": position[:, i]}
        columns |= {f"{name}.rate": rates[:, i]} if turret.gyro else {}
    if turret.sway:
        columns |= {f"base.{name}": base[:, i] for i, name in enumerate(("roll", "pitch", "yaw", "p", "q", "r"))}
    return columns


def write_turret(folder: Path, turret: Turret, hidden: Hidden, axis: int, seed: int) -> Rig:
    """Logs of the rig, and a model whose numbers are off within what it says of them, but for what is hidden."""
    folder.mkdir(parents=True, exist_ok=True)
    dice = np.random.default_rng((seed, 7))

    def known(value: float, unit: str, share: float) -> dict[str, Any]:
        off = 1.0 + share * float(np.clip(dice.normal(), -1.0, 1.0))
        return measured(float(value * off), unit, f"{share:.0%}")

    axes = {}
    for i, name in enumerate(AXES):
        dry = known(turret.coulomb[i], "N m", 0.05)
        moments = {key: known(value, "kg m2", 0.03) for key, value in zip(_INERTIAS, turret.bodies[i], strict=True)}
        axes[name] = {
            **({"parent": AXES[0]} if i else {}),
            "body": {"mass": measured(turret.masses[i], "kg", "2%"), "inertia": moments},
            "friction": {"coulomb": dry, "breakaway": dry, "viscous": known(turret.viscous[i], "N m s/rad", 0.05)},
            "encoder": {"step": {"value": 2.0 * np.pi / turret.counts, "unit": "rad", "source": "printed"}},
        }
        if turret.gyro:
            axes[name]["gyro"] = {"noise": {"value": turret.gyro, "unit": "rad/s", "source": "printed"}}
    document = {"schema": 1, "name": "turret", "kind": "gimbal", "axes": axes}
    logs = {
        name: write_log(folder / f"{name}.csv", simulated(turret, hidden, axis, 10 * seed + k))
        for k, name in enumerate(("first", "second"))
    }
    planted = {OWN[AXES[axis]] if path == "own" else path: factor for path, factor in hidden.file.items()}
    return Rig(write_model(folder / "model.yaml", document, planted, AXES[axis]), logs)


def asked(folder: Path, name: str, what: str, axis: int, motion: str, seed: int) -> dict[str, Any]:
    """One rig, from dice to verdict."""
    turret = replace(drawn_turret(np.random.default_rng((seed, 3))), motion=motion)
    hidden = HIDDEN[what]
    if any(size.startswith("gyro") for size in hidden.rig):
        turret = replace(turret, gyro=turret.gyro or 1e-3)
    if "unbalance" in hidden.rig:
        # about an upright axis nothing weighs
        turret = replace(turret, sway=0.1)
    rig = write_turret(folder / "files" / name, turret, hidden, axis, seed)
    said = ask(Row(name, rig, ("first",), ("second",), what), folder / "verdicts" / name)
    seen = f"{'swaying' if turret.sway else 'still'}{', gyros' if turret.gyro else ''}"
    of = f" of {AXES[axis]}" if hidden.names or hidden.rig else ""
    return said | {
        "true": f"{what}{of}",
        "motion": f"{motion}, {seen}",
        "judged": judged(said, hidden.names, AXES[axis]),
    }


def work_of(chosen: Chosen) -> dict[str, tuple[str, int, str, int]]:
    """Every thing that is hidden on one axis, then all on the other; motions in turn."""
    kinds = list(HIDDEN)
    return {
        f"{chosen.seed}-{k:02d}": (
            kinds[k % len(kinds)],
            (k + k // len(kinds)) % 2,
            chosen.motions[(k // 2) % len(chosen.motions)],
            1000 * chosen.seed + k,
        )
        for k in range(chosen.rigs)
    }


def main(words: Sequence[str] | None = None) -> None:
    """The command line."""
    ask_many(words, __doc__, tuple(MOTIONS), 2 * len(HIDDEN), work_of, asked)


if __name__ == "__main__":
    main()
