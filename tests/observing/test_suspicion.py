"""What seems to grow is named within ten seconds of brisk motion, and what only wanders is not."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gimbal_hil.realtime.observing.suspicion import CONFIRMED_BY, Growing, Suspected, SuspicionWatch, suspicion

RATE_HZ, LEAST_NM, ONSET_S = 1000.0, 0.02, 40.0


def motion(seconds: float, seed: int = 1) -> np.ndarray:
    """Position, rate, torque of brisk motion, (ticks, 3)."""
    rng = np.random.default_rng(seed)
    t = np.arange(round(seconds * RATE_HZ)) / RATE_HZ
    q, v, a = np.zeros_like(t), np.zeros_like(t), np.zeros_like(t)
    for hz, rad in ((0.11, 0.5), (0.43, 0.12), (1.1, 0.03)):
        phase, turns = rng.uniform(0.0, 6.0), 2.0 * np.pi * hz
        q += rad * np.sin(turns * t + phase)
        v += rad * turns * np.cos(turns * t + phase)
        a -= rad * turns**2 * np.sin(turns * t + phase)
    return np.column_stack([q, v, 0.5 * a + 0.25 * np.sign(v) + 0.06 * v])


def missing(moved: np.ndarray, cause: str, seed: int = 2) -> tuple[np.ndarray, np.ndarray]:
    """Missing torque and gyro error with a cause that sets in, beside friction that wanders and a gyro that drifts."""
    rng = np.random.default_rng(seed)
    q, v, u = moved.T
    t = np.arange(len(q)) / RATE_HZ
    wander = 0.004 * np.interp(
        t, np.arange(0.0, t[-1] + 20.0, 10.0), rng.normal(size=len(np.arange(0, t[-1] + 20, 10)))
    )
    lacks = 0.003 * rng.normal(size=len(q)) + wander * np.sign(v) + 0.002 * v
    gyro = 1e-3 * rng.normal(size=len(q)) + 5e-4
    there = t > ONSET_S
    lacks += there * {
        "ripple": 0.09 * np.cos(12.0 * q + 0.3),
        "friction level": 0.08 * np.sign(v),
        "torque gain": 0.2 * u,
        "unbalance": 0.3 * np.cos(q - 0.4),
        "two": 0.09 * np.cos(12.0 * q) + 0.09 * np.sign(v),
    }.get(cause, np.zeros_like(q))
    if cause == "slipping encoder":
        for at in np.arange(ONSET_S + 0.7, t[-1], 1.9):
            pulse = np.exp(-0.5 * ((t - at) / 0.03) ** 2)
            # the observer follows the step, and takes back what it first thought of it
            lacks += 1.5 * (1.0 - ((t - at) / 0.03) ** 2) * pulse
            gyro += 0.4 * pulse
    return lacks, gyro


def watched(cause: str, seconds: float = 52.0, seed: int = 1) -> tuple[SuspicionWatch, list[tuple[float, Suspected]]]:
    """The watch, and when it told what."""
    watch, told, moved = SuspicionWatch(RATE_HZ, LEAST_NM), [], motion(seconds, seed)
    lacks, gyro = missing(moved, cause, seed)
    for k, (q, _, u) in enumerate(moved.tolist()):
        if watch.take(float(lacks[k]), q, u, float(gyro[k])):
            assert watch.suspected is not None
            told.append((k / RATE_HZ, watch.suspected))
    return watch, told


@pytest.mark.parametrize("cause", list(Growing))
def test_a_cause_that_sets_in_is_named_within_ten_seconds(cause: Growing) -> None:
    _, told = watched(cause.value)
    assert told and told[0][1].cause is cause, [one.text for _, one in told]
    assert ONSET_S < told[0][0] < ONSET_S + 10.0
    assert told[0][1].probability > 0.95 and cause.value in told[0][1].text
    assert len(told) == 1


def test_the_size_and_the_order_are_told() -> None:
    _, told = watched("ripple")
    assert told[0][1].order == 12 and math.isclose(told[0][1].size, 0.09, rel_tol=0.15)
    _, told = watched("torque gain")
    assert math.isclose(told[0][1].size, 0.2, rel_tol=0.3)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_what_wanders_and_what_is_no_one_of_them_has_no_name(seed: int) -> None:
    assert watched("nothing", seed=seed)[1] == []
    assert watched("two", seed=seed)[1] == []


def test_every_cause_has_a_run_that_confirms_it_and_people_may_say_that_it_is_usual() -> None:
    assert set(CONFIRMED_BY) == set(Growing)
    watch, told = watched("friction level")
    assert told and watch.suspected is not None
    watch.learn_anew()
    assert watch.suspected is None


@pytest.mark.parametrize("new_place", [True, False])
def test_what_is_missing_where_the_axis_has_not_been_before_has_no_name(new_place: bool) -> None:
    t = 0.02 * np.arange(3400)
    centre = np.where((t > 62.0) & new_place, -0.6, 0.0)
    q, v = centre + 0.3 * np.sin(1.3 * t), 0.39 * np.cos(1.3 * t)
    # a spring beyond an angle, there all the time; or what sets in where the axis always was
    lacks = 0.2 * np.minimum(q + 0.35, 0.0) if new_place else np.where(t > 62.0, 0.1 * np.cos(q), 0.0)
    lacks += 0.002 * np.random.default_rng(4).normal(size=len(t))
    found = suspicion(np.column_stack([lacks, q, v, 0.06 * v, np.zeros_like(t)]), LEAST_NM)
    assert (found is None) == new_place
