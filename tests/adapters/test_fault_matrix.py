"""Feedback of other makes' drives that is wrong, in every way that a row names, at rest, slow and fast: noticed, and
before the axis has gone far.

What is spoilt is what an adapter last heard, so that every row holds for every make.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from firmware_protocol.adapters import AxisSample
from gimbal_hil.loop.host import HostState
from tests.adapters.rig import AdapterRig
from tests.adapters.servo import mapped_rig

#: what an adapter heard, ticks since the fault began, what it heard as that began -> what it is told to have heard
Spoil = Callable[[AxisSample, int, AxisSample], AxisSample]


@dataclass(frozen=True)
class Row:
    """A fault of feedback; within how many ticks it is noticed, or why it cannot be at rest."""

    name: str
    spoil: Spoil
    within: int
    not_at_rest: str = ""


def _frozen(now: AxisSample, ticks: int, then: AxisSample) -> AxisSample:
    return replace(then, updates=now.updates, power=now.power)


ROWS = (
    Row("all of it stands still", _frozen, 1200, "nothing moves and no torque is asked for: true feedback is the same"),
    Row(
        "the position stands still, the rate is true",
        lambda now, ticks, then: replace(now, position_rad=then.position_rad),
        1500,
        "nothing moves: the true position stands still too",
    ),
    Row(
        "the position creeps, the rate says rest",
        lambda now, ticks, then: replace(now, position_rad=now.position_rad + 2e-4 * ticks),
        2500,
    ),
    Row(
        "the position jumps by 18 degrees",
        lambda now, ticks, then: replace(now, position_rad=now.position_rad + math.radians(18.0)),
        5,
    ),
    Row("a whole turn is lost", lambda now, ticks, then: replace(now, position_rad=now.position_rad - 2 * math.pi), 5),
    Row(
        "a count of 32 bits wraps",
        lambda now, ticks, then: replace(now, position_rad=now.position_rad - 2**32 / 2**14 * 2 * math.pi),
        5,
    ),
    Row("the position is no number", lambda now, ticks, then: replace(now, position_rad=math.nan), 5),
    Row("the rate is beyond all reason", lambda now, ticks, then: replace(now, rate_rad_s=1e6), 5),
)
MOTIONS = {"rest": (0.0, 0.0), "slow": (0.06, -0.06), "fast": (0.9, -0.9)}


@pytest.fixture(params=("moteus", "odrive", "cia402", "dbc"))
def rig(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[AdapterRig]:
    made = mapped_rig(tmp_path) if request.param == "dbc" else AdapterRig(request.param)
    yield made
    made.close()


def spoilt(rig: AdapterRig, spoil: Spoil) -> None:
    """From now on the first drive's samples are spoilt as the gateway takes them."""
    gateway = rig.gateway
    seen, then, start = gateway._samples, gateway.drives[0].sample, rig.number

    def samples() -> list[AxisSample]:
        drive = gateway.drives[0]
        true = drive.sample
        drive.sample = spoil(true, rig.number - start, then)
        try:
            return seen()
        finally:
            drive.sample = true

    gateway._samples = samples


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.name)
def test_spoilt_feedback_is_noticed_before_the_axis_has_gone_far(rig: AdapterRig, row: Row, motion: str) -> None:
    rig.connected().position(*MOTIONS[motion]).run(150)
    start = float(rig.joints[0])
    spoilt(rig, row.spoil)
    if motion == "rest" and row.not_at_rest:
        rig.run(300)
        assert abs(float(rig.joints[0]) - start) < 0.01
        return
    gone = []
    for _ in range(row.within):
        rig.run(1)
        gone.append(float(rig.joints[0]))
        if rig.host.state is HostState.FAULT:
            break
    assert rig.host.state is HostState.FAULT, rig.events[-4:]
    # the first axis was on its way; without feedback it may not go on for long
    assert np.abs(np.array(gone) - start).max() < abs(MOTIONS[motion][0]) + 0.8
    rig.run(20)
    assert rig.only_brakes()


def test_a_position_that_jumped_across_a_silence_is_not_driven_into(rig: AdapterRig) -> None:
    rig.connected().position(0.4, -0.3).run(2500)
    rig.lost = lambda frame: True
    rig.run(1000)
    spoilt(rig, lambda now, ticks, then: replace(now, position_rad=now.position_rad - 2 * math.pi))
    rig.lost = lambda frame: False
    rig.run(600)
    assert rig.host.state is HostState.FAULT and rig.host.cause.name == "POSITION_JUMP", rig.events[-5:]
    before = rig.joints.copy()
    rig.position(0.5, -0.3).run(500)
    np.testing.assert_allclose(rig.joints, before, atol=0.02)
    # only a person says that the axis is where it says
    rig.host.reset_fault()
    rig.run(600)
    assert rig.host.state is HostState.IDLE, rig.events[-5:]
