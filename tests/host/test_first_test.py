"""The test before the first motion passes healthy antennas and says of a wrong one what is wrong, early."""

from __future__ import annotations

import numpy as np
import pytest

from gimbal_hil.loop.host import FirstTest, FirstTestState, HostCause, HostState, Program
from gimbal_hil.loop.settings import DaemonSettings, settings_from_document, shipped_settings
from gimbal_hil.proof.bench.faults import Rig, Transport
from sim_backend.device import Spoilt
from sim_backend.model import AntennaModel, shipped_model

AXES = ("outer", "inner")


def tried(
    settings: DaemonSettings | None = None,
    model: AntennaModel | None = None,
    spoilt: tuple[int, str, Spoilt] | None = None,
    known_within: float = 3.0,
) -> tuple[Rig, FirstTest, np.ndarray]:
    """A rig on which the test has been made, and the motion meanwhile."""
    rig = Rig(settings or shipped_settings(), model or shipped_model(), Transport.SERIAL, seed=5)
    if spoilt is not None:
        rig.device.spoil(*spoilt)
    test, motion = FirstTest(rig.host, 1e-3, known_within=(known_within,) * 2), []
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
    assert AXES[axis] in test.problem and rig.host.cause in (
        HostCause.FIRST_TEST,
        HostCause.RUNAWAY,
        HostCause.DRIVE_FAULT,
    )
    assert np.abs(motion[:, :2]).max() < 0.06 and np.abs(motion[:, 2:]).max() < 1.2


def test_an_inertia_that_is_far_off_is_told() -> None:
    for inertia, words in ((5.0, "see `expectation`"), (0.1, "of what its torque should do")):
        _, test, _ = tried(changed(inertia_kg_m2=inertia, disturbance_nm=30.0))
        assert test.state is FirstTestState.FAILED and words in test.problem, test.problem


@pytest.mark.parametrize("counts", [0.5, 2.0])
def test_motion_of_half_or_twice_what_is_expected_passes_and_asks_for_a_look(counts: float) -> None:
    """An encoder and a rate that both count half or twice look like another inertia."""
    expected = shipped_settings().axes["outer"].expectation
    assert expected is not None
    _, test, _ = tried(changed(inertia_kg_m2=expected.inertia_kg_m2 * counts))
    assert test.state is FirstTestState.PASSED
    assert "check gear, encoder counts and `expectation` of outer: turn it by hand" in test.said
    _, healthy, _ = tried()
    assert "expected: outer 93%, inner 82%" in healthy.said and "check" not in healthy.said


@pytest.mark.parametrize("counts", [0.5, 2.0])
def test_motion_of_half_or_twice_fails_where_the_inertia_is_known(counts: float) -> None:
    expected = shipped_settings().axes["outer"].expectation
    assert expected is not None
    settings = changed(inertia_kg_m2=expected.inertia_kg_m2 * counts)
    _, test, motion = tried(settings, known_within=1.3)
    assert test.state is FirstTestState.FAILED and np.abs(motion[:, :2]).max() < 0.02
    assert "outer moved" in test.problem and "known within a factor of 1.3" in test.problem


@pytest.mark.parametrize("off", [1.0 / 1.15, 1.15])
@pytest.mark.parametrize("counts", [0.5, 2.0])
def test_from_a_factor_of_1_15_on_it_fails_however_far_off_the_inertia_is_within_it(counts: float, off: float) -> None:
    expected = shipped_settings().axes["outer"].expectation
    assert expected is not None
    _, test, _ = tried(changed(inertia_kg_m2=expected.inertia_kg_m2 * counts * off), known_within=1.15)
    assert test.state is FirstTestState.FAILED and "known within a factor of 1.15" in test.problem


@pytest.mark.parametrize("stated", [1.0 / 1.3, 1.0, 1.3])
@pytest.mark.parametrize("antenna", HEALTHY)
def test_a_healthy_antenna_whose_inertia_is_known_so_well_passes(antenna: str, stated: float) -> None:
    document = shipped_settings().model_dump(mode="json", by_alias=True)
    for axis in AXES:
        document["axes"][axis]["expectation"]["inertia_kg_m2"] *= stated
    _, test, _ = tried(settings_from_document(document, "test"), HEALTHY[antenna], known_within=1.3)
    assert test.state is FirstTestState.PASSED, test.problem


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


@pytest.mark.parametrize(("has_gyro", "passes"), [(True, False), (False, True)])
def test_a_rate_that_is_the_encoders_own_may_be_read_at_another_moment(has_gyro: bool, passes: bool) -> None:
    """A gyro that reads two thirds stands for a drive whose position and rate are not of one moment."""
    model = shipped_model().with_numbers("inner", {"gyro.scale_error": -1.0 / 3.0})
    rig = Rig(shipped_settings(), model, Transport.SERIAL, seed=5)
    test = FirstTest(rig.host, 1e-3, has_gyro)
    for _ in range(1500):
        test.before_tick()
        rig.advance(1)
    assert (test.state is FirstTestState.PASSED) is passes, test.problem
    assert passes or "of what its gyro says" in test.problem


def words_of(given: list[Program | str]) -> list[str]:
    return [word if isinstance(word, str) else "start" for word in given if word]


def test_where_most_ticks_are_missed_it_is_made_again_until_the_machine_has_time() -> None:
    rig = Rig(shipped_settings(), shipped_model(), Transport.SERIAL, seed=5)
    test, given, starts = FirstTest(rig.host, 1e-3), [], []
    for tick in range(9000):
        given.append(test.before_tick())
        if isinstance(given[-1], Program):
            starts.append(tick)
        rig.antenna_heard = tick < 100 or tick % 2 == 0 or test.state is not FirstTestState.RUNS
        rig.advance(1)
    assert test.state is not FirstTestState.FAILED and "too many ticks were missed" in test.spoilt
    # everything that the host is given is answered, or a recorded run could not be computed again
    assert words_of(given)[:10] == ["start", "stop"] * 5
    waits = np.diff(starts)
    assert (waits[1:] > 1.3 * waits[:-1]).all()
    for _ in range(8000):
        test.before_tick()
        rig.antenna_heard = True
        rig.advance(1)
    assert (test.state, rig.host.state) == (FirstTestState.PASSED, HostState.IDLE)


@pytest.mark.parametrize("segment", [1, 0])
@pytest.mark.parametrize("way", ["stop", "quick_stop"])
def test_a_test_that_an_operator_stopped_has_not_passed_and_is_made_again(way: str, segment: int) -> None:
    rig = Rig(shipped_settings(), shipped_model(), Transport.SERIAL, seed=5)
    test, stopped = FirstTest(rig.host, 1e-3), False
    for _ in range(3000):
        test.before_tick()
        rig.advance(1)
        if not stopped and rig.host.following and rig.host.status()["segment"] == segment:
            rig.advance(20)
            getattr(rig.host, way)()
            stopped = True
        if stopped and test.state is FirstTestState.DUE and rig.host.state is HostState.FAULT:
            rig.host.reset_fault()
        if test.state is FirstTestState.PASSED:
            break
        assert test.state is not FirstTestState.FAILED
    assert stopped and test.spoilt and (test.state, rig.host.state) == (FirstTestState.PASSED, HostState.IDLE)


@pytest.mark.parametrize("window_ticks", [20, 250])
@pytest.mark.parametrize("into", [5, 20, 40, 62])
def test_an_axis_whose_pulses_a_stall_skipped_has_not_passed(into: int, window_ticks: int) -> None:
    document = shipped_settings().model_dump(mode="json", by_alias=True)
    deadman = {"window_ticks": window_ticks, "reaction": "decelerate_and_hold"}
    document["supervisor"] |= {"lost_ticks": 100, "set_point_lag_ticks": 200, "deadman": deadman}
    rig = Rig(settings_from_document(document, "test"), shipped_model(), Transport.SERIAL, seed=5)
    test, given, on_the_last_axis = FirstTest(rig.host, 1e-3), [], 0
    for _ in range(3000):
        given.append(test.before_tick())
        active = rig.host.following and rig.host.state is HostState.ACTIVE
        on_the_last_axis += active and rig.host.status()["segment"] == 0
        if on_the_last_axis == into:
            # the host stands still over what is left of the last axis' pattern, the antenna does not
            rig.stall(120)
            on_the_last_axis += 1
        rig.advance(1)
        assert test.state is not FirstTestState.FAILED, test.problem
        if test.state is FirstTestState.PASSED:
            break
    assert test.state is FirstTestState.PASSED and words_of(given).count("start") == 2


def test_a_fault_that_a_stall_brought_is_reset_by_the_test_itself() -> None:
    document = shipped_settings().model_dump(mode="json", by_alias=True)
    document["supervisor"] |= {"lost_ticks": 100, "deadman": {"window_ticks": 250, "reaction": "decelerate_and_hold"}}
    rig = Rig(settings_from_document(document, "test"), shipped_model(), Transport.SERIAL, seed=5)
    test, given = FirstTest(rig.host, 1e-3), []
    for _ in range(4000):
        given.append(test.before_tick())
        # set-points are lost for a while: the drive's echo stands still
        rig.set_points_pass = not 40 <= rig.tick < 100
        rig.advance(1)
    assert (test.state, rig.host.state) == (FirstTestState.PASSED, HostState.IDLE)
    assert words_of(given) == ["start", "fault_reset", "start"]
