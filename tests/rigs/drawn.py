"""Rigs drawn at random and simulated by MuJoCo: its joints, its dry friction, its integrator, none of our own code; the
logs and the first model of a stranger, and what the command says of them.

    python -m tests.rigs.drawn FOLDER --seed 1 --rigs 68 --motions sines,moves,sweeps,turns --workers 2

Each rig hides one thing (or none) from its model file. What has been asked stays in FOLDER, and a run that was
interrupted goes on; `--table` only prints what is there.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from tests.rigs.many import Chosen, ask_many, judged
from tests.rigs.rig import Rig, measured, write_log, write_model
from tests.rigs.told import Row, ask

AXIS = "joint"
#: acceleration (rad/s^2) that sizes of torques are told in, and s of each log
TYPICAL_RAD_S2, LOG_S = 10.0, 40.0
GRAVITY_M_S2 = 9.81
#: of a flexible shaft
_DAMPING = 0.03


@dataclass(frozen=True)
class Hidden:
    """What a rig has and its model has not: names that are right, and what it does to the rig or to the file."""

    names: frozenset[str]
    #: numbers of the model file times these
    file: Mapping[str, float] = field(default_factory=dict)
    #: of the rig: fractions of the typical torque or of the inertia, or samples; `stated` of its unbalance the file has
    rig: Mapping[str, float] = field(default_factory=dict)


def one(*names: str, file: Mapping[str, float] | None = None, **rig: float) -> Hidden:
    """Shorthand of the table below."""
    return Hidden(frozenset(names), file or {}, rig)


INERTIA, VISCOUS = "body.inertia.zz", "friction.viscous"
COULOMB_PATHS = ("friction.coulomb", "friction.breakaway")
HIDDEN: dict[str, Hidden] = {
    "nothing": one(),
    "viscous halved": one("viscous", file={VISCOUS: 0.5}),
    "viscous doubled": one("viscous", file={VISCOUS: 2.0}),
    "inertia halved": one("inertia", file={INERTIA: 0.5}),
    "inertia doubled": one("inertia", file={INERTIA: 2.0}),
    "dry friction halved": one("coulomb", file=dict.fromkeys(COULOMB_PATHS, 0.5)),
    "dry friction doubled": one("coulomb", file=dict.fromkeys(COULOMB_PATHS, 2.0)),
    "unbalance": one("static_unbalance", unbalance=0.6),
    "ripple": one("cogging", ripple=0.15),
    "spring": one("cable_spring", spring=0.5),
    "offset": one("torque_offset", offset=0.15),
    "gain": one("torque_gain", "inertia", gain=0.8),
    "late command": one("transport_delay", delay=3.0),
    "lagging actuator": one("actuator_lag", lag=4.0),
    "friction by direction": one("coulomb_asymmetry", drag=0.25),
    # no effect of the catalogue does these
    "hardening stop": one(stop=3.0),
    "friction that switches": one(switching=0.5),
}


@dataclass(frozen=True)
class Joint:
    """One drawn rig: SI units, radians."""

    rate_hz: float
    inertia: float
    coulomb: float
    viscous: float
    counts: int
    orders: int
    phase: float
    #: time, s, in which dry friction brings a slow joint to rest; MuJoCo's own is 20 ms
    softness_s: float
    #: of a part of its inertia on a flexible shaft, where it has one
    resonance_hz: float = 0.0
    motion: str = "sines"

    @property
    def typical(self) -> float:
        """The torque that sizes are told in, N m."""
        return self.inertia * TYPICAL_RAD_S2


def drawn_joint(dice: np.random.Generator) -> Joint:
    """A joint between a hobby servo and the axis of a telescope."""
    inertia = float(np.exp(dice.uniform(np.log(0.002), np.log(5.0))))
    return Joint(
        rate_hz=float(dice.choice([250.0, 500.0, 1000.0])),
        inertia=inertia,
        coulomb=float(dice.uniform(0.1, 0.4)) * inertia * TYPICAL_RAD_S2,
        viscous=float(dice.uniform(0.1, 0.4)) * inertia * TYPICAL_RAD_S2,
        counts=int(2 ** dice.integers(14, 21)),
        orders=int(dice.integers(5, 37)),
        phase=float(dice.uniform(0.0, 2.0 * np.pi)),
        softness_s=float(dice.choice([0.002, 0.02])),
        resonance_hz=float(dice.uniform(12.0, 40.0)),
    )


def simulated(joint: Joint, hidden: Hidden, seed: int) -> dict[str, np.ndarray]:
    """The columns of one log: a position loop follows sines and moves, as a user would have it."""
    import mujoco

    dice = np.random.default_rng(seed)
    sizes, typical, period = hidden.rig, joint.typical, 1.0 / joint.rate_hz
    # an off-centre mass whose own share of the inertia is small
    radius = 0.3 * joint.inertia * GRAVITY_M_S2 / max(sizes.get("unbalance", 0.0) * typical, 1e-9)
    mass = sizes.get("unbalance", 0.0) * typical / (GRAVITY_M_S2 * radius) if sizes.get("unbalance") else 1e-6
    own = joint.inertia - mass * radius**2 if sizes.get("unbalance") else joint.inertia
    hung, load = sizes.get("flexible", 0.0) * own, ""
    if hung:
        # behind a flexible shaft
        own -= hung
        swing, reduced = 2.0 * np.pi * joint.resonance_hz, hung * own / (hung + own)
        load = (
            f'<body><inertial pos="0 0 0" mass="1e-6" diaginertia="{hung} {hung} {hung}"/><joint type="hinge" '
            f'axis="0 -1 0" stiffness="{swing**2 * reduced}" damping="{2.0 * _DAMPING * swing * reduced}"/></body>'
        )
    steps = 20
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{period / steps}" integrator="implicitfast"/><worldbody><body>'
        f'<inertial pos="{radius if sizes.get("unbalance") else 0} 0 0" mass="{mass}" '
        f'diaginertia="{own} {own} {own}"/>'
        f'<joint type="hinge" axis="0 -1 0" damping="{joint.viscous}" frictionloss="{joint.coulomb}" '
        f'solreffriction="{joint.softness_s} 1" '
        f'stiffness="{sizes.get("spring", 0.0) * typical}"/>{load}</body></worldbody></mujoco>'
    )
    data = mujoco.MjData(model)
    rows = int(LOG_S * joint.rate_hz)
    time = period * np.arange(rows)
    reference = MOTIONS[joint.motion](dice, time)
    columns = {"time_s": time, **{f"{AXIS}.{name}": np.zeros(rows) for name in ("torque", "position", "position_ref")}}
    columns[f"{AXIS}.position_ref"] = reference
    bandwidth = 25.0
    step = 2.0 * np.pi / joint.counts
    late, lag = int(sizes.get("delay", 0.0)), sizes.get("lag", 0.0) * period
    sent, acting, before, rate, total, grip = [0.0] * (late + 1), 0.0, 0.0, 0.0, 0.0, 1.0
    for k in range(rows):
        measured = step * round(float(data.qpos[0]) / step)
        rate += 0.3 * ((measured - before) / period - rate) if k else 0.0
        before = measured
        error = float(reference[k]) - measured
        grown = total + 0.5 * bandwidth * error * period
        wanted = joint.inertia * (bandwidth**2 * (error + grown) - 1.4 * bandwidth * rate)
        command = float(np.clip(wanted, -3.0 * typical, 3.0 * typical))
        # no integral winds up while the drive gives all it has
        total = grown if command == wanted else total
        columns[f"{AXIS}.torque"][k], columns[f"{AXIS}.position"][k] = command, measured
        sent = [*sent[1:], command]
        if dice.random() < period / 3.0:
            grip = 1.0 + sizes.get("switching", 0.0) * float(dice.choice([-1.0, 0.0, 1.0]))
        for _ in range(steps):
            acting += (sent[0] - acting) * (1.0 - np.exp(-period / steps / lag)) if lag else sent[0] - acting
            q, v = float(data.qpos[0]), float(data.qvel[0])
            model.dof_frictionloss[0] = joint.coulomb * grip * (1.0 + sizes.get("drag", 0.0) * np.sign(v))
            data.qfrc_applied[0] = (
                sizes.get("gain", 1.0) * acting
                + sizes.get("offset", 0.0) * typical
                + sizes.get("ripple", 0.0) * typical * np.sin(joint.orders * q + joint.phase)
                - sizes.get("stop", 0.0) * typical * np.sign(q) * max(abs(q) - 0.7, 0.0) ** 3 * 10.0
            )
            mujoco.mj_step(model, data)
    return columns


def _sines(dice: np.random.Generator, time: np.ndarray) -> np.ndarray:
    """Sines of half a minute to a second, about 1 rad in all."""
    hz = np.exp(dice.uniform(np.log(0.04), np.log(1.0), 6))
    sizes = dice.uniform(0.3, 1.0, 6) * np.minimum(1.0, 0.3 / hz)
    phases = dice.uniform(0.0, 2.0 * np.pi, 6)
    sines = sizes / sizes.sum() * np.sin(2.0 * np.pi * hz * time[:, None] + phases)
    return np.asarray(sines.sum(axis=1) * np.minimum(1.0, time / 2.0))


def _moves(dice: np.random.Generator, time: np.ndarray) -> np.ndarray:
    """From one place to another within 1 rad, each move without jerk at its ends, and a rest of up to a second."""
    position, now, found = 0.0, 0.0, np.zeros(len(time))
    while now < time[-1]:
        goal, takes = float(dice.uniform(-1.0, 1.0)), float(dice.uniform(0.4, 3.0))
        share = np.clip((time - now) / takes, 0.0, 1.0)
        smooth = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
        found = np.where(time >= now, position + (goal - position) * smooth, found)
        position, now = goal, now + takes + float(dice.uniform(0.0, 1.0))
    return np.asarray(found)


def _sweeps(dice: np.random.Generator, time: np.ndarray) -> np.ndarray:
    """To and fro over 0.8 rad either way at constant speeds between 0.05 and 2 rad/s, each once both ways."""
    speed = np.exp(dice.uniform(np.log(0.05), np.log(2.0), 400))
    times = np.concatenate([[0.0], np.cumsum(np.repeat(1.6 / speed, 2))])
    ends = np.where(np.arange(len(times)) % 2, 0.8, -0.8)
    return np.asarray(np.interp(time, times, ends) + 0.8)


def _turns(dice: np.random.Generator, time: np.ndarray) -> np.ndarray:
    """Whole turns at a few speeds between 0.3 and 3 rad/s, half of the time the other way."""
    speed = np.exp(dice.uniform(np.log(0.3), np.log(3.0), 6)) * np.array([1.0, 1.0, 1.0, -1.0, -1.0, -1.0])
    part = np.minimum((6.0 * time / time[-1]).astype(int), 5)
    return np.asarray(np.cumsum(speed[part]) * (time[1] - time[0]))


#: what a user may have logged
MOTIONS = {"sines": _sines, "moves": _moves, "sweeps": _sweeps, "turns": _turns}


def write_drawn(folder: Path, joint: Joint, hidden: Hidden, seed: int) -> Rig:
    """Logs of the rig, and a model whose numbers are off within what it says of them, but for what is hidden."""
    folder.mkdir(parents=True, exist_ok=True)
    dice = np.random.default_rng((seed, 7))
    inertia, coulomb, viscous = (
        number * (1.0 + spread * float(np.clip(dice.normal(), -1.0, 1.0)))
        for number, spread in ((joint.inertia, 0.03), (joint.coulomb, 0.05), (joint.viscous, 0.05))
    )
    sizes = hidden.rig
    # of a mass of 1 kg; only its product with the distance counts
    lever = sizes.get("stated", 0.0) * sizes.get("unbalance", 0.0) * joint.typical / GRAVITY_M_S2
    body = {"cog": {"x": measured(lever, "m", "3%")}} if lever else {}
    axis = {
        "body": {"mass": measured(1.0, "kg", "5%"), "inertia": {"zz": measured(inertia, "kg m2", "3%")}} | body,
        "friction": {
            "coulomb": measured(coulomb, "N m", "5%"),
            "breakaway": measured(coulomb, "N m", "5%"),
            "viscous": measured(viscous, "N m s/rad", "5%"),
        },
        "encoder": {"step": {"value": 2.0 * np.pi / joint.counts, "unit": "rad", "source": "printed"}},
    }
    document = {"schema": 1, "name": "drawn", "kind": "rotary", "incline_sine": 1.0, "axes": {AXIS: axis}}
    logs = {
        name: write_log(folder / f"{name}.csv", simulated(joint, hidden, 10 * seed + k))
        for k, name in enumerate(("first", "second"))
    }
    return Rig(write_model(folder / "model.yaml", document, hidden.file), logs)


def asked(folder: Path, name: str, what: str, motion: str, seed: int) -> dict[str, Any]:
    """One rig, from dice to verdict."""
    joint = replace(drawn_joint(np.random.default_rng((seed, 3))), motion=motion)
    rig = write_drawn(folder / "files" / name, joint, HIDDEN[what], seed)
    said = ask(Row(name, rig, ("first",), ("second",), what), folder / "verdicts" / name)
    return said | {"true": what, "motion": motion, "judged": judged(said, HIDDEN[what].names, AXIS)}


def work_of(chosen: Chosen) -> dict[str, tuple[str, str, int]]:
    """Every thing that is hidden with one motion, then all with the next."""
    kinds, motions = list(HIDDEN), chosen.motions
    return {
        f"{chosen.seed}-{k:02d}": (
            kinds[k % len(kinds)],
            motions[k // len(kinds) % len(motions)],
            1000 * chosen.seed + k,
        )
        for k in range(chosen.rigs)
    }


def main(words: Sequence[str] | None = None) -> None:
    """The command line."""
    ask_many(words, __doc__, tuple(MOTIONS), len(HIDDEN), work_of, asked)


if __name__ == "__main__":
    main()
