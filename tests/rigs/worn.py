"""Joints that no first model describes: friction of slipping elements, and mostly something else beside it, while one
number of the model file is off, or none. Stepped here by itself.

    python -m tests.rigs.worn FOLDER --seed 1 --rigs 42 --motions sines,moves --workers 2

What the joint has and the model has not is no false name where it is told; what it has not, is.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import astuple, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numba import njit

from tests.rigs.drawn import COULOMB_PATHS, INERTIA, MOTIONS, TYPICAL_RAD_S2, VISCOUS
from tests.rigs.many import Chosen, ask_many
from tests.rigs.rig import Rig, measured, write_log, write_model
from tests.rigs.told import Row, ask

AXIS, LOG_S = "joint", 40.0
#: share of friction that each slipping element carries, and where it slips over where the third does
SHARES, SLIPS = np.array([0.3, 0.25, 0.2, 0.15, 0.1]), np.array([0.3, 0.6, 1.0, 2.0, 4.0])
#: number that is off in the model file, its effect, and factors on paths
PLANTED: Mapping[str, tuple[str | None, Mapping[str, float]]] = {
    "nothing": (None, {}),
    "inertia halved": ("inertia", {INERTIA: 0.5}),
    "inertia doubled": ("inertia", {INERTIA: 2.0}),
    "viscous halved": ("viscous", {VISCOUS: 0.5}),
    "viscous doubled": ("viscous", {VISCOUS: 2.0}),
    "dry friction halved": ("coulomb", dict.fromkeys(COULOMB_PATHS, 0.5)),
    "dry friction doubled": ("coulomb", dict.fromkeys(COULOMB_PATHS, 2.0)),
}
#: what else the joint has: names that are right then
BESIDE: Mapping[str, frozenset[str]] = {
    "nothing": frozenset(),
    "a ripple": frozenset({"cogging"}),
    "a flexible shaft": frozenset({"structural_resonance"}),
    "uneven friction": frozenset({"position_dependent_friction"}),
    "gravity": frozenset({"static_unbalance"}),
    "a flexible shaft and a ripple": frozenset({"structural_resonance", "cogging"}),
}
#: every one of them creeps before it slides, and most have a dip in their friction
ALWAYS = frozenset({"presliding", "stribeck"})


@dataclass(frozen=True)
class Worn:
    """One drawn joint: SI units, radians."""

    rate_hz: float
    inertia: float
    coulomb: float
    breakaway: float
    stribeck_rad_s: float
    viscous: float
    #: travel after which the third slipping element slips
    slip: float
    step: float
    #: moment of the load on a flexible shaft, kg m2 (0: none), and its stiffness and damping
    load: float = 0.0
    stiffness: float = 0.0
    damping: float = 0.0
    ripple: float = 0.0
    order: float = 0.0
    uneven: float = 0.0
    gravity: float = 0.0

    @property
    def typical(self) -> float:
        """The torque that sizes are told in, N m."""
        return self.inertia * TYPICAL_RAD_S2


def drawn_joint(dice: np.random.Generator, beside: str) -> Worn:
    """A joint between a hobby servo and a robot's shoulder, with what else it has."""
    inertia = float(np.exp(dice.uniform(np.log(0.003), np.log(3.0))))
    typical = inertia * TYPICAL_RAD_S2
    coulomb = float(dice.uniform(0.1, 0.3)) * typical
    load = 0.6 * inertia if "flexible" in beside else 0.0
    swing = 2.0 * np.pi * float(dice.uniform(25.0, 60.0))
    reduced = load * (inertia - load) / inertia
    return Worn(
        rate_hz=float(dice.choice([200.0, 500.0, 1000.0])),
        inertia=inertia,
        coulomb=coulomb,
        breakaway=coulomb * float(dice.uniform(1.0, 1.3)),
        stribeck_rad_s=float(dice.uniform(0.01, 0.06)),
        viscous=float(dice.uniform(0.1, 0.4)) * typical,
        slip=float(dice.uniform(2e-4, 2e-3)),
        step=2.0 * np.pi / 2 ** int(dice.integers(13, 20)),
        load=load,
        stiffness=swing**2 * reduced,
        damping=0.06 * swing * reduced,
        ripple=0.05 * typical if "ripple" in beside else 0.0,
        order=float(dice.integers(4, 30)),
        uneven=0.12 if beside == "uneven friction" else 0.0,
        gravity=0.5 * typical if beside == "gravity" else 0.0,
    )


@njit
def _run(numbers: np.ndarray, reference: np.ndarray, shares: np.ndarray, slips: np.ndarray) -> np.ndarray:
    """Torque that the drive gave and position that the encoder read, (2, rows); `numbers` are the fields of `Worn`."""
    (rate_hz, inertia, coulomb, breakaway, dip, viscous, slip, mark, load, stiffness, damping, ripple, order, uneven,
     gravity) = numbers  # fmt: skip
    period = 1.0 / rate_hz
    steps = max(20, int(period / 2.5e-5))
    h, bandwidth, bristle = period / steps, 20.0, np.zeros(len(shares))
    out = np.zeros((2, len(reference)))
    q, v, far, far_rate, seen_rate, before, total = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(len(reference)):
        seen = mark * np.round(q / mark)
        seen_rate += 0.3 * ((seen - before) / period - seen_rate)
        before = seen
        error = reference[k] - seen
        total += 0.5 * bandwidth * error * period
        command = inertia * (bandwidth**2 * (error + total) - 1.4 * bandwidth * seen_rate)
        grain = 1e-3 * inertia * 10.0
        command = grain * np.round(command / grain)
        out[0, k], out[1, k] = command, seen
        for _ in range(steps):
            level = (coulomb + (breakaway - coulomb) * np.exp(-((v / dip) ** 2))) * (1.0 + uneven * np.sin(q + 0.5))
            friction = viscous * v
            for i in range(len(shares)):
                bristle[i] = min(max(bristle[i] + h * v, -slip * slips[i]), slip * slips[i])
                friction += shares[i] * level * bristle[i] / (slip * slips[i])
            weight = gravity * np.sin((far if load > 0.0 else q) + 0.3)
            shaft = stiffness * (q - far) + damping * (v - far_rate) if load > 0.0 else weight
            v += h * (command - friction - shaft + ripple * np.sin(order * q + 1.0)) / (inertia - load)
            q += h * v
            if load > 0.0:
                far_rate += h * (shaft - weight) / load
                far += h * far_rate
    return out


def simulated(joint: Worn, motion: str, seed: int) -> dict[str, np.ndarray]:
    """The columns of one log."""
    time = np.arange(int(LOG_S * joint.rate_hz)) / joint.rate_hz
    reference = MOTIONS[motion](np.random.default_rng(seed), time)
    torque, position = _run(np.array(astuple(joint)), reference, SHARES, SLIPS)
    return {"time_s": time, f"{AXIS}.torque": torque, f"{AXIS}.position": position}


def write_worn(folder: Path, joint: Worn, factors: Mapping[str, float], motion: str, seed: int) -> Rig:
    """Logs of the joint, and a model without a bristle whose numbers are off within what it says of them, and by
    `factors`.
    """
    folder.mkdir(parents=True, exist_ok=True)
    dice = np.random.default_rng((seed, 7))
    logs = {
        name: write_log(folder / f"{name}.csv", simulated(joint, motion, 10 * seed + k))
        for k, name in enumerate(("first", "second"))
    }

    def known(value: float, unit: str, share: float) -> dict[str, Any]:
        off = 1.0 + share * float(np.clip(dice.normal(), -1.0, 1.0))
        return measured(value * off, unit, f"{share:.0%}")

    coulomb = known(joint.coulomb, "N m", 0.1)
    axis = {
        "body": {"mass": known(1.0, "kg", 0.05), "inertia": {"zz": known(joint.inertia, "kg m2", 0.05)}},
        "friction": {"coulomb": coulomb, "breakaway": coulomb, "viscous": known(joint.viscous, "N m s/rad", 0.1)},
        "encoder": {"step": {"value": joint.step, "unit": "rad", "source": "printed"}},
    }
    document = {"schema": 1, "name": "worn", "kind": "rotary", "incline_sine": 1.0, "axes": {AXIS: axis}}
    return Rig(write_model(folder / "model.yaml", document, factors), logs)


def judged(said: Mapping[str, Any], planted: str | None, has: frozenset[str]) -> str:
    """right: the planted number, and nothing that the joint has not; class: it is among what was told; silent; false:
    a name of what the joint has not.
    """
    if "error" in said:
        return "error"
    verdict = said["verdict"]
    named = {one["name"] for one in verdict["effects"] if one["status"] == "named"}
    told = {one["name"] for one in (*verdict["effects"], *verdict["alternatives"])}
    wanted = {planted} - {None}
    if named - has - ALWAYS - wanted - ({"back_emf"} if planted == "viscous" else set()):
        return "false"
    if wanted <= named:
        return "right"
    return "class" if wanted <= told else "silent"


def asked(folder: Path, name: str, off: str, beside: str, motion: str, seed: int) -> dict[str, Any]:
    """One joint, from dice to verdict."""
    planted, factors = PLANTED[off]
    joint = drawn_joint(np.random.default_rng((seed, 3)), beside)
    rig = write_worn(folder / "files" / name, joint, factors, motion, seed)
    said = ask(Row(name, rig, ("first",), ("second",), off), folder / "verdicts" / name)
    return said | {"true": f"{off}; {beside}", "motion": motion, "judged": judged(said, planted, BESIDE[beside])}


def work_of(chosen: Chosen) -> dict[str, tuple[str, str, str, int]]:
    """Every number that is off, beside one thing after the other; motions in turn."""
    off, beside = list(PLANTED), list(BESIDE)
    pairs = [(one, other) for other in beside for one in off]
    return {
        f"{chosen.seed}-{k:02d}": (
            *pairs[k % len(pairs)],
            chosen.motions[k % len(chosen.motions)],
            1000 * chosen.seed + k,
        )
        for k in range(chosen.rigs)
    }


def main(words: Sequence[str] | None = None) -> None:
    """The command line."""
    ask_many(words, __doc__, tuple(MOTIONS), len(PLANTED) * len(BESIDE), work_of, asked)


if __name__ == "__main__":
    main()
