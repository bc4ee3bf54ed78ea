"""What a search for missing effects costs: against the length of the data, and against the number of candidates."""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gimbal_hil.data.signals import SignalsTable, read_signals
from gimbal_hil.knowledge.discrepancy import (
    FitRule,
    Hypothesis,
    Request,
    Twin,
    Weighing,
    diagnose,
    families,
    fit,
    record_of,
    respond,
    scored_band,
    verdict_of,
)
from gimbal_hil.knowledge.experiments import conduct
from gimbal_hil.knowledge.experiments.sequences import SequenceOptions, survey_motion
from gimbal_hil.loop.settings import shipped_settings
from gimbal_hil.proof.bench.speed import SINES, sines
from sim_backend.model import shipped_model

LENGTHS_S = (15.0, 30.0, 60.0, 120.0)
SHARES = (0.25, 0.5, 0.75, 1.0)
#: length of the data on which candidates are counted, s
COUNTED_S = 60.0
_HIDDEN = {"amplitude": 0.03, "order": 12.0, "phase": 0.7}


@dataclass(frozen=True)
class Cost:
    """One point: how much there was (s of data, or candidates), wall time (s), processor time of all processes (s), and
    that in sines.

    Processor time, because wall time depends on what else the machine does; sines of the same moments, because its
    speed varies.
    """

    amount: float
    wall_s: float
    processor_s: float
    million_sines: float
    verdict: str = ""


@dataclass(frozen=True)
class SearchFigures:
    """Both series; `exponent` of a power law through each (1: linear)."""

    workers: int
    by_length: tuple[Cost, ...]
    by_candidates: tuple[Cost, ...]

    @property
    def exponents(self) -> tuple[float, float]:
        """Slopes of log cost over log amount, cost in sines."""
        return _slope(self.by_length), _slope(self.by_candidates)


def search_figures(workers: int, repeats: int, say: Callable[[str], None] = lambda name: None) -> SearchFigures:
    """Measure both on a ripple hidden in the virtual antenna; whole searches on `workers` processes, candidates in this
    one.
    """
    with tempfile.TemporaryDirectory(prefix="gimbal-hil-") as name:
        folder = Path(name)
        _whole(folder, LENGTHS_S[0], workers)  # compiles
        lengths = []
        for seconds in LENGTHS_S:
            say(f"a whole search on {seconds:g} s of both axes")
            lengths.append(_whole(folder, seconds, workers))
        say("candidates")
        return SearchFigures(workers, tuple(lengths), _candidates(folder, max(1, repeats // 3)))


def _whole(folder: Path, seconds: float, workers: int) -> Cost:
    """A whole diagnosis: search on `seconds` of data with the whole catalogue, judged on half as much of another
    motion.
    """
    measured, judged = _surveyed(folder, seconds, 0), _surveyed(folder, max(LENGTHS_S[0], seconds / 2.0), 1)
    before = _sines_s()
    began, spent = time.perf_counter(), _processor_s()
    verdict = verdict_of(diagnose(Request(shipped_model(), (measured,), (judged,)), workers=workers)).document
    wall_s, processor_s = time.perf_counter() - began, _processor_s() - spent
    named = ", ".join(f"{effect['name']} on {effect['axis']}" for effect in verdict["effects"])
    return _cost(seconds, wall_s, processor_s, before, named or str(verdict["verdict"]))


def _candidates(folder: Path, repeats: int) -> tuple[Cost, ...]:
    """Responses of a growing share of the catalogue, cheap and dear ones in the same mixture; the best of some
    repeats.
    """
    model = shipped_model()
    table = _surveyed(folder, COUNTED_S, 0)
    twin = Twin(model, (record_of(table, model, scored_band((table,)), "measured"),))
    floor = np.full(len(twin.channels), 1e-3)
    stated = fit(twin, Hypothesis(), floor, Weighing((1.0,) * len(floor), 1.0), FitRule(0))
    catalogue = [family for axis in model.axes for family in families(twin, axis)]
    catalogue.sort(key=lambda family: (family.ripple is not None, len(family.starts)))
    found = []
    for share in SHARES:
        places = np.linspace(0, len(catalogue) - 1, round(share * len(catalogue))).round().astype(int)
        chosen = [catalogue[i] for i in places]
        costs = []
        for _ in range(repeats):
            before = _sines_s()
            began, spent = time.perf_counter(), _processor_s()
            for family in chosen:
                respond(twin, stated, floor, family)
            costs.append(_cost(len(chosen), time.perf_counter() - began, _processor_s() - spent, before))
        found.append(min(costs, key=lambda cost: cost.million_sines))
    return tuple(found)


def _surveyed(folder: Path, seconds: float, number: int) -> SignalsTable:
    """A survey of both axes of the antenna with the hidden ripple; made once."""
    settings, model = shipped_settings(), shipped_model()
    run = folder / f"survey_{number}_{seconds:g}"
    if not run.exists():
        hidden = model.with_effect("cogging", "outer", _HIDDEN)
        conduct(survey_motion(SequenceOptions(settings.rate_hz), number, seconds), settings, hidden, 1 + number, run)
    table = read_signals(run, model.axes)
    first = round(1.0 / table.period_s)
    return table.rows(first, min(len(table), round(seconds / table.period_s)))


def _sines_s() -> float:
    """Processor seconds of a million sines now, the best of three."""
    times = []
    for _ in range(3):
        began = _processor_s()
        for _ in range(20_000_000 // SINES):
            sines()
        times.append((_processor_s() - began) / 20.0)
    return min(times)


def _processor_s() -> float:
    """Processor time of this process and of its children that have ended."""
    return sum(os.times()[:4])


def _cost(amount: float, wall_s: float, processor_s: float, sines_before_s: float, verdict: str = "") -> Cost:
    return Cost(amount, wall_s, processor_s, processor_s / (0.5 * (sines_before_s + _sines_s())), verdict)


def _slope(costs: tuple[Cost, ...]) -> float:
    x, y = np.log([c.amount for c in costs]), np.log([c.million_sines for c in costs])
    return float(np.polyfit(x, y, 1)[0])
