"""One drawn flight: aircraft's motion, errors of its navigation and a direction, held by the whole loop against the
virtual antenna and judged by the truth.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gimbal_hil.loop.host import HostState, program_of
from gimbal_hil.loop.settings import DaemonSettings
from gimbal_hil.pointing.arena import MOTION_ROW_HZ, Manoeuvre, Turbulence, between, boresight
from gimbal_hil.pointing.certifying.navigation import TOLD_HZ, NavigationErrors
from gimbal_hil.pointing.following import Target, Way, as_base, in_base, joints_seen, way_of
from gimbal_hil.realtime.lockstep import SILENT, ErringNavigation, FlightPath, FlownBase
from sim_backend.model import AntennaModel

Table = NDArray[np.float64]
#: gusts, rms: none to severe (MIL-F-8785C)
_MOST_GUST_M_S = 6.1
#: share of the flights that turn, by at most so much bank (rad)
_TURNING, _MOST_BANK = 0.3, 0.5236
#: elevations of what is looked at (rad)
_LOWEST, _HIGHEST = math.radians(10.0), math.radians(75.0)
#: a motion that stopped is asked for again so often (s), as `point` does
_AGAIN_S = 2.0
#: rows beyond the end of a flight (s)
_MARGIN_S = 5.0
#: steps of the histogram of errors (rad), and how many
ERROR_STEP_RAD, ERROR_STEPS = math.radians(0.005), 200


@dataclass(frozen=True)
class PointingRequirement:
    """What a terminal has to keep: rad and s. Numbers of 47 CFR 25.228 unless somebody says otherwise."""

    within_rad: float = math.radians(0.2)
    mute_beyond_rad: float = math.radians(0.5)
    mute_within_s: float = 0.1


@dataclass(frozen=True)
class FlightTask:
    """What all flights share."""

    settings: DaemonSettings
    model: AntennaModel
    navigation: NavigationErrors
    requirement: PointingRequirement
    duration_s: float


@dataclass(frozen=True)
class FlownFlight:
    """What came of a flight. Times in s; the error is the true angle between where the antenna looks and the target."""

    seed: int
    gust_m_s: float
    bank_rad: float
    elevation_rad: float
    #: until it first transmitted, infinite where it never did; flown from then on
    acquired_s: float
    flown_s: float
    transmitting_s: float
    within_s: float
    mutes: int
    #: times that the error went beyond the limit after the acquisition, and for how long it transmitted there at most
    excursions: int
    slowest_mute_s: float
    worst_rad: float
    silences: int
    #: time of transmission by size of error in steps of ERROR_STEP_RAD, the last one open
    histogram: tuple[float, ...]
    #: what the host stopped for, by name, each once
    stops: tuple[str, ...]
    #: of a processor
    computed_s: float


def fly(task: FlightTask, seed: int) -> FlownFlight:
    """One flight, which its seed draws."""
    begun = time.process_time()
    draw = np.random.default_rng(seed)
    gust, bank = float(draw.uniform(0.0, _MOST_GUST_M_S)), 0.0
    if draw.random() < _TURNING:
        bank = float(draw.uniform(-_MOST_BANK, _MOST_BANK))
    azimuth = float(draw.uniform(-math.pi, math.pi))
    elevation = math.asin(draw.uniform(math.sin(_LOWEST), math.sin(_HIGHEST)))
    looks, lasts_s = task.model.file.boresight, task.duration_s + _MARGIN_S
    base = FlownBase(*as_base(*_aircraft(lasts_s, gust, bank, draw), looks), 1.0 / MOTION_ROW_HZ)
    navigation = ErringNavigation(*task.navigation.drawn(lasts_s, draw), TOLD_HZ)
    settings = task.settings
    path = FlightPath(settings, task.model, seed, base, navigation)
    path.connect()
    first = path.tick
    target = Target("a direction", lambda time_s: (np.full(len(time_s), azimuth), np.full(len(time_s), elevation)))
    stops = _held(path, way_of(target, task.duration_s, looks), first + round(task.duration_s * settings.rate_hz))
    truth = path.truth(first)
    sky = looks.sign * boresight(joints_seen(target, np.zeros(1), looks))
    towards = in_base(np.repeat(sky, len(truth), axis=0), truth[:, 2:5])
    error = between(looks.sign * boresight(truth[:, :2]), towards)
    found = judged(error, truth[:, 5] == 0.0, 1.0 / settings.rate_hz, task.requirement)
    silences = int(np.count_nonzero(np.diff(navigation.errors[:, SILENT]) > 0))
    return FlownFlight(
        seed, gust, bank, elevation, **found, silences=silences, stops=stops, computed_s=time.process_time() - begun
    )


def _aircraft(duration_s: float, gust_m_s: float, bank_rad: float, draw: np.random.Generator) -> tuple[Table, Table]:
    """Attitude and acceleration of the pivot (n, 3): turbulence on any heading, with a turn where there is a bank."""
    turbulence = Turbulence(motion="turbulence", sigma_m_s=max(gust_m_s, 1e-3))
    attitude, pivot = turbulence.rows(duration_s, int(draw.integers(1 << 31)))
    attitude = attitude + (0.0, 0.0, draw.uniform(-math.pi, math.pi))
    if bank_rad:
        turned, pushed = Manoeuvre(motion="manoeuvre", bank_rad=bank_rad).rows(duration_s, 0)
        attitude, pivot = attitude + turned, pivot + pushed
    return attitude, pivot


def _held(path: FlightPath, way: Way, end: int) -> tuple[str, ...]:
    """Follow a way to its end, asked for again after a stop as `point` does; what the host stopped for."""
    host, first, stops = path.host, path.tick, []
    pause = round(_AGAIN_S * path.settings.rate_hz)
    while path.tick < end:
        if host.state is HostState.FAULT:
            host.reset_fault()
        elif host.state in (HostState.IDLE, HostState.ACTIVE):
            host.command(program_of([way.segment(first, end - path.tick)]))
            path.fly(end - path.tick)
            if path.tick >= end:
                break
            stops.append(host.cause.name.lower())
        path.fly(min(pause, end - path.tick), until_done=False)
    return tuple(dict.fromkeys(stops))


def judged(
    error: Table, transmitting: NDArray[np.bool_], step_s: float, requirement: PointingRequirement
) -> dict[str, Any]:
    """Figures of a flight from the true error (n,), rad, and when it transmitted."""
    on = np.flatnonzero(transmitting)
    held = error[on]
    beyond = error > requirement.mute_beyond_rad
    loud = _runs(transmitting & beyond)
    bins = np.minimum((held / ERROR_STEP_RAD).astype(np.int64), ERROR_STEPS)
    return {
        "acquired_s": float(on[0]) * step_s if len(on) else math.inf,
        "flown_s": float(len(error) - on[0]) * step_s if len(on) else 0.0,
        "transmitting_s": len(on) * step_s,
        "within_s": float(np.count_nonzero(held <= requirement.within_rad)) * step_s,
        "mutes": int(np.count_nonzero(np.diff(transmitting.astype(np.int8)) < 0)),
        "excursions": len(_runs(beyond[on[0] :])) if len(on) else 0,
        "slowest_mute_s": float(max(loud, default=0)) * step_s,
        "worst_rad": float(held.max(initial=0.0)),
        "histogram": tuple(float(n) for n in np.bincount(bins, minlength=ERROR_STEPS + 1) * step_s),
    }


def _runs(flags: NDArray[np.bool_]) -> list[int]:
    """Lengths of the stretches of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], flags.astype(np.int8), [0]])))
    return [int(n) for n in edges[1::2] - edges[::2]]
