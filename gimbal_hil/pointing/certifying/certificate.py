"""Many drawn flights put together: shares of time with intervals, and whether every excursion was muted in time."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray

from gimbal_hil.knowledge.executor import open_executor
from gimbal_hil.pointing.certifying.flight import ERROR_STEP_RAD, FlightTask, FlownFlight, fly

Table = NDArray[np.float64]
#: flights that a worker does at once, and how many such lots wait for each worker
_AT_ONCE, _AHEAD = 10, 2
#: of intervals; resamples of the flights
CONFIDENCE, _RESAMPLES = 0.95, 2000


@dataclass(frozen=True)
class ShareInterval:
    """A share with its confidence interval."""

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class Certificate:
    """What the flights of a task showed."""

    task: FlightTask
    flights: tuple[FlownFlight, ...]
    workers: int
    took_s: float

    @property
    def acquired(self) -> ShareInterval:
        """Share of the flights that transmitted at all."""
        return of_all(sum(math.isfinite(one.acquired_s) for one in self.flights), len(self.flights))

    @property
    def within(self) -> ShareInterval:
        """Share of the time of transmission in which the true error was within the requirement."""
        return of_time([one.within_s for one in self.flights], [one.transmitting_s for one in self.flights])

    @property
    def transmitting(self) -> ShareInterval:
        """Share of the time since the first transmission in which it transmitted."""
        return of_time([one.transmitting_s for one in self.flights], [one.flown_s for one in self.flights])

    @property
    def muted_in_time(self) -> ShareInterval:
        """Share of the flights in which every excursion was muted in time."""
        return of_all(len(self.flights) - len(self.late), len(self.flights))

    @property
    def late(self) -> tuple[FlownFlight, ...]:
        """Flights with an excursion that was muted too late, the slowest first."""
        allowed = self.task.requirement.mute_within_s
        return tuple(sorted((f for f in self.flights if f.slowest_mute_s > allowed), key=lambda f: -f.slowest_mute_s))

    @property
    def keeps(self) -> bool:
        """Whether it acquired in all flights and muted in time in all."""
        return not self.late and self.acquired.value == 1.0

    @property
    def is_shown(self) -> bool:
        """Whether that many flights show it: flights that mute in time are no fewer than this share, at this
        confidence.
        """
        return self.keeps and self.muted_in_time.low >= CONFIDENCE

    def quantile_rad(self, share: float) -> float:
        """Error that was not exceeded in that share of the time of transmission; upper end of its step."""
        time_s = np.sum([one.histogram for one in self.flights], axis=0)
        if not time_s.sum():
            return math.nan
        place = int(np.searchsorted(np.cumsum(time_s), share * time_s.sum()))
        return math.inf if place >= len(time_s) - 1 else (place + 1) * ERROR_STEP_RAD

    def rows(self) -> list[dict[str, object]]:
        """Every flight as plain values, without its histogram."""
        return [
            {
                key: None if isinstance(value, float) and not math.isfinite(value) else value
                for key, value in asdict(one).items()
                if key != "histogram"
            }
            for one in self.flights
        ]


def of_all(kept: int, flights: int) -> ShareInterval:
    """A share of counted flights; Clopper and Pearson 1934."""
    from scipy.stats import beta

    side = 0.5 * (1.0 - CONFIDENCE)
    low = 0.0 if kept == 0 else float(beta.ppf(side, kept, flights - kept + 1))
    high = 1.0 if kept == flights else float(beta.ppf(1.0 - side, kept + 1, flights - kept))
    return ShareInterval(kept / flights, low, high)


def of_time(part_s: Sequence[float], whole_s: Sequence[float]) -> ShareInterval:
    """A share of time over all flights; the interval by resampling whole flights, because seconds of one flight hang
    together.
    """
    part, whole = np.array(part_s), np.array(whole_s)
    if not whole.sum():
        return ShareInterval(math.nan, math.nan, math.nan)
    weights = np.random.default_rng(1).multinomial(len(part), np.full(len(part), 1.0 / len(part)), _RESAMPLES)
    drawn = (weights @ part) / np.maximum(weights @ whole, 1e-9)
    low, high = np.quantile(drawn, (0.5 * (1.0 - CONFIDENCE), 0.5 * (1.0 + CONFIDENCE)))
    return ShareInterval(float(part.sum() / whole.sum()), float(low), float(high))


def certified(
    task: FlightTask,
    flights: int,
    first_seed: int,
    workers: int,
    now_s: Callable[[], float],
    done: Callable[[list[FlownFlight]], None],
    flown: Sequence[FlownFlight] = (),
) -> Certificate:
    """Fly all of them, seeds from the first on, but those that are flown already; `done` gets flights as they end."""
    begun = now_s()
    seeds = range(first_seed, first_seed + flights)
    found = [one for one in flown if one.seed in seeds]
    missing = sorted(set(seeds) - {one.seed for one in found})
    waiting = deque(tuple(missing[k : k + _AT_ONCE]) for k in range(0, len(missing), _AT_ONCE))
    with open_executor(workers) as executor:
        shared, running = executor.share(task), set[Future[list[FlownFlight]]]()
        while waiting or running:
            while waiting and len(running) < _AHEAD * workers:
                running.add(executor.submit(fly_some, shared, waiting.popleft()))
            ended, running = wait(running, return_when=FIRST_COMPLETED)
            for one in ended:
                found += one.result()
                done(one.result())
    return Certificate(task, tuple(sorted(found, key=lambda one: one.seed)), workers, now_s() - begun)


def fly_some(task: FlightTask, seeds: Sequence[int]) -> list[FlownFlight]:
    """Flights of these seeds."""
    return [fly(task, seed) for seed in seeds]
