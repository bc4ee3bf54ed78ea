"""How well friction is recovered on the virtual antenna with its default sensors, over seeded repeats.

    python -m tests.benchmarks.friction_recovery --repeats 40 [--short] [--workers N | --dask ADDRESS]
        [--out recovery.jsonl]

Each repeat has noise of its own, runs sliding and presliding on both axes, and identifies with a *wrong* prior: every
friction number of the model it is given is off by up to 30 %, so that nothing is recovered by being known. Finished
repeats stay in the file and are not made again. Printed for each axis and parameter: bias, scatter, share of 95 %
intervals that hold the truth, verdicts, and the error of the thesis' own recovery of the same numbers (its tables 4.7
to 4.10).
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, as_completed, wait
from pathlib import Path
from typing import Any

import numpy as np

from gimbal_hil.knowledge.executor import WorkExecutor, open_executor

AXES = ("outer", "inner")
NAMES = ("breakaway", "coulomb", "stribeck_velocity", "viscous", "shape", "sigma0", "sigma1")
WRONG_BY = 0.3
FIRST_SEED = 1000


def repeat(seed: int, short: bool) -> dict[str, Any]:
    """One repeat: experiments, identification, and what came out of it."""
    from gimbal_hil.knowledge.experiments.conducting import conduct
    from gimbal_hil.knowledge.experiments.sequences import SequenceOptions, breakaway_torques, build_experiment
    from gimbal_hil.knowledge.identification import Log, friction_of, identify_axis
    from gimbal_hil.knowledge.identification.reading import read_logs
    from gimbal_hil.loop.settings import shipped_settings
    from sim_backend.model import shipped_model

    settings, truth = shipped_settings(), shipped_model()
    random = np.random.default_rng(seed)
    prior = truth
    for axis in AXES:
        factors = random.uniform(1.0 - WRONG_BY, 1.0 + WRONG_BY, len(NAMES))
        # break-away stays above Coulomb friction: both are off by one factor, and so is the bump between them by
        # another
        level, bump = factors[:2]
        values = friction_of(truth, axis).values() * factors
        values[1] = level * friction_of(truth, axis).static.coulomb
        values[0] = values[1] + bump * (
            friction_of(truth, axis).static.breakaway - friction_of(truth, axis).static.coulomb
        )
        numbers = {f"friction.{name}": value for name, value in zip(NAMES, values.tolist(), strict=True)}
        prior = prior.with_numbers(axis, numbers)
    result: dict[str, Any] = {"seed": seed, "short": short, "experiments_s": 0.0, "identify_s": 0.0}
    for number, axis in enumerate(AXES):
        # one axis after the other in this process: with both at once `conduct` would start one of its own
        options = SequenceOptions(settings.rate_hz, (axis,), short=short, breakaway_nm=breakaway_torques(truth))
        begun = time.process_time()
        with tempfile.TemporaryDirectory() as folder:
            logs: list[Log] = []
            for place, name in enumerate(("sliding", "presliding")):
                outcome = conduct(
                    build_experiment(name, options), settings, truth, 4 * seed + 2 * number + place, Path(folder) / name
                )
                logs += read_logs(outcome.folder, truth.axes)
            result["experiments_s"] += time.process_time() - begun
            begun = time.process_time()
            found = identify_axis(logs, prior, axis, seed)
            result["identify_s"] += time.process_time() - begun
        result[axis] = {
            e.name: {"value": e.value, "low": e.interval.low, "high": e.interval.high, "verdict": e.verdict.value}
            for e in found.estimates
        }
    return result


def repeats(executor: WorkExecutor, seeds: Sequence[int], short: bool, at_once: int) -> Iterator[dict[str, Any]]:
    """The repeats of all seeds, as they get done; no more than `at_once` are asked for, or one process would do all
    before it answers.
    """
    under_way: set[Future[dict[str, Any]]] = set()
    for seed in seeds:
        under_way.add(executor.submit(repeat, seed, short))
        if len(under_way) == at_once:
            done, under_way = wait(under_way, return_when=FIRST_COMPLETED)
            yield from (one.result() for one in done)
    yield from (one.result() for one in as_completed(under_way))


def report(results: list[dict[str, Any]]) -> str:
    """The figures as text."""
    from gimbal_hil.knowledge.identification import friction_of
    from gimbal_hil.proof.thesis.printed import FRICTION_RECOVERED
    from sim_backend.model import shipped_model

    run_s, identify_s = (float(np.median([r[part] for r in results])) for part in ("experiments_s", "identify_s"))
    lines = [
        f"{len(results)} repeats; processor seconds each (median): {run_s:.0f} to run both axes, {identify_s:.0f} to "
        "identify"
    ]
    covered = total = 0
    for axis in AXES:
        lines.append(
            f"{axis:<19}{'true':>10}{'bias %':>9}{'scatter %':>11}{'worst %':>9}{'covered':>10}  "
            f"{'identified':<12}thesis' error %"
        )
        for place, (name, truth) in enumerate(
            zip(NAMES, friction_of(shipped_model(), axis).values().tolist(), strict=True)
        ):
            found = [r[axis][name] for r in results]
            errors = np.array([100.0 * (f["value"] / truth - 1.0) for f in found])
            holds = sum(f["low"] <= truth <= f["high"] for f in found)
            sure = sum(f["verdict"] == "identified" for f in found)
            covered, total = covered + holds, total + len(found)
            scatter = float(np.std(errors, ddof=1)) if len(errors) > 1 else float("nan")
            worst = float(np.max(np.abs(errors)))
            lines.append(
                f"{name:<19}{truth:>10.5g}{np.mean(errors):>+9.3f}{scatter:>11.3f}{worst:>9.3f}"
                f"{f'{holds}/{len(found)}':>10}  "
                f"{f'{sure}/{len(found)}':<12}{100.0 * (FRICTION_RECOVERED[axis][place] / truth - 1.0):+.1f}"
            )
    lines.append(f"intervals that hold the truth: {covered} of {total} ({100.0 * covered / total:.1f} %)")
    return "\n".join(lines)


def main() -> None:
    """See the module."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--repeats", type=int, default=40)
    parser.add_argument(
        "--first", type=int, default=FIRST_SEED, help="seed of the first repeat, to share the repeats out by hand"
    )
    parser.add_argument("--short", action="store_true", help="the short variants of both sequences")
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--dask", metavar="ADDRESS", help="repeat on a Dask cluster instead")
    parser.add_argument("--out", type=Path, default=Path("friction_recovery.jsonl"))
    asked = parser.parse_args()
    known = [json.loads(line) for line in asked.out.read_text().splitlines()] if asked.out.exists() else []
    results = [
        r for r in known if r["short"] == asked.short and r["seed"] in range(asked.first, asked.first + asked.repeats)
    ]
    open_seeds = sorted(set(range(asked.first, asked.first + asked.repeats)) - {r["seed"] for r in results})
    with open_executor(asked.workers, asked.dask) as executor, asked.out.open("a") as file:
        at_once = len(open_seeds) if asked.dask else asked.workers
        for result in repeats(executor, open_seeds, asked.short, at_once):
            results.append(result)
            file.write(json.dumps(result) + "\n")
            file.flush()
            print(f"{len(results)} of {asked.repeats}: seed {result['seed']}", flush=True)
    print(report(results))


if __name__ == "__main__":
    main()
