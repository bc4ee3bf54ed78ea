"""Feedback of other makes' drives that is wrong, in every way that a row names and in every motion: noticed, before the
axis has gone far.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from firmware_protocol.adapters import Power
from gimbal_hil.loop.host import HostState
from sim_backend.drives import SimulatedDrive
from tests.adapters.fault_rows import MOTIONS, ROWS, Row
from tests.adapters.faults import DRIVES, MAKES, outcome, rig_of, spoilt
from tests.adapters.rig import AdapterRig
from tests.parts import heavy_but

#: the whole matrix takes minutes; one make whose drives answer when asked, and one that speaks by itself, in any run
_SOON = (("moteus", "second", "pushed"), ("dbc", "first", "slow"))


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.name)
@pytest.mark.parametrize("which", heavy_but(_SOON, itertools.product(MAKES, DRIVES, MOTIONS)), ids="-".join)
def test_spoilt_feedback_is_noticed_before_the_axis_has_gone_far(
    which: tuple[str, str, str], row: Row, tmp_path: Path
) -> None:
    make, drive, motion = which
    rig = rig_of(make, tmp_path)
    try:
        found = outcome(rig, make, drive, row, motion)
    finally:
        rig.close()
    assert found.is_noticed or motion in row.not_in, found
    assert found.only_braked and found.gone_rad < row.gone_rad, found


@pytest.fixture(params=MAKES)
def rig(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[AdapterRig]:
    made = rig_of(request.param, tmp_path)
    yield made
    made.close()


def test_a_position_that_jumped_across_a_silence_is_not_driven_into(rig: AdapterRig) -> None:
    rig.connected().position(0.4, -0.3).run(2500)
    rig.lost = lambda frame: True
    rig.run(1000)
    spoilt(
        rig,
        lambda seen: replace(seen.now, position_rad=seen.now.position_rad - 2 * math.pi),
        [rig.gateway.drives[0].sample],
    )
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


def _turned_round(rig: AdapterRig, place: int) -> None:
    """A drive whose motor turns the other way under torque; a stop that uses none is as ever."""
    drive = rig.gimbal.drives[place]
    kind = type(drive)

    def torque(self: SimulatedDrive) -> float:
        under_torque = rig.gateway.drives[place].sample.power is Power.ON
        return -kind.torque_nm.__get__(self) if under_torque else kind.torque_nm.__get__(self)

    drive.__class__ = type("TurnedRound", (kind,), {"torque_nm": property(torque)})


def _swapped(rig: AdapterRig, place: int) -> None:
    """Drives that have taken each other's number."""
    rig.gimbal.drives = rig.gimbal.drives[::-1]


@pytest.mark.parametrize(
    ("change", "place", "most_rad"),
    [(_turned_round, 0, 0.06), (_turned_round, 1, 0.06), (_swapped, 0, 0.4)],
    ids=["first turned round", "second turned round", "swapped"],
)
def test_drives_that_come_back_from_a_restart_as_others_stop_the_axes_soon(
    rig: AdapterRig, change: Callable[[AdapterRig, int], None], place: int, most_rad: float
) -> None:
    rig.connected().position(0.3, -0.3).run(1500)
    rig.host.stop()
    rig.run(300)
    rig.lost = lambda frame: True
    rig.run(500)
    rig.lost = lambda frame: False
    change(rig, place)
    rig.run(600)
    if rig.host.state is HostState.FAULT:
        # an operator who knows of nothing
        rig.host.reset_fault()
        rig.run(500)
    before = rig.joints.copy()
    rig.position(0.0, 0.2).run(1000)
    assert rig.host.state is HostState.FAULT, rig.events[-5:]
    assert np.max(np.abs(rig.joints - before)) < most_rad, (rig.host.cause, rig.joints - before)
