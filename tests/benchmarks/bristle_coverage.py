"""Do the intervals of `identify` hold the truth on an axis that another simulator moved?

    python -m tests.benchmarks.bristle_coverage [--draws 12] [--first 300] [--wander 0.005] [--plateaus] [--out FILE]

Each draw has friction up to 30 % off that of a shipped axis (outer and inner in turn), a prior that is up to 25 % off
its own, and runs by the LuGre equations integrated as good as exactly (foreign_axis.py): torque alone, from which all
seven numbers come by output error, or with `--plateaus` what `sliding` and `presliding` record. With `--wander` the
level of the friction wanders by so much, rms, with a memory of 5 s. An interval of 95 % should hold the truth in 95 of
100, and as often lie above it as below. Draws that FILE (.jsonl) holds are not made again.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

import numpy as np

from gimbal_hil.knowledge.identification import LUGRE_NAMES, friction_of, identify_axis
from sim_backend.model import AntennaModel, model_from_document, shipped_model
from tests.identification.foreign_axis import AXIS, ForeignAxis, bending_logs, torque_logs
from tests.identification.one_axis_rig import ENCODER_STEP

DRAWN_WITHIN, PRIOR_OFF_BY = 0.3, 0.25
#: kg m2; the shipped antenna's, level
INERTIAS = {"outer": 0.5, "inner": 0.07}


def model_of(values: np.ndarray, inertia: float) -> AntennaModel:
    """A model of the axis with these LuGre numbers."""
    friction = dict(zip(LUGRE_NAMES, values.tolist(), strict=True))
    axis = {"body": {"inertia": {"zz": inertia}}, "friction": friction, "encoder": {"step": ENCODER_STEP}}
    document = {"schema": 1, "name": "foreign", "kind": "rotary", "plant_step_s": 1e-4, "axes": {AXIS: axis}}
    return model_from_document(document, "foreign")


def off_by(values: np.ndarray, within: float, rng: np.random.Generator) -> np.ndarray:
    """The numbers, each off by up to a share; break-away stays above Coulomb."""
    found = values * rng.uniform(1.0 - within, 1.0 + within, len(values))
    found[0] = found[1] + (values[0] - values[1]) * rng.uniform(1.0 - within, 1.0 + within)
    return found


def draw(seed: int, wander: float, plateaus: bool) -> dict[str, Any]:
    """One draw: what every interval says of the truth, and what was found fault with."""
    rng = np.random.default_rng(seed)
    like = ("outer", "inner")[seed % 2]
    start, inertia = friction_of(shipped_model(), like), INERTIAS[like]
    truth = off_by(start.values(), DRAWN_WITHIN, rng)
    prior = model_of(off_by(truth, PRIOR_OFF_BY, rng), inertia)
    axis = ForeignAxis(start.with_values(LUGRE_NAMES, truth), inertia, wander, seed=seed)
    logs = bending_logs(axis) if plateaus else torque_logs(axis)
    found = identify_axis(logs, prior, AXIS, seed)
    numbers = {
        e.name: {"true": true, "value": e.fitted, "low": e.interval.low, "high": e.interval.high}
        for e, true in zip(found.estimates, truth.tolist(), strict=False)
    }
    return {
        "seed": seed,
        "wander": wander,
        "plateaus": plateaus,
        "numbers": numbers,
        "findings": [one.rule for one in found.findings],
    }


def report(draws: list[dict[str, Any]]) -> str:
    """The figures as text."""
    lines = [f"{'':<19}{'held':>9}{'too high':>10}{'error %':>9}{'half width %':>14}{'worst':>8} (half widths)"]
    for name in LUGRE_NAMES:
        known = [d["numbers"][name] for d in draws if np.isfinite(d["numbers"][name]["value"])]
        if not known:
            continue
        off = [(n["value"] - n["true"]) for n in known]
        half = [0.5 * (n["high"] - n["low"]) for n in known]
        holds = sum(n["low"] <= n["true"] <= n["high"] for n in known)
        high = sum(one > 0.0 for one in off)
        share = 100.0 * np.median([abs(o) / n["true"] for o, n in zip(off, known, strict=True)])
        wide = 100.0 * np.median([h / n["true"] for h, n in zip(half, known, strict=True)])
        worst = max((o / h for o, h in zip(off, half, strict=True)), key=abs)
        counts = f"{f'{holds}/{len(known)}':>9}{f'{high}/{len(known)}':>10}"
        lines.append(f"{name:<19}{counts}{share:>9.3f}{wide:>14.3f}{worst:>+8.2f}")
    fired = sum("stiffness_disagrees" in d["findings"] for d in draws)
    lines.append(f"stiffness_disagrees: {fired} of {len(draws)}")
    return "\n".join(lines)


def main() -> None:
    """See the module."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--draws", type=int, default=12)
    parser.add_argument("--first", type=int, default=300, help="seed of the first draw")
    parser.add_argument("--wander", type=float, default=0.0, help="rms share by which the friction level wanders")
    parser.add_argument("--plateaus", action="store_true", help="plateaus under a loop, loops and pulses")
    parser.add_argument("--out", type=Path, help="keeps every draw, one a line")
    asked = parser.parse_args()
    kept = asked.out.read_text().splitlines() if asked.out is not None and asked.out.exists() else []
    alike = {"wander": asked.wander, "plateaus": asked.plateaus}
    draws = [one for line in kept if alike.items() <= (one := json.loads(line)).items()]
    for seed in range(asked.first, asked.first + asked.draws):
        if seed in {one["seed"] for one in draws}:
            continue
        draws.append(draw(seed, asked.wander, asked.plateaus))
        if asked.out is not None:
            with asked.out.open("a") as file:
                file.write(json.dumps(draws[-1]) + "\n")
        print(f"seed {seed}: {', '.join(draws[-1]['findings']) or 'nothing found fault with'}", flush=True)
    print(report(draws))


if __name__ == "__main__":
    main()
