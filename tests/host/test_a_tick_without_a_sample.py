"""A sample that is lost, or one more, while a joint turns is no jump of it: the observer is carried on by the torque
that it knows.
"""

from __future__ import annotations

import numpy as np
import pytest

from firmware_protocol.links import FaultsConfig
from gimbal_hil.loop.host import AxisCommand, HostState, Mode, Segment, Shape, program_of
from gimbal_hil.loop.host.layout import BEHIND, EXTRA_PERIODS, G_SIZE
from gimbal_hil.loop.host.reception import _note_periods
from gimbal_hil.loop.settings import DaemonSettings, settings_from_document
from gimbal_hil.pointing.arena import controller_settings
from gimbal_hil.realtime.lockstep import FramePath
from sim_backend.device import Device
from sim_backend.model import shipped_model

#: what `tune` finds for `realistic`: bandwidth, gusts above, gains of position and rate
STIFF = {"outer": (1880.0, 13.56, 158.6, 63.33), "inner": (945.0, 30.94, 192.2, 4.911)}
KEYS = ("bandwidth_rad_s", "gusts_above_rad_s", "position_kp_per_s", "rate_kp_s_per_rad")


#: the joints are fastest at its beginning and after half a period
SWING = program_of(
    [
        Segment(
            AxisCommand(Mode.POSITION, Shape.SINE, (0.0, 0.2, 0.2, 0.0)),
            AxisCommand(Mode.POSITION, Shape.SINE, (0.0, 0.15, 0.2, 0.0)),
            2800,
        )
    ]
)


def stiff() -> DaemonSettings:
    """Loops of an observer that is as stiff as `tune` makes it."""
    document = controller_settings("all").model_dump(mode="json", by_alias=True)
    for axis, numbers in STIFF.items():
        document["axes"][axis]["observer"] = dict(zip(KEYS, numbers, strict=True))
    return settings_from_document(document, "stiff")


@pytest.mark.parametrize("ticks", [1, 3])
def test_lost_ticks_do_not_leave_the_observer(ticks: int) -> None:
    settings = stiff()
    # where the joints are fastest: after half a period
    cut = {"start_tick": 2510, "ticks": ticks}
    path = FramePath(settings, shipped_model("realistic"), 1, FaultsConfig.model_validate({"cuts": [cut]}))
    path.connect()
    found = path.run(SWING)
    assert path.host.state is HostState.ACTIVE
    assert not [one.text for one in found.events if "shake" in one.text]
    # the reference has gone on meanwhile
    torque = found.signals()["outer.torque"]
    lost = slice(2490, 2560)
    assert np.abs(np.diff(torque[lost])).max() < 0.35 * settings.axes["outer"].limits.torque_nm


def braking(cut: dict[str, int] | None) -> np.ndarray:
    """Torques of the outer axis as it brakes from 0.25 rad/s."""
    faults = FaultsConfig.model_validate({"cuts": [cut]} if cut else {})
    path = FramePath(stiff(), shipped_model("realistic"), 1, faults)
    path.connect()
    path.host.command(SWING)
    path.advance(2500)
    path.host.stop()
    torque = path.advance(60).signals()["outer.torque"]
    assert path.host.state in (HostState.STOPPING, HostState.IDLE)
    return np.asarray(torque)


@pytest.mark.parametrize("ticks", [1, 3])
def test_lost_ticks_are_no_jump_of_a_joint_that_brakes(ticks: int) -> None:
    whole, cut = braking(None), braking({"start_tick": 2520, "ticks": ticks})
    limit = stiff().axes["outer"].limits.torque_nm
    assert not np.array_equal(whole, cut)
    assert np.abs(np.diff(cut)).max() < np.abs(np.diff(whole)).max() + 0.1 * limit


class Ahead:
    """An antenna whose clock is ahead of the host's: at one tick it goes on by some more than it was asked to."""

    def __init__(self, device: Device, at_tick: int, more: int) -> None:
        self._device, self._at, self._more, self._ticks = device, at_tick, more, 0

    def tick(self, received: bytes = b"") -> bytes:
        """As `Device.tick`."""
        self._ticks += 1
        answer = self._device.tick(received)
        if self._ticks == self._at:
            answer += b"".join(self._device.tick() for _ in range(self._more))
        return answer


@pytest.mark.parametrize("more", [1, 3])
def test_an_antenna_that_is_periods_ahead_is_no_jump_of_the_joint(more: int) -> None:
    settings = stiff()
    path = FramePath(settings, shipped_model("realistic"), 1)
    path.with_remote(Ahead(path.device, 2510, more))
    path.connect()
    found = path.run(SWING)
    assert path.host.state is HostState.ACTIVE
    assert not [one.text for one in found.events if "shake" in one.text]
    # the joint is ahead of its reference now, and the position loop asks for that, not for more
    rate_rad_s = 0.2 * 2.0 * np.pi * 0.2
    asked = more * settings.step_s * rate_rad_s * STIFF["outer"][2] * STIFF["outer"][3]
    change = np.abs(np.diff(found.signals()["outer.torque"][2490:2560])).max()
    assert 0.8 * asked < change < 1.2 * asked


@pytest.mark.parametrize(
    ("more", "carried"),
    [
        ([2], [2]),
        ([-3, 3], [0, 0]),
        ([-1, 2, 1], [0, 1, 1]),
        ([-1, -1, 2], [0, 0, 0]),
        # what was not made up for at once is behind for good: the next one is ahead
        ([-1, 0, 1], [0, 0, 1]),
        ([4000, 1], [0, 1]),
    ],
)
def test_an_antenna_that_makes_up_for_what_it_was_behind_is_not_ahead(more: list[int], carried: list[int]) -> None:
    G, found = np.zeros(G_SIZE, dtype=np.int64), []
    for one in more:
        _note_periods(G, False, one)
        found.append(int(G[EXTRA_PERIODS]))
    assert found == carried
    _note_periods(G, True, 5)
    assert G[EXTRA_PERIODS] == 0 == G[BEHIND]
