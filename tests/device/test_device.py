"""The virtual antenna as a host sees it: bound answers, honest numbers, the same bits every time."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol import mail as m
from firmware_protocol.enumerations import BrakeState, DriveState
from firmware_protocol.errors import BadInputError
from firmware_protocol.messages import (
    BaseAttitude,
    BaseRate,
    FeedbackInner,
    FeedbackOuter,
    MotorStatusInner,
    MotorStatusOuter,
    SetPoint,
)
from firmware_protocol.schema import RECORD_SIZE, Direction
from sim_backend.device import Device, DriveAxisSettings, FirmwareSettings
from sim_backend.model import load_model, model_from_document, shipped_model
from sim_backend.shipped import shipped_file
from tests.device.bench import FrameWire, bench, bench_model
from tests.device.random_session import session
from tests.endpoints import Receiver, Sender
from tests.interpreted import run_interpreted

SLOW = (MotorStatusOuter, MotorStatusInner, BaseAttitude, BaseRate)


def test_feedback_names_the_set_point_that_acted_before_it() -> None:
    stand = bench()
    for number in (0, 1, 2, 7, 400, 800, 1023, 0, 5):
        assert stand.tick((0.0, 0.0), sequence=number).last_sequence == number
        assert stand.tick(None).last_sequence == number


def test_each_tick_has_one_feedback_set_which_the_status_closes() -> None:
    stand = bench()
    for _ in range(100):
        stand.tick()
        assert [type(m).__name__ for m in stand.answer[-3:]] == ["FeedbackOuter", "FeedbackInner", "DriveStatus"]


def test_slow_messages_keep_their_rates_and_never_share_a_tick() -> None:
    stand = bench()
    seen: Counter[str] = Counter()
    for _ in range(1000):
        stand.tick()
        slow = [type(m).__name__ for m in stand.answer if isinstance(m, SLOW)]
        assert len(slow) <= 1
        seen.update(slow)
    assert seen == {"MotorStatusOuter": 20, "MotorStatusInner": 20, "BaseAttitude": 100, "BaseRate": 100}


def test_torque_of_tick_n_acts_before_the_sample_that_echoes_n() -> None:
    moved = bench().enable()
    still = bench().enable()
    moved.tick((15.0, 0.0))
    still.tick((0.0, 0.0))
    assert moved.device.joint_rates[0] > still.device.joint_rates[0]


def test_feedback_is_the_quantised_truth() -> None:
    stand = bench()
    stand.place(0, -3.0)
    stand.place(1, 0.7)
    stand.tick()
    outer = next(m for m in stand.answer if isinstance(m, FeedbackOuter))
    inner = next(m for m in stand.answer if isinstance(m, FeedbackInner))
    assert outer.position_rad == pytest.approx(stand.device.joint_positions[0], abs=1.5e-6)
    assert inner.position_rad == pytest.approx(stand.device.joint_positions[1], abs=1.5e-6)
    assert outer.rate_rad_s == pytest.approx(stand.device.joint_rates[0], abs=2e-3)


def test_attitude_stays_within_half_a_turn_and_body_rates_are_told() -> None:
    stand = bench(base={"motion": "constant_rate", "rate_rad_s": {"r": 1.5}})
    yaws = []
    for _ in range(5000):
        stand.device.tick()
        if stand.device.ticks % 10 == 1:
            yaws.append(stand.device.mail[m.BASE_HEADING_YAW] * m.BASE_HEADING_YAW_STEP)
    steps = np.diff(np.unwrap(yaws))
    assert max(yaws) < np.pi + 2e-6 and min(yaws) > -np.pi - 2e-6
    assert steps == pytest.approx(np.full(len(steps), 0.015), abs=4e-6)
    assert stand.device.mail[m.BASE_RATE_R] * m.BASE_RATE_R_STEP == pytest.approx(1.5)


def test_a_model_with_one_axis_leaves_the_inner_fields_zero() -> None:
    document = {
        "schema": 1,
        "name": "flywheel",
        "kind": "rotary",
        "axes": {"wheel": {"body": {"inertia": {"zz": 0.1}}, "actuator": {"limit": 5.0}}},
    }
    device = Device(model_from_document(document, "test"))
    sender, receiver = Sender(), Receiver(Direction.DEVICE_TO_HOST)
    for number in range(100):
        for message in receiver.receive(device.tick(sender.encode(SetPoint(1.0, 1.0, number, True, True)))):
            if isinstance(message, FeedbackInner):
                assert message == FeedbackInner(0.0, 0.0)
            if isinstance(message, MotorStatusInner):
                assert message == MotorStatusInner(0.0, 0.0, 0.0, BrakeState.ABSENT, False)
    assert device.torques_nm == (0.0,)


@given(st.lists(st.binary(max_size=200), max_size=30))
def test_bytes_of_any_kind_neither_raise_nor_move_anything(blocks: list[bytes]) -> None:
    device = Device(bench_model())
    for block in blocks:
        assert len(device.tick(block)) % RECORD_SIZE == 0
    assert device.state in (DriveState.NOT_READY, DriveState.SWITCH_ON_DISABLED)
    assert device.torques_nm == (0.0, 0.0)


def test_of_a_flood_the_newest_frames_count() -> None:
    device = Device(bench_model())
    good = Sender().encode(SetPoint(0.0, 0.0, 321, True, True))
    device.tick(b"\xff" * 200_000 + good)
    assert device.set_points == (1, 0)
    assert device.bad_frames > 6000


def test_a_corrupted_set_point_is_counted_and_changes_nothing() -> None:
    device = Device(bench_model())
    block = bytearray(Sender().encode(SetPoint(1.0, 1.0, 5, True, True)))
    for bit in range(16, 80):
        damaged = bytearray(block)
        damaged[bit // 8] ^= 1 << (bit % 8)
        device.tick(bytes(damaged))
    assert device.set_points == (0, 0)
    assert device.bad_frames == 64


def test_a_copied_state_goes_on_bit_for_bit() -> None:
    first, second = bench().enable(), bench().enable()
    first.run(50, (1.0, -0.5))
    for name in ("X", "drive_words"):
        getattr(second.device, name)[:] = getattr(first.device, name)
    second.sequence = first.sequence
    for _ in range(200):
        first.tick((-1.0, 0.5))
        second.tick((-1.0, 0.5))
    assert first.device.X.tobytes() == second.device.X.tobytes()
    assert first.device.drive_words.tobytes() == second.device.drive_words.tobytes()


def test_interpreted_and_compiled_devices_give_the_same_bits() -> None:
    assert run_interpreted("tests.device.random_session").strip() == session(FrameWire())


def test_noise_follows_the_seed() -> None:
    def frames(seed: int) -> bytes:
        device = Device(bench_model(), seed=seed)
        return b"".join(device.tick() for _ in range(50))

    assert frames(1) == frames(1)
    assert frames(1) != frames(2)


def test_settings_follow_the_model() -> None:
    settings = FirmwareSettings.for_model(shipped_model())
    assert [axis.torque_limit_nm for axis in settings.axes] == [15.5, 6.6]
    assert settings.axes[0].inertia_kg_m2 == pytest.approx(0.5028)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("torque_limit_nm", 17.0),
        ("torque_limit_nm", float("nan")),
        ("travel_low_rad", 2.0),
        ("overspeed_rad_s", 30.0),
        ("brake_damping", -1.0),
    ],
)
def test_settings_that_cannot_be_are_refused_by_name(key: str, value: float) -> None:
    good = {"torque_limit_nm": 1.0, "inertia_kg_m2": 1.0, "travel_high_rad": 1.0}
    with pytest.raises(BadInputError, match=f"firmware.axes.0.{key}"):
        FirmwareSettings((DriveAxisSettings(**{**good, key: value}),)).check()


@pytest.mark.parametrize("path", sorted(shipped_file("models").glob("*.yaml")), ids=lambda path: path.stem)
def test_every_shipped_model_can_be_served(path: Path) -> None:
    device = Device(load_model(path))
    for _ in range(60):
        device.tick()
    assert device.state is DriveState.SWITCH_ON_DISABLED
