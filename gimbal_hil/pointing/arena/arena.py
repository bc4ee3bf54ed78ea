"""Scenarios x antennas x controllers x seeds, run where the executor has room, and put side by side."""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable, Sequence
from concurrent.futures import as_completed
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.errors import BadInputError
from gimbal_hil.knowledge.executor import open_executor
from gimbal_hil.knowledge.tuning import PredictedJoint
from gimbal_hil.loop.settings import DaemonSettings, load_settings
from gimbal_hil.pointing.arena.controllers import about, controller_settings, law_of
from gimbal_hil.pointing.arena.scenarios import Scenario
from gimbal_hil.pointing.arena.trial import Trial, TrialOutcome, run_trial
from sim_backend.model import AntennaModel, model_named


@dataclass(frozen=True)
class Entrant:
    """A controller with its name, and what it is."""

    name: str
    settings: DaemonSettings
    text: str
    #: what closes its loops in place of the configuration: see `law_of`
    law: NDArray[np.float64] | tuple[PredictedJoint, ...] | None = None


@dataclass(frozen=True)
class Spread:
    """Mean of a figure over the seeds, and its standard deviation; that is 0 of a single seed."""

    mean: float
    deviation: float


@dataclass(frozen=True)
class ArenaResult:
    """Every outcome, in the order in which scenarios, antennas, controllers and seeds were given."""

    scenarios: tuple[Scenario, ...]
    antennas: tuple[str, ...]
    #: names of the axes of each antenna, the carrying one first
    axes: tuple[tuple[str, str], ...]
    entrants: tuple[Entrant, ...]
    seeds: int
    outcomes: tuple[TrialOutcome, ...]

    def named(self, title: str, antenna: str) -> str:
        """A title in which `{0}` and `{1}` stand for the axes, with the names that this antenna has for them."""
        return title.format(*self.axes[self.antennas.index(antenna)])

    def of(self, scenario: str, antenna: str, controller: str) -> list[TrialOutcome]:
        """The outcomes of one row's cell, one a seed."""
        wanted = (scenario, antenna, controller)
        return [one for one in self.outcomes if (one.scenario, one.antenna, one.controller) == wanted]

    def tripped(self, scenario: str, antenna: str, controller: str) -> str:
        """Why the first trial that did not end by itself stopped; empty where all did."""
        return next((one.tripped for one in self.of(scenario, antenna, controller) if one.tripped), "")

    def spread(
        self, scenario: str, antenna: str, controller: str, figure: Callable[[TrialOutcome], float]
    ) -> Spread | None:
        """A figure over the seeds; None where a trial tripped or the scenario does not ask for it."""
        values = [figure(one) for one in self.of(scenario, antenna, controller)]
        if not values or any(math.isnan(value) for value in values):
            return None
        if any(math.isinf(value) for value in values):
            return Spread(math.inf, 0.0)
        return Spread(statistics.fmean(values), statistics.stdev(values) if len(values) > 1 else 0.0)

    def worst(self, antenna: str, controller: str) -> tuple[str, float] | None:
        """The scenario, steps apart, in which a controller holds the line of sight worst, and its rms (rad); a trip is
        infinite. None without such a scenario.
        """
        found = [
            (one.name, math.inf if spread is None else spread.mean)
            for one in self.scenarios
            if one.axis is None
            for spread in [self.spread(one.name, antenna, controller, lambda outcome: outcome.los_rms)]
        ]
        return max(found, key=lambda pair: pair[1], default=None)

    def rows(self) -> list[dict[str, object]]:
        """Every outcome as plain values, for JSON; angles in rad."""
        return [
            {
                "scenario": one.scenario,
                "antenna": one.antenna,
                "controller": one.controller,
                "seed": one.seed,
                "tripped": one.tripped,
                "los_rms_rad": _plain(one.los_rms),
                "rms_rad": [_plain(value) for value in one.rms],
                "reversal_peak_rad": [_plain(value) for value in one.reversal_peak],
                "overshoot_percent": _plain(one.overshoot),
                "settling_s": _plain(one.settling_s),
                "torque_rms_nm": [_plain(value) for value in one.torque_rms],
            }
            for one in self.outcomes
        ]


def _plain(value: float) -> float | None:
    return value if math.isfinite(value) else None


def entrants(names: Sequence[str]) -> tuple[Entrant, ...]:
    """Controllers by name, or configurations by file, called as their files and, where two are called alike, as more
    of their paths; BadInputError for what is neither, and for what is given twice.
    """
    return tuple(
        Entrant(called, load_settings(Path(name)), f"The configuration {Path(name).name}.")
        if _is_file(name)
        else Entrant(called, controller_settings(name), about(name), law_of(name))
        for name, called in zip(names, _called(names), strict=True)
    )


def _is_file(name: str) -> bool:
    return name.endswith((".yaml", ".yml"))


def _called(names: Sequence[str]) -> list[str]:
    """A name of its own for each."""
    paths = [Path(name).resolve().with_suffix("").parts if _is_file(name) else (name,) for name in names]
    for parts, name in zip(paths, names, strict=True):
        if paths.count(parts) > 1:
            raise BadInputError("--controller", f"{name} is given twice", "each one once")

    def tail(parts: tuple[str, ...], length: int) -> str:
        return "/".join(parts[-length:])

    def least(parts: tuple[str, ...]) -> int:
        lengths = range(1, len(parts) + 1)
        return next((n for n in lengths if sum(tail(other, n) == tail(parts, n) for other in paths) == 1), len(parts))

    return [tail(parts, least(parts)) for parts in paths]


def run_arena(
    scenarios: Sequence[Scenario],
    antennas: Sequence[str],
    controllers: Sequence[Entrant],
    seeds: int,
    workers: int = 1,
    say: Callable[[str], None] = lambda scenario: None,
    wrong: float = 0.0,
) -> ArenaResult:
    """Run everything, the loops' models off by a share `wrong`; `say` is called with each finished
    scenario. Errors of the first seed are kept.
    """
    models: dict[str, AntennaModel] = {name: model_named(name) for name in antennas}
    trials = [
        Trial(scenario, entrant.name, entrant.settings, antenna, models[antenna], seed, seed == 1, wrong, entrant.law)
        for scenario in scenarios
        for antenna in antennas
        for entrant in controllers
        for seed in range(1, seeds + 1)
    ]
    with open_executor(workers) as executor:
        waiting = {executor.submit(run_trial, trial): place for place, trial in enumerate(trials)}
        found: dict[int, TrialOutcome] = {}
        for done in as_completed(waiting):
            found[waiting[done]] = done.result()
            say(trials[waiting[done]].scenario.name)
    return ArenaResult(
        tuple(scenarios),
        tuple(antennas),
        tuple((models[name].axes[0], models[name].axes[1]) for name in antennas),
        tuple(controllers),
        seeds,
        tuple(found[i] for i in range(len(trials))),
    )
