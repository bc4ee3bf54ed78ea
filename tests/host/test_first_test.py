"""The test before the first motion passes healthy antennas and says of a wrong one what is wrong, early."""

from __future__ import annotations

import numpy as np
import pytest

from gimbal_hil.bench.faults import Rig, Transport
from gimbal_hil.host import Cause, FirstTest, FirstTestState, HostState
from gimbal_hil.settings import DaemonSettings, settings_from_document, shipped_settings
from sim_backend.device import Spoilt
from sim_backend.model import AntennaModel, shipped_model

AXES = ("outer", "inner")


def tried(
    settings: DaemonSettings | None = None,
    model: AntennaModel | None = None,
    spoilt: tuple[int, str, Spoilt] | None = None,
) -> tuple[Rig, FirstTest, np.ndarray]:
    """A rig on which the test has been made, and the motion meanwhile."""
    rig = Rig(settings or shipped_settings(), model or shipped_model(), Transport.SERIAL, seed=5)
    if spoilt is not None:
        rig.device.spoil(*spoilt)
    test, motion = FirstTest(rig.host, 1e-3), []
    for _ in range(1500):
        test.before_tick()
        motion.append(rig.advance(1))
        if test.state in (FirstTestState.PASSED, FirstTestState.FAILED):
            break
    motion.append(rig.advance(100))
    return rig, test, np.concatenate(motion)


def changed(**expectation: object) -> DaemonSettings:
    document = shipped_settings().model_dump(mode="json", by_alias=True)
    document["axes"]["outer"]["expectation"] |= expectation
    return settings_from_document(document, "test")


SWAY = {"motion": "sinusoid", "amplitude_rad": {"roll": 0.15, "pitch": 0.1, "yaw": 0.2}}
HEALTHY = {
    "shipped": shipped_model(),
    "sixteen-bit encoders": shipped_model().with_numbers("outer", {"encoder.step": 9.587e-5}),
    "noisy gyros": shipped_model().with_numbers("inner", {"gyro.noise": 2e-3}),
    "twice the friction": shipped_model().with_numbers("outer", {"friction.coulomb": 0.48, "friction.breakaway": 0.52}),
    "a slow actuator": shipped_model().with_numbers("inner", {"actuator.time_constant": 0.002}),
    "a swaying base": shipped_model().with_base({**SWAY, "frequency_hz": {"roll": 0.5, "pitch": 0.8, "yaw": 0.3}}),
}


@pytest.mark.parametrize("antenna", HEALTHY)
def test_a_healthy_antenna_passes_and_hardly_moves(antenna: str) -> None:
    rig, test, motion = tried(model=HEALTHY[antenna])
    assert (test.state, test.problem, rig.host.state) == (FirstTestState.PASSED, "", HostState.IDLE)
    # a few milliradians; beside them the base may carry the joints
    assert np.abs(motion[:, :2]).max() < (0.006 if antenna != "a swaying base" else 0.1)


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize(
    ("part", "kind", "words"),
    [
        ("motor", Spoilt.REVERSED, "against its torque|runaway"),
        ("motor", Spoilt.DEAD, "of what its torque should do|runaway"),
        ("gyro", Spoilt.REVERSED, "against its torque|runaway"),
        ("encoder", Spoilt.REVERSED, "counts against its gyro"),
        ("encoder", Spoilt.FROZEN, "of what its gyro says"),
    ],
)
def test_an_antenna_that_is_wired_wrong_fails_before_it_moves_far(
    axis: int, part: str, kind: Spoilt, words: str
) -> None:
    rig, test, motion = tried(spoilt=(axis, part, kind))
    assert test.state is FirstTestState.FAILED and rig.host.state is HostState.FAULT
    assert any(word in test.problem for word in words.split("|"))
    assert AXES[axis] in test.problem and rig.host.cause in (Cause.FIRST_TEST, Cause.RUNAWAY, Cause.DRIVE_FAULT)
    assert np.abs(motion[:, :2]).max() < 0.06 and np.abs(motion[:, 2:]).max() < 1.2


def test_an_inertia_that_is_far_off_is_told() -> None:
    for inertia, words in ((5.0, "see `expectation`"), (0.1, "of what its torque should do")):
        _, test, _ = tried(changed(inertia_kg_m2=inertia, disturbance_nm=30.0))
        assert test.state is FirstTestState.FAILED and words in test.problem, test.problem


def test_an_antenna_of_which_nothing_is_expected_is_not_tried() -> None:
    document = shipped_settings().model_dump(mode="json", by_alias=True)
    for axis in AXES:
        document["axes"][axis]["expectation"] = None
    _, test, motion = tried(settings_from_document(document, "test"))
    assert test.state is FirstTestState.PASSED and np.abs(motion[:, :2]).max() < 1e-3


def test_a_test_that_a_lost_link_ended_is_made_again() -> None:
    rig = Rig(shipped_settings(), shipped_model(), Transport.SERIAL, seed=5)
    test = FirstTest(rig.host, 1e-3)
    for tick in range(6000):
        test.before_tick()
        rig.antenna_heard = not 80 <= tick < 300
        rig.advance(1)
    assert (test.state, rig.host.state) == (FirstTestState.PASSED, HostState.IDLE)


def test_ticks_that_the_machine_missed_make_no_wrong_verdict() -> None:
    rig = Rig(shipped_settings(), shipped_model(), Transport.SERIAL, seed=5)
    test = FirstTest(rig.host, 1e-3)
    for tick in range(3000):
        test.before_tick()
        # one tick in seven hears nothing, and then two sets at once
        rig.antenna_heard = tick % 7 != 0
        rig.advance(1)
        if tick % 11 == 0:
            rig.tick += 2
    assert test.state is FirstTestState.PASSED, test.problem


def test_where_most_ticks_are_missed_it_says_that_it_cannot_tell() -> None:
    rig = Rig(shipped_settings(), shipped_model(), Transport.SERIAL, seed=5)
    test, given = FirstTest(rig.host, 1e-3), []
    for tick in range(9000):
        given.append(test.before_tick())
        rig.antenna_heard = tick < 100 or tick % 2 == 0 or test.state is not FirstTestState.RUNS
        rig.advance(1)
    assert test.state is FirstTestState.FAILED and "too many ticks were missed" in test.problem
    # everything that the host is given is answered, or a recorded run could not be computed again
    words = [word if isinstance(word, str) else "start" for word in given if word]
    assert words == ["start", "stop"] * 4 + ["start", "distrust"]
