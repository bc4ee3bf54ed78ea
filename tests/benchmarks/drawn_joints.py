"""What does `discrepancy` tell of joints that were drawn, with one number of their model wrong?

    python -m tests.benchmarks.drawn_joints [--seed N] [--first K] [--joints 20] [--out FILE.jsonl]

Joints of an own simulator (exact inverse dynamics, friction that is smooth about standstill) along sines, steps, noise
or a chirp, logged at 50 to 1000 Hz. One of inertia, Coulomb level, viscosity, weight and torque constant is 0.5 to 2
times the right one in the model, or none; half of the joints have something more that their model lacks. A line a
joint; what is right is for the reader to say, since several things may be missing.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict, dataclass
from enum import Enum
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.signal import butter, lfilter, sosfiltfilt

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.discrepancy import Request, diagnose, verdict_of
from sim_backend.model import model_from_document
from tests.discrepancy.test_logs_of_strangers import table

Floats = NDArray[np.float64]
FINE = 10
NUMBERS = ("inertia", "coulomb", "viscous", "unbalance", "gain")
#: where the weight hangs at position zero, rad
HANGS = 0.3


class Along(Enum):
    """How a joint moves."""

    SINES = "sines"
    STEPS = "steps"
    NOISE = "noise"
    CHIRP = "chirp"


@dataclass(frozen=True)
class Drawn:
    """A joint, SI, how it moves and is logged, and what is wrong with its model."""

    seed: int
    inertia: float
    coulomb: float
    viscous: float
    weight: float
    rate_hz: float
    speed_hz: float
    amplitude: float
    along: str
    seconds: float
    noise: float
    step: float
    torque_step: float
    extra: str
    wrong: str
    factor: float


def motion(
    along: str,
    rng: np.random.Generator,
    seconds: float,
    rate_hz: float,
    amplitude: float,
    speed_hz: float,
    phase: float,
) -> tuple[Floats, Floats, Floats, Floats]:
    """Time, position, rate and acceleration on a grid ten times as fine as the log's."""
    fine_hz = rate_hz * FINE
    t = np.arange(int(seconds * fine_hz)) / fine_hz
    edge = speed_hz / (0.5 * fine_hz)
    if along == Along.SINES.value:
        sizes, shifts = rng.uniform(0.2, 1.0, 3), rng.uniform(0.0, 6.0, 3)
        hertz = speed_hz * np.array([0.15, 0.5, 1.4]) * rng.uniform(0.8, 1.2, 3)
        q = np.sum(
            [amplitude * a * np.sin(2.0 * np.pi * f * t + p) for a, f, p in zip(sizes, hertz, shifts, strict=True)], 0
        )
    elif along == Along.STEPS.value:
        targets = rng.uniform(-amplitude, amplitude, int(seconds / 1.5) + 2)
        q = np.repeat(targets, int(1.5 * fine_hz))[: len(t)]
        b, a = butter(1, edge)
        for _ in range(4):
            q = lfilter(b, a, q)
    elif along == Along.NOISE.value:
        q = sosfiltfilt(butter(3, edge, output="sos"), rng.normal(size=len(t)))
        q *= amplitude / np.std(q)
    else:
        low, high = 0.1 * speed_hz, 2.5 * speed_hz
        growth = (high / low) ** (1.0 / seconds)
        turned = 2.0 * np.pi * low * (growth**t - 1.0) / np.log(growth)
        q = amplitude * np.sin(turned + phase) * np.minimum(1.0, 0.5 * high / (low * growth**t))
    s = np.clip(t / 1.5, 0.0, 1.0)
    q = q * (s**3 * (10.0 - 15.0 * s + 6.0 * s * s))
    v = np.gradient(q, 1.0 / fine_hz)
    return t, q, v, np.gradient(v, 1.0 / fine_hz)


def drawn(seed: int) -> Drawn:
    """A joint: friction, weight and noise in proportion to what its inertia takes."""
    rng = np.random.default_rng(seed)
    inertia, rate_hz = 10.0 ** rng.uniform(-3.5, 1.0), float(rng.choice([50, 100, 200, 500, 1000]))
    speed_hz = min(rng.uniform(0.6, 1.6), rate_hz / 60.0)
    along, amplitude = str(rng.choice([one.value for one in Along])), rng.uniform(0.3, 1.5)
    _, _, v, a = motion(along, np.random.default_rng(seed + 1), 20.0, rate_hz, amplitude, speed_hz, 0.0)
    typical, rate = float(np.std(a)) * inertia, float(np.std(v))
    coulomb = typical * 10.0 ** rng.uniform(-0.7, 0.5)
    viscous = typical / rate * 10.0 ** rng.uniform(-1.2, 0.0)
    weight = typical * 10.0 ** rng.uniform(-0.5, 0.6) if rng.random() < 0.5 else 0.0
    extra = str(rng.choice(["none", "none", "cogging", "drift", "asymmetry", "load"]))
    noise = typical * 10.0 ** rng.uniform(-2.7, -1.3)
    step = 2.0 * np.pi / float(rng.choice([4096, 16384, 65536, 2**20]))
    torque_step = noise * float(rng.choice([0.1, 1.0, 3.0]))
    wrong = str(rng.choice(["inertia", "coulomb", "viscous", "gain", "none"] + (["unbalance"] if weight else [])))
    factor = float(rng.choice([0.5, 0.7, 1.4, 2.0])) if wrong != "none" else 1.0
    return Drawn(
        *(seed, inertia, float(coulomb), float(viscous), float(weight), rate_hz, float(speed_hz), float(amplitude)),
        *(along, float(rng.choice([15, 30])), float(noise), step, float(torque_step), extra, wrong, factor),
    )


def log(joint: Drawn, which: int) -> SignalsTable:
    """One of its two logs."""
    rng = np.random.default_rng(joint.seed * 7 + which)
    amplitude, speed_hz = joint.amplitude * (1.0, 0.9)[which], joint.speed_hz * (1.0, 0.85)[which]
    t, q, v, a = motion(joint.along, rng, joint.seconds, joint.rate_hz, amplitude, speed_hz, float(which))
    creep = 0.02 * float(np.std(v))
    level = joint.coulomb * (1.0 + 0.15 * np.exp(-np.abs(v) / (5.0 * creep)))
    if joint.extra == "drift":
        level = level * (1.0 + 0.1 * np.sin(1.4 * np.pi * t / joint.seconds))
    if joint.extra == "asymmetry":
        level = level * np.where(v > 0.0, 1.15, 0.85)
    torque = joint.inertia * a + joint.viscous * v + joint.weight * np.sin(q + HANGS)
    way = np.tanh(v / creep)
    torque = torque + level * way + (0.1 * np.abs(torque) * way if joint.extra == "load" else 0.0)
    if joint.extra == "cogging":
        torque = torque + 0.3 * joint.coulomb * np.sin(9.0 * q + 1.0)
    rows = len(t) // FINE
    torque = torque[: rows * FINE].reshape(rows, FINE).mean(axis=1) + rng.normal(0.0, joint.noise, rows)
    torque = np.round(torque / joint.torque_step) * joint.torque_step
    position = np.round(q[::FINE][:rows] / joint.step) * joint.step
    return table({"pan.torque": torque, "pan.position": position}, t[::FINE][:rows])


def verdict(joint: Drawn) -> dict[str, Any]:
    """What `discrepancy` says of both logs and the model, in which one number may be wrong."""
    # with a wrong torque constant every number was measured as much off
    off = {name: joint.factor if joint.wrong in (name, "gain") else 1.0 for name in NUMBERS}
    arm = joint.weight * off["unbalance"] / 9.81
    body: dict[str, Any] = {"mass": 1.0, "inertia": {"zz": joint.inertia * off["inertia"]}}
    if joint.weight:
        body["cog"] = {"x": arm * np.sin(HANGS), "y": -arm * np.cos(HANGS)}
    coulomb = joint.coulomb * off["coulomb"]
    axis = {
        "body": body,
        "friction": {"coulomb": coulomb, "breakaway": 1.15 * coulomb, "viscous": joint.viscous * off["viscous"]},
        "encoder": {"step": joint.step},
        "actuator": {"limit": 1e5 * joint.inertia},
    }
    document = {"schema": 1, "name": "arm", "kind": "rotary", "incline_sine": 1.0, "axes": {"pan": axis}}
    request = Request(model_from_document(document, "arm"), (log(joint, 0),), (log(joint, 1),))
    return verdict_of(diagnose(request)).document


def told(effect: dict[str, Any]) -> str:
    """One cause: name, status, probability, its first numbers over those of the model."""
    numbers = [
        f"{name} {one['value']:.3g}" + ("" if one["nominal"] is None else f" ({one['nominal']:.3g})")
        for name, one in list(effect["parameters"].items())[:2]
    ]
    return f"{effect['name']} {effect['status']} {effect['probability']:.2f}: " + ", ".join(numbers)


def main() -> None:
    """A line a joint."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--joints", type=int, default=20)
    parser.add_argument("--out", type=Path)
    chosen = parser.parse_args()
    for index in range(chosen.first, chosen.first + chosen.joints):
        joint = drawn(1000 * chosen.seed + index)
        head = f"{index}: {joint.wrong} x {joint.factor:g}, {joint.extra}, {joint.along}, {joint.rate_hz:g} Hz: "
        try:
            found = verdict(joint)
        except BadInputError as error:
            print(head + f"refused: {error}", flush=True)
            continue
        gap = found["gap"]
        left = f"{gap['before'] / gap['noise_floor']:.1f} to {gap['after'] / gap['noise_floor']:.1f} floors"
        others = ", ".join(sorted({one["name"] for one in found["alternatives"]}))
        causes = [told(effect) for effect in found["effects"]]
        print(
            head + "; ".join([f"{found['verdict']}, {left}", *causes, *([f"or {others}"] if others else [])]),
            flush=True,
        )
        if chosen.out is not None:
            with chosen.out.open("a", encoding="utf-8") as file:
                file.write(json.dumps({"joint": asdict(joint), "verdict": found}) + "\n")


if __name__ == "__main__":
    main()
