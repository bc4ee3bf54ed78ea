"""Models drawn at random, exported as MJCF, simulated by MuJoCo's own laws and compared with the model as it is.

    python -m tests.model_exports.round_trip FOLDER --seed 1 --models 40

What the format holds must not be missed: `discrepancy` names nothing. What the account lists as left out is what it
may name. One line a model; answers stay in FOLDER, and an interrupted run goes on.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from gimbal_hil.knowledge.model_exports import ExportedModel, ModelFormat, export_model
from sim_backend.model import AntennaModel, model_from_document, shipped_model
from tests.rigs.rig import write_log

#: steps a tick: so fine that the rule by which MuJoCo integrates no longer shows
RATE_HZ, SUBSTEPS, LOG_S = 1000.0, 50, 20.0
GYRO_NOISE, PATIENCE_S = 2e-4, 900.0
#: per effect its parameters' ranges; the first group is what MJCF holds
HELD: dict[str, dict[str, tuple[float, float]]] = {
    "cogging": {"amplitude": (0.02, 0.1), "order": (6.0, 30.0), "phase": (-3.0, 3.0)},
    "cable_spring": {"stiffness": (0.1, 0.6), "rest_position": (-0.3, 0.3)},
    "quadratic_drag": {"coefficient": (0.02, 0.1)},
    "transport_delay": {"delay": (1e-3, 4e-3)},
    "torque_gain": {"gain_error": (-0.1, 0.1)},
    "torque_offset": {"offset": (-0.1, 0.1)},
    "actuator_lag": {"time_constant": (2e-3, 8e-3)},
    "structural_resonance": {
        "antiresonance_frequency": (10.0, 25.0),
        "damping_ratio": (0.02, 0.04),
        "inertia_share": (0.1, 0.25),
    },
}
LEFT_OUT: dict[str, dict[str, tuple[float, float]]] = {
    "coulomb_asymmetry": {"asymmetry": (0.2, 0.4)},
    "load_dependent_friction": {"coefficient": (0.05, 0.1)},
    "position_dependent_friction": {"relative_amplitude": (0.3, 0.5), "order": (4.0, 9.0), "phase": (-3.0, 3.0)},
    "gyro_bias": {"bias": (2e-3, 5e-3)},
    "gyro_scale": {"scale_error": (0.01, 0.03)},
    "encoder_eccentricity": {"amplitude": (1e-3, 3e-3), "phase": (-3.0, 3.0)},
}


def drawn(dice: np.random.Generator) -> AntennaModel:
    """The shipped antenna with other numbers and two effects: both held, or one that is left out."""
    model = shipped_model()
    for axis in model.axes:
        factors = {path: float(np.exp(dice.uniform(-0.2, 0.2))) for path in ("viscous", "sigma0", "sigma1")}
        level = float(np.exp(dice.uniform(-0.3, 0.3)))
        values = {f"friction.{key}": factor * model.number(axis, f"friction.{key}") for key, factor in factors.items()}
        values |= {f"friction.{key}": level * model.number(axis, f"friction.{key}") for key in ("coulomb", "breakaway")}
        # MuJoCo's bump has this shape: what another one leaves is not what is asked for here
        model = model.with_numbers(axis, {**values, "friction.shape": 2.0})
    chosen = list(dice.permutation(list(HELD))[:2]) if dice.random() < 0.5 else [str(dice.choice(list(LEFT_OUT)))]
    for name in chosen:
        ranges = (HELD | LEFT_OUT)[name]
        values = {key: float(dice.uniform(*span)) for key, span in ranges.items()}
        model = model.with_effect(str(name), str(dice.choice(model.axes)), values)
    return model


def simulated(model: AntennaModel, exported: ExportedModel, seed: int) -> dict[str, np.ndarray]:
    """Columns of a log: position loops follow sines over a trapezoid of slow speeds, in MuJoCo."""
    import mujoco

    dice = np.random.default_rng(seed)
    built = mujoco.MjModel.from_xml_string(exported.text)
    data = mujoco.MjData(built)
    at = [built.joint(axis).qposadr[0] for axis in model.axes]
    moving = [built.joint(axis).dofadr[0] for axis in model.axes]
    gyros = [built.sensor(f"{axis}.gyro").adr[0] + (2, 1)[k] for k, axis in enumerate(model.axes)]
    rows = int(LOG_S * RATE_HZ)
    time = np.arange(rows) / RATE_HZ
    grown = 1.0 - np.exp(-((time / 1.5) ** 2))
    hz, phase, size = (
        dice.uniform(0.05, 1.5, (2, 4)),
        dice.uniform(0, 2 * np.pi, (2, 4)),
        dice.uniform(0.1, 0.4, (2, 4)),
    )
    size /= 1.0 + hz
    reference = np.stack(
        [
            grown * sum(size[k, i] * np.sin(2 * np.pi * hz[k, i] * time + phase[k, i]) for i in range(4)) - 0.0
            for k in range(2)
        ],
        axis=1,
    )
    inertia = np.array([0.50, 0.0696])
    step = np.array([model.number(axis, "encoder.step") for axis in model.axes])
    limit = np.array([model.number(axis, "actuator.limit") for axis in model.axes])
    torque, position, rate = np.zeros((rows, 2)), np.zeros((rows, 2)), np.zeros((rows, 2))
    mujoco.mj_forward(built, data)
    # a log starts at rest: the loop holds gravity and springs from the first row on
    total = (data.qfrc_bias - data.qfrc_passive)[moving] / inertia / 6000.0
    for k in range(rows):
        seen = np.round(data.qpos[at] / step) * step
        mujoco.mj_forward(built, data)
        # MuJoCo takes positions on with the rate after a step: that of an instant is the mean of the two about it
        before = data.sensordata[gyros].copy()
        noise = GYRO_NOISE * dice.normal(size=2)
        error = reference[k] - seen
        total += error / RATE_HZ
        torque[k] = np.clip(
            inertia * (900.0 * error + 6000.0 * total - 45.0 * (data.qvel[moving] + noise)), -limit, limit
        )
        position[k] = seen
        data.ctrl[:] = torque[k]
        mujoco.mj_step(built, data)
        mujoco.mj_forward(built, data)
        rate[k] = 0.5 * (before + data.sensordata[gyros]) + noise
        mujoco.mj_step(built, data, SUBSTEPS - 1)
    columns = {"time_s": time}
    for k, axis in enumerate(model.axes):
        columns |= {f"{axis}.torque": torque[:, k], f"{axis}.position": position[:, k], f"{axis}.rate": rate[:, k]}
    return columns


def asked(folder: Path, seed: int) -> dict[str, Any]:
    """One model, from dice to verdict: what was hidden, what the account left out, and what was named."""
    model = drawn(np.random.default_rng((seed, 1)))
    finer = model_from_document({**model.document, "plant_step_s": 1.0 / RATE_HZ / SUBSTEPS}, model.where)
    exported = export_model(finer, ModelFormat.MJCF)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "model.yaml").write_text(model.to_yaml())
    (folder / "model.xml").write_text(exported.text)
    logs = [write_log(folder / f"{k}.csv", simulated(model, exported, 10 * seed + k)) for k in range(2)]
    begin = [sys.executable, "-c", "from gimbal_hil.surface.cli import main; main()"]
    words = [*begin, "discrepancy", "--model", folder / "model.yaml", "--json"]
    words += ["--measured", logs[0], "--holdout", logs[1], "--out", folder / "out", "--force"]
    done = subprocess.run(list(map(str, words)), capture_output=True, text=True, timeout=PATIENCE_S)
    answer = folder / "out" / "verdict.json"
    if not answer.exists():
        return {"error": done.stderr[-300:]}
    verdict = json.loads(answer.read_text())
    listed = {(one.item.axis, name) for one in exported.left_out for name in one.effects}
    nearly = {(one.item.axis, name) for one in exported.approximated for name in one.effects}
    return {
        "verdict": verdict["verdict"],
        "effects": [f"{entry.effect.name} of {entry.axis}" for entry in model.effects],
        "left_out": sorted(f"{name} of {axis}" for axis, name in listed),
        "told": [f"{one['name']} of {one['axis']}, {one['status']}" for one in verdict["effects"]],
        "judged": judged(verdict, listed, nearly),
    }


def judged(verdict: dict[str, Any], left_out: set[tuple[str, str]], nearly: set[tuple[str, str]]) -> str:
    """What an answer is worth, by (axis, effect) of what the account lists as left out and as held nearly.

    A name that stands on neither list is false, whatever stands beside it: a right name excuses no wrong one.
    """
    told = {(one["axis"], one["name"]) for one in verdict["effects"]}
    named = {(one["axis"], one["name"]) for one in verdict["effects"] if one["status"] == "named"}
    either = told | {(one["axis"], one["name"]) for one in verdict["alternatives"]}
    if named - left_out - nearly:
        return "FALSE NAME"
    if not left_out:
        if told - nearly:
            return "guessed though held"
        return "held nearly, told" if told else "nothing named"
    if verdict["verdict"] == "no_discrepancy":
        return "FALSE ALL-CLEAR"
    if left_out <= named:
        return "left out, named"
    if left_out & either:
        return "left out, in its class"
    return "left out, another guessed" if told else "left out, no name"


def main() -> None:
    """The command line."""
    reader = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    reader.add_argument("folder", type=Path)
    reader.add_argument("--seed", type=int, required=True)
    reader.add_argument("--first", type=int, default=0, help="number of the first model, to ask in pieces")
    reader.add_argument("--models", type=int, default=40, help="how many from there")
    chosen = reader.parse_args()
    tally: Counter[str] = Counter()
    for k in range(chosen.first, chosen.first + chosen.models):
        seed = 1000 * chosen.seed + k
        kept = chosen.folder / f"{seed}.json"
        if not kept.exists():
            found = asked(chosen.folder / str(seed), seed)
            kept.write_text(json.dumps(found, indent=1))
        found = json.loads(kept.read_text())
        tally[found.get("judged", "error")] += 1
        print(seed, json.dumps(found), flush=True)
    print(dict(tally))


if __name__ == "__main__":
    main()
