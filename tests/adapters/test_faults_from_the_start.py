"""Feedback of other makes' drives that is wrong from the first sample on: the test before the first motion notices it,
or nobody can.
"""

from __future__ import annotations

import itertools
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from firmware_protocol.adapters import AxisSample
from gimbal_hil.loop.host import FirstTest, FirstTestState, HostState
from tests.adapters.faults import DRIVES, MAKES, geared, rig_of
from tests.adapters.rig import AdapterRig
from tests.parts import heavy_but

#: true samples from the first one on, the newest last -> what is told
Told = Callable[[deque[AxisSample]], AxisSample]
_MOST_RAD = 0.02


@dataclass(frozen=True)
class Fault:
    """A fault that is there before the host is; why the test before the first motion lets it pass."""

    name: str
    told: Told
    reason: str = ""


def _scaled(place: float, rate: float) -> Told:
    def told(true: deque[AxisSample]) -> AxisSample:
        now = true[-1]
        return replace(now, position_rad=place * now.position_rad, rate_rad_s=rate * (now.rate_rad_s or 0.0))

    return told


def _late(ticks: int) -> Told:
    def told(true: deque[AxisSample]) -> AxisSample:
        old, now = true[max(0, len(true) - 1 - ticks)], true[-1]
        return replace(now, position_rad=old.position_rad, rate_rad_s=old.rate_rad_s)

    return told


_INERTIA = (
    "an axis of twice or half the inertia moves so, and only who knows that knows better: unless `inertia_within` says "
    "so, the test lets pass what is within a factor of three of `expectation`"
)
FAULTS = (
    Fault("none", _scaled(1.0, 1.0), "a sound drive"),
    Fault("position and rate have the wrong sign", _scaled(-1.0, -1.0)),
    Fault("the position has the wrong sign", _scaled(-1.0, 1.0)),
    Fault("the rate has the wrong sign", _scaled(1.0, -1.0)),
    Fault("the position stands still", _scaled(0.0, 1.0)),
    Fault("the rate stands still", _scaled(1.0, 0.0)),
    Fault("all of it stands still", _scaled(0.0, 0.0)),
    Fault("the position is a quarter", _scaled(0.25, 1.0)),
    Fault("position and rate are a quarter", _scaled(0.25, 0.25)),
    Fault("position and rate are half", _scaled(0.5, 0.5), _INERTIA),
    Fault("position and rate are twice", _scaled(2.0, 2.0), _INERTIA),
    Fault("turns for radians", _scaled(1.0 / (2.0 * np.pi), 1.0 / (2.0 * np.pi))),
    Fault("every sample is 10 ms late", _late(10)),
    Fault("every sample is 20 ms late", _late(20)),
    Fault("every sample is 60 ms late", _late(60)),
)
#: one make whose drives answer when asked, and one that speaks by itself, in any run
_SOON = (("moteus", "second"), ("dbc", "first"))


def told_wrong(rig: AdapterRig, place: int, told: Told) -> None:
    """What the adapter hears of this drive goes through `told` from the first sample on."""
    gateway, gear = rig.gateway, rig.settings.link.drives[place].gear
    drive, true = gateway.drives[place], deque[AxisSample](maxlen=100)
    feedback = gateway.feedback

    def wrong(do: Callable[..., object], is_new: bool) -> Callable[..., object]:
        def done(*given: object) -> object:
            kept = drive.sample
            now = geared(kept, 1.0 / gear)
            if is_new or not true:
                true.append(now)
            drive.sample = geared(told(true), gear)
            try:
                return do(*given)
            finally:
                drive.sample = kept

        return done

    gateway.feedback = wrong(feedback, True)
    gateway._advance, gateway.silent = wrong(gateway._advance, False), wrong(gateway.silent, False)


def first_test(rig: AdapterRig, ticks: int = 1000, known_within: float = 3.0) -> FirstTest:
    """The test as the daemon makes it, until it has told."""
    test = FirstTest(rig.host, 1e-3, has_gyro=False, known_within=(known_within,) * 2)
    for _ in range(ticks):
        test.before_tick()
        rig.run(1)
        if test.state in (FirstTestState.PASSED, FirstTestState.FAILED):
            break
    return test


def tried(
    which: tuple[str, str], fault: Fault, folder: Path, known_within: float = 3.0
) -> tuple[FirstTest, HostState, float]:
    """The test of a rig that is told wrong from its start; the host's state, and how far an axis has gone, after it."""
    make, drive = which
    rig = rig_of(make, folder)
    try:
        start = rig.joints.copy()
        told_wrong(rig, DRIVES.index(drive), fault.told)
        test = first_test(rig, known_within=known_within)
        # until what was pushed stands
        rig.run(300)
        return test, rig.host.state, float(np.abs(rig.joints - start).max())
    finally:
        rig.close()


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.name)
@pytest.mark.parametrize("which", heavy_but(_SOON, itertools.product(MAKES, DRIVES)), ids="-".join)
def test_feedback_that_is_wrong_from_the_start_does_not_come_through_the_first_test(
    which: tuple[str, str], fault: Fault, tmp_path: Path
) -> None:
    test, state, gone_rad = tried(which, fault, tmp_path)
    wanted = FirstTestState.PASSED if fault.reason else FirstTestState.FAILED
    assert (test.state, state is HostState.FAULT) == (wanted, not fault.reason), test.problem
    assert gone_rad < _MOST_RAD


@pytest.mark.parametrize("fault", [one for one in FAULTS if one.reason], ids=lambda fault: fault.name)
@pytest.mark.parametrize("which", heavy_but(_SOON, itertools.product(MAKES, DRIVES)), ids="-".join)
def test_half_or_twice_of_a_known_inertia_does_not_come_through_either(
    which: tuple[str, str], fault: Fault, tmp_path: Path
) -> None:
    test, state, gone_rad = tried(which, fault, tmp_path, known_within=1.3)
    is_sound = fault is FAULTS[0]
    assert (test.state is FirstTestState.PASSED, state is HostState.FAULT) == (is_sound, not is_sound)
    assert ("known within a factor of 1.3" in test.problem) is not is_sound and gone_rad < _MOST_RAD
