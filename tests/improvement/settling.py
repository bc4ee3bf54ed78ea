"""Evidence per second of motions made for a question, against the best entry of the menu, and how many of the questions
one run settles: `python -m tests.improvement.settling --seeds 9100:9106 --out FILE`.

A pair is a cause hidden in the shipped antenna and a rival that a line of the table of runs says it is told from, drawn
from the seed; two surveys of ten seconds over little travel leave it ambiguous. The motion that is then made runs on
the hidden antenna, and the same search with that log beside the others says whether the question is settled: a verdict
that names the hidden cause and nothing else.
"""

from __future__ import annotations

import os

# before numpy is loaded, as in the product: threads only wait for one another on small matrices
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import json
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import permutations
from pathlib import Path

import numpy as np

from firmware_protocol.errors import BadInputError
from firmware_protocol.json_object import Json
from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.discrepancy import Kind, Request, Result, diagnose, verdict_of
from gimbal_hil.knowledge.executor import open_executor
from gimbal_hil.knowledge.experiments import Experiment
from gimbal_hil.knowledge.experiments.sequences import SequenceOptions, breakaway_torques, build_experiment
from gimbal_hil.knowledge.experiments.sequences.reference_motion import motion_experiment
from gimbal_hil.knowledge.experiments.sequences.survey import reference
from gimbal_hil.knowledge.improvement import budgets_of
from gimbal_hil.knowledge.improvement.choosing import Pair, menu_of, open_pairs, question_of, separation_of
from gimbal_hil.knowledge.improvement.design import Design, DesignTask, designed
from gimbal_hil.knowledge.improvement.motion import LapMotion, experiment_of_motion
from gimbal_hil.knowledge.improvement.rehearsal import rehearse
from gimbal_hil.loop.settings import DaemonSettings, shipped_settings
from sim_backend.effects import CATALOGUE, RUNS
from sim_backend.model import AntennaModel, shipped_model
from tests.improvement.antennas import Parameters, effects, gaps_in_floors

#: seconds of each of the two logs, and the share of a survey's travel: so little that more than the closest pairs stay
#: open
LOG_S, SHARE = 10.0, 0.2
#: floors that the hidden cause makes on a survey at first; how often it is made smaller, and by what
FLOORS, TIMES, SMALLER = 6.0, 2, 0.4
BUDGET_S = 900.0


@dataclass(frozen=True)
class Open:
    """A question as two surveys of ten seconds of an antenna leave it, and the cause that is hidden in that."""

    hidden: tuple[str, str]
    antenna: AntennaModel
    surveys: tuple[SignalsTable, SignalsTable]
    result: Result
    pair: Pair
    seed: int

    def settled_by(self, table: SignalsTable) -> tuple[bool, str]:
        """Whether a search with one more log names what is hidden; its verdict in short."""
        request = self.result.request
        found = diagnose(Request(shipped_model(), (self.surveys[0], table), (self.surveys[1],), only=request.only))
        names = [one.standing.label for one in found.told]
        kind = verdict_of(found).kind
        told = " ".join(f"{name} on {axis}" for name, axis in names)
        return kind is Kind.NAMED and names == [self.hidden], f"{kind.value}: {told}"


def pairs(rng: np.random.Generator) -> list[tuple[str, str, str]]:
    """(hidden, rival, axis) of every line of the table of runs that the antenna can make, in a drawn order: of those
    that act through the same variable on the same sensor, since others stay open nowhere.
    """
    drawn = effects("inner", rng, shipped_model())
    found = []
    for run in RUNS:
        if run.sequence is not None:
            names = [name for name, effect in CATALOGUE.items() if run in effect.separated_by and name in drawn]
            alike = [two for two in permutations(names, 2) if _alike(*two)]
            found += [(*two, axis) for two in alike for axis in ("outer", "inner")]
    unique = list(dict.fromkeys(found))
    return [unique[i] for i in rng.permutation(len(unique))]


def _alike(one: str, other: str) -> bool:
    same_sensor = one.startswith("gyro_") == other.startswith("gyro_")
    return same_sensor and bool(CATALOGUE[one].acts_through & CATALOGUE[other].acts_through)


def opened(hidden: str, rival: str, axis: str, seed: int, settings: DaemonSettings) -> Open | None:
    """The question with the largest size of the cause that two surveys leave ambiguous; None where there is none."""
    ways = effects(axis, np.random.default_rng(seed), shipped_model())
    if hidden not in ways or rival not in ways:
        return None
    with suppress(BadInputError):
        # of a size that makes the gap, a cause may be beyond its bounds
        return _opened(hidden, rival, axis, ways[hidden], seed, settings)
    return None


def _opened(
    hidden: str, rival: str, axis: str, way: Callable[[float], Parameters], seed: int, settings: DaemonSettings
) -> Open | None:
    alone = shipped_model().with_effect(hidden, axis, way(1.0))
    size = FLOORS / max(1.0, float(np.max(gaps_in_floors(shipped_model(), surveyed(alone, 0, settings, seed)))))
    for _ in range(TIMES):
        antenna = shipped_model().with_effect(hidden, axis, way(size))
        surveys = surveyed(antenna, 0, settings, seed), surveyed(antenna, 1, settings, seed)
        result = diagnose(Request(shipped_model(), surveys[:1], surveys[1:], only=(hidden, rival)))
        kind = verdict_of(result).kind
        both = {(hidden, axis), (rival, axis)}
        pair = next((one for one in open_pairs(result, ()) if set(one.names) == both), None)
        if kind is Kind.AMBIGUOUS and pair is not None:
            return Open((hidden, axis), antenna, surveys, result, pair, seed)
        if kind is not Kind.NAMED:
            return None
        size *= SMALLER
    return None


def surveyed(antenna: AntennaModel, number: int, settings: DaemonSettings, seed: int) -> SignalsTable:
    """A short survey of an antenna over little of its travel."""
    options = SequenceOptions(settings.rate_hz, every=1)
    references = options.by_axis(tuple(SHARE * reference(place, LOG_S, number) for place in (0, 1)))
    motion = motion_experiment("survey", "Little motion of both axes", options, references, "")
    return measured(motion, settings, antenna, seed + number)


def measured(experiment: Experiment, settings: DaemonSettings, antenna: AntennaModel, seed: int) -> SignalsTable:
    """What an experiment measures on an antenna."""
    table = rehearse(experiment, settings, antenna, seed).table
    assert table is not None
    return table


def menu(one: Open, task: DesignTask) -> list[tuple[Design, Experiment]]:
    """What entries of the menu are expected to show, most evidence a second first."""
    settings, found, no_motion = task.settings, [], LapMotion(())
    for option in menu_of(one.pair, done=()):
        known = breakaway_torques(task.question.model)
        options = SequenceOptions(settings.rate_hz, (option.axis,), short=True, every=1, breakaway_nm=known)
        experiment = build_experiment(option.sequence, options)
        rehearsal = rehearse(experiment, settings, task.question.model)
        refused = task.budgets.refusal(experiment, rehearsal, settings.rate_hz, 0.0)
        if rehearsal.table is not None and refused is None:
            shown, seconds = separation_of(task.question, rehearsal.table), experiment.duration_s(settings.rate_hz)
            found.append((Design(no_motion, shown.expected(), shown.needed(), seconds), experiment))
    return sorted(found, key=lambda entry: -entry[0].per_second)


def compared(one: Open, settings: DaemonSettings, workers: int, generations: int) -> Json:
    """The best of the menu beside a motion that was made for the pair."""
    task = DesignTask(question_of(one.result, one.pair), settings, budgets_of(settings, BUDGET_S, 9, {}, {}))
    names = [f"{name} on {axis}" for name, axis in one.pair.names]
    row: Json = {"seed": one.seed, "hidden": " on ".join(one.hidden), "best": names[0], "rival": names[1]}
    entries = menu(one, task)
    began, processor = time.monotonic(), time.process_time()
    with open_executor(workers) as executor:
        design = designed(task, executor, seed=one.seed, generations=generations)
    row |= {"wall_s": round(time.monotonic() - began, 1), "processor_s": round(time.process_time() - processor, 1)}
    if entries:
        best, experiment = entries[0]
        row["menu"] = _told(best, experiment.name)
    if design is not None:
        experiment = experiment_of_motion(design.motion, "settles it", settings, task.budgets)
        table = measured(experiment, settings, one.antenna, one.seed + 100)
        settled, verdict = one.settled_by(table)
        shown = replace(design, expected=separation_of(task.question, table).expected())
        row["made"] = _told(design, experiment.name) | {"shown_per_s": round(shown.per_second, 3)}
        row |= {"settled": settled, "verdict": verdict}
    return row


def _told(design: Design, name: str) -> Json:
    """What is expected of a run, in squared floors."""
    seconds, expected, per_s = round(design.duration_s, 1), round(design.expected, 1), round(design.per_second, 3)
    return {"run": name, "seconds": seconds, "expected": expected, "per_s": per_s, "needed": round(design.needed, 1)}


def questions(seed: int, settings: DaemonSettings, wanted: tuple[str, str, str] | None) -> Iterator[Open]:
    """The first pair of a seed's order that can be opened; or the one that is wanted."""
    for hidden, rival, axis in [wanted] if wanted else pairs(np.random.default_rng(seed)):
        print(f"{hidden} beside {rival} on {axis}", flush=True)
        one = opened(hidden, rival, axis, seed, settings)
        if one is not None:
            yield one
            return


def main(arguments: list[str]) -> int:
    """Compare one pair for each seed; rows go to --out as JSON lines."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", default="9100:9106", help="FIRST:LAST, the last left out")
    parser.add_argument("--pair", help="HIDDEN,RIVAL,AXIS in place of a drawn one")
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--generations", type=int, default=9)
    parser.add_argument("--out", type=Path, required=True)
    asked = parser.parse_args(arguments)
    settings = shipped_settings()
    wanted = tuple(asked.pair.split(",")) if asked.pair else None
    with asked.out.open("a") as out:
        for seed in range(*map(int, asked.seeds.split(":"))):
            for one in questions(seed, settings, wanted):
                row = compared(one, settings, asked.workers, asked.generations)
                print(json.dumps(row), flush=True)
                print(json.dumps(row), file=out, flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
