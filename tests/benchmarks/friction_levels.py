"""What following the levels of friction is worth, row by row: antennas whose friction is not the model's.

python -m tests.benchmarks.friction_levels --seed 7 --seeds 3
"""

from __future__ import annotations

import argparse
import statistics

from gimbal_hil.pointing.arena import Scenario, Trial, controller_settings, load_scenarios, run_trial
from sim_backend.model import AntennaModel, shipped_model
from sim_backend.shipped import shipped_file

#: condition: times the model's sliding and viscous friction, and by what share every number of the model is off
CONDITIONS: dict[str, tuple[float, float, float]] = {
    "model is right": (1.0, 1.0, 0.0),
    "-40 degC, grease alone": (1.0, 6.05, 0.0),
    "-40 degC, sliding too": (1.6, 6.05, 0.0),
    "-10 degC, sliding too": (1.3, 2.46, 0.0),
    "50 degC, sliding too": (0.9, 0.41, 0.0),
    "85 degC, sliding too": (0.7, 0.14, 0.0),
    "sliding x 1.3": (1.3, 1.0, 0.0),
    "sliding x 0.7": (0.7, 1.0, 0.0),
    "model 30 % off": (1.0, 1.0, 0.3),
}
ROWS = ("reversals: 0.02", "reversals: 0.2 rad", "learning", "slow: 0.01")
#: a small reversal is given the time that a window takes
SETTLED_S = 60.0


def scenarios() -> list[Scenario]:
    """Those of reversals and slow motion, judged after a minute."""
    files = sorted(shipped_file("scenarios").glob("*.yaml"))
    found = [one for path in files for one in load_scenarios(path)]
    kept = [one for one in found if one.name.startswith(ROWS)]
    return [one.model_copy(update={"duration_s": SETTLED_S + 30.0, "settle_s": SETTLED_S}) for one in kept]


def antenna(sliding: float, viscous: float) -> AntennaModel:
    """The realistic antenna with so many times its friction."""
    model = shipped_model("realistic")
    for axis in model.axes:
        times = {"breakaway": sliding, "coulomb": sliding, "viscous": viscous}
        model = model.with_numbers(
            axis, {f"friction.{key}": by * model.number(axis, f"friction.{key}") for key, by in times.items()}
        )
    return model


def main() -> None:
    """Print the table."""
    options = argparse.ArgumentParser()
    options.add_argument("--seed", type=int, required=True, help="first seed")
    options.add_argument("--seeds", type=int, default=3)
    options.add_argument("--only", default="", help="words of a condition")
    options.add_argument("--controllers", nargs="+", default=["tuned", "levels"])
    chosen = options.parse_args()
    print("| scenario | antenna | " + " | ".join(f"{name}, urad" for name in chosen.controllers) + " | ratios |")
    print("|---" * (3 + len(chosen.controllers)) + "|")
    for condition, (sliding, viscous, wrong) in CONDITIONS.items():
        if chosen.only not in condition:
            continue
        model = antenna(sliding, viscous)
        for scenario in scenarios():
            found: list[list[float]] = []
            for name in chosen.controllers:
                settings = controller_settings(name)
                seeds = range(chosen.seed, chosen.seed + chosen.seeds)
                trials = [Trial(scenario, name, settings, "realistic", model, seed, wrong=wrong) for seed in seeds]
                found.append([1e6 * run_trial(trial).los_rms for trial in trials])
            means = " | ".join(f"{statistics.fmean(values):.3f}" for values in found)
            ratios = ", ".join(f"{last / first:.2f}" for first, last in zip(found[0], found[-1], strict=True))
            print(f"| {scenario.name} | {condition} | {means} | {ratios} |", flush=True)


if __name__ == "__main__":
    main()
