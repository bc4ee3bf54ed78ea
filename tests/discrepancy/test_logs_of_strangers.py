"""Logs as strangers bring them: a joint that stands, a torque known in part, laps with a lead-in, other rates."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.discrepancy import Request, diagnose, verdict_of
from gimbal_hil.knowledge.discrepancy.hypotheses.evidence import noise_of_motion, transmitted
from gimbal_hil.knowledge.discrepancy.hypotheses.hypothesis import Cause, Hypothesis, KnownNumber
from gimbal_hil.knowledge.discrepancy.inquiry.inquiry import refitted, settled, squares_of
from gimbal_hil.knowledge.discrepancy.inquiry.policy import Policy
from gimbal_hil.knowledge.discrepancy.inquiry.prepare import (
    as_stated,
    effect_names,
    prepared,
    recalibrated,
    useful_band,
)
from gimbal_hil.knowledge.discrepancy.judgement.intervals import number_intervals
from gimbal_hil.knowledge.discrepancy.noise.floors import encoder_share, repeat_floor, spectral_floor, wide_twin
from gimbal_hil.knowledge.discrepancy.noise.processing import balanced, processing_floors
from gimbal_hil.knowledge.discrepancy.noise.row_noise import held_squares, moves, row_scales
from gimbal_hil.knowledge.discrepancy.search.release import given_back
from gimbal_hil.knowledge.discrepancy.twin.number_slots import turned_inertia
from gimbal_hil.knowledge.discrepancy.twin.record import record_of
from gimbal_hil.knowledge.discrepancy.twin.smoothing import Floats
from gimbal_hil.knowledge.discrepancy.twin.twin import Twin
from gimbal_hil.knowledge.executor import open_executor
from sim_backend.model import AntennaModel, model_from_document

INERTIA, COULOMB, STEP = 0.01, 0.05, 9.6e-5


def arm(coulomb: object = COULOMB, step: float = STEP, inertia: float = INERTIA, **actuator: object) -> AntennaModel:
    """One joint without a bristle."""
    axis = {
        "body": {"inertia": {"zz": inertia}},
        "friction": {"coulomb": coulomb, "breakaway": coulomb, "viscous": 0.001},
        "encoder": {"step": step},
    } | ({"actuator": actuator} if actuator else {})
    return model_from_document({"schema": 1, "name": "arm", "kind": "rotary", "axes": {"pan": axis}}, "arm")


def two_joints(**effect: object) -> AntennaModel:
    """A pan joint and one on it that stands."""
    axis = {
        "body": {"inertia": dict.fromkeys(("xx", "yy", "zz"), 0.5 * INERTIA)},
        "friction": {"coulomb": COULOMB, "breakaway": COULOMB, "viscous": 0.001},
        "encoder": {"step": STEP},
    }
    document = {"schema": 1, "name": "two", "kind": "gimbal", "axes": {"pan": axis, "tilt": axis | {"parent": "pan"}}}
    return model_from_document(document | effect, "two")


def swing(
    seconds: float = 8.0,
    rate_hz: float = 1000.0,
    noise: float = 0.0,
    coulomb: float = COULOMB,
    step: float = STEP,
    speed: float = 1.0,
) -> tuple[Floats, ...]:
    """Time, torque and encoder position of the arm as it swings both ways."""
    t = np.arange(round(seconds * rate_hz)) / rate_hz
    middle = t + 0.5 / rate_hz
    angle = [0.8 * np.sin(2.0 * speed * x) + 0.3 * np.sin(5.1 * speed * x) for x in (t, middle)]
    rate = speed * (1.6 * np.cos(2.0 * speed * middle) + 1.53 * np.cos(5.1 * speed * middle))
    torque = -INERTIA * speed**2 * (3.2 * np.sin(2.0 * speed * middle) + 7.803 * np.sin(5.1 * speed * middle))
    torque += coulomb * np.sign(rate) + 0.001 * rate + noise * np.random.default_rng(1).standard_normal(len(t))
    return t, torque, np.round(angle[0] / step) * step


def table(columns: dict[str, Any], time_s: Any, repeat: np.ndarray | None = None) -> SignalsTable:
    return SignalsTable.of(tuple(dict.fromkeys(name.split(".")[0] for name in columns)), time_s, columns, repeat)


def twin_of(model: AntennaModel, log: SignalsTable, hz: float = 25.0) -> Twin:
    return Twin(model, (record_of(log, model, hz, "log"),))


def floor_of(model: AntennaModel, log: SignalsTable, hz: float, channel: int = 0) -> float:
    twin = twin_of(model, log, hz)
    structure = twin.structure(())
    wide = wide_twin(twin, (log,))
    return spectral_floor(wide, structure, structure.P, twin.channels[channel], twin.records[0].bands)


def test_a_torque_that_is_known_in_part_leaves_the_processing_floor_as_it_is() -> None:
    t, torque, position = swing(noise=0.001)
    known = 0.4 * np.cos(position)
    plain = table({"pan.torque": torque, "pan.position": position}, t)
    told = table({"pan.torque": torque + known, "pan.position": position, "pan.torque_known": known}, t)
    assert "pan.torque_known" not in balanced(twin_of(arm(), told), told, 0).columns
    floors = [processing_floors(twin_of(arm(), log), (log,))[0] for log in (plain, told)]
    assert floors[1] < 3.0 * floors[0] + 1e-4


@pytest.mark.parametrize("held", [0.0, 0.01])
def test_a_joint_that_stands_has_a_floor_of_nothing_and_rows_that_say_little(held: float) -> None:
    t, torque, position = swing()
    still = {"tilt.torque": np.full(len(t), held), "tilt.position": np.zeros(len(t))}
    log = table({"pan.torque": torque, "pan.position": position} | still, t)
    model = two_joints()
    assert moves(log, "pan", model) and not moves(log, "tilt", model)
    assert floor_of(model, log, 25.0, channel=1) < 1e-9
    twin = twin_of(model, log)
    assert np.all(held_squares(twin, 0, log)[:, 1] == COULOMB**2)
    assert np.all(held_squares(twin, 0, log)[:, 0] == 0.0)
    assert np.all(row_scales(twin, (log,), np.array([1e-3, 1e-3]))[0][:, 1] >= COULOMB / 1e-3)


def test_a_joint_without_bristle_is_held_by_friction_while_it_rests() -> None:
    t, torque, position = swing()
    rest = (t > 3.0) & (t < 6.0)
    position = np.where(rest, position[np.argmax(rest)], position)
    log = table({"pan.torque": torque, "pan.position": position}, t)
    twin = twin_of(arm(), log)
    squares, rows = held_squares(twin, 0, log)[:, 0], twin.records[0].time_s[twin.records[0].keep]
    assert np.all(squares[(rows > 3.3) & (rows < 5.7)] == COULOMB**2)
    assert np.all(squares[(rows < 2.7) | (rows > 6.3)] == 0.0)


@pytest.mark.heavy
def test_a_gap_that_only_the_hold_out_has_is_searched_there_and_stays_a_guess() -> None:
    logs = []
    for speed in (0.1, 1.0):
        t, torque, position = swing(12.0, noise=0.002, speed=speed)
        logs.append(table({"pan.torque": torque, "pan.position": position}, t))
    result = diagnose(Request(arm(inertia=0.5 * INERTIA), (logs[0],), (logs[1],)))
    told = verdict_of(result).document
    assert result.only_in_hold_out and any("only the hold-out has a gap" in note for note in told["notes"])
    assert told["verdict"] == "ambiguous" and [one["name"] for one in told["effects"]] == ["inertia"]
    assert told["gap"]["before"] > 10.0 * told["gap"]["noise_floor"] and told["gap"]["closed_fraction"] > 0.9
    assert "Only the hold-out has this gap" in told["text"] and "last part of the same log" in told["text"]
    assert told["next_experiment"]["separates"][0] == "inertia"


@pytest.mark.parametrize(("ends", "seconds"), [("short", 1.8), ("short", 4.2), ("standing", 12.0)])
def test_a_hold_out_of_which_no_part_could_judge_is_left_whole(ends: str, seconds: float) -> None:
    t, torque, position = swing(20.0, noise=0.002, speed=0.1)
    fitted = table({"pan.torque": torque, "pan.position": position}, t)
    t, torque, position = swing(seconds, 250.0, noise=0.002)
    if ends == "standing":
        rest = t > 7.5
        torque, position = np.where(rest, 0.0, torque), np.where(rest, position[np.argmax(rest)], position)
    result = diagnose(
        Request(
            arm(inertia=0.5 * INERTIA),
            (fitted.rows(0, len(fitted)),),
            (table({"pan.torque": torque, "pan.position": position}, t),),
            only=("inertia",),
        )
    )
    assert not result.only_in_hold_out and not result.suspected_only


def test_an_encoder_that_flickers_on_a_joint_that_stands_narrows_nobodys_band() -> None:
    t, torque, position = swing(noise=0.003)
    flicker = STEP * (np.random.default_rng(3).random(len(t)) > 0.5)
    still = {"tilt.torque": np.zeros(len(t)), "tilt.position": flicker}
    model = two_joints()
    log = table({"pan.torque": torque, "pan.position": position} | still, t)
    moving = np.array([moves(log, axis, model) for axis in model.axes])
    assert list(moving) == [True, False]
    assert useful_band(twin_of(model, log), 25.0, moving) == 25.0


def test_a_log_that_rests_where_it_judges_is_refused() -> None:
    t, torque, position = swing()
    rest = t > 5.0
    torque, position = np.where(rest, 0.0, torque), np.where(rest, position[np.argmax(rest)], position)
    with pytest.raises(BadInputError, match="stands still where it judges"):
        diagnose(Request(arm(), (table({"pan.torque": torque, "pan.position": position}, t),)))


def test_of_an_axis_that_is_not_driven_nothing_is_cut_off() -> None:
    t, torque, position = swing()
    still = {"tilt.torque": np.zeros(len(t)), "tilt.position": np.zeros(len(t))}
    log = table({"pan.torque": torque, "pan.position": position} | still, t)
    model = two_joints(effects=[{"name": "transport_delay", "axis": "pan", "delay": 1e-4}])
    twin = twin_of(model, log)
    structure = twin.structure(())
    left = twin.evaluated(structure, structure.P, twin.records[0])
    assert np.all(transmitted(twin, structure, structure.P, 0, left)[:, 1] == 1.0)


def test_one_lap_after_a_lead_in_is_no_repeat_and_rows_outside_laps_are_none() -> None:
    t, torque, position = swing()
    columns = {"pan.torque": torque, "pan.position": position}
    lead_in = table(columns, t, np.where(t < 0.02, 0, 1))
    record = record_of(lead_in, arm(), 25.0, "log")
    residual = np.random.default_rng(1).standard_normal((int(record.keep.sum()), 1))
    assert repeat_floor(residual, record) is None
    laps = np.where(t < 1.0, -1, (t // 2.0).astype(int))
    record = record_of(table(columns, t, laps), arm(), 25.0, "log")
    found = repeat_floor(np.ones((int(record.keep.sum()), 1)), record)
    assert found is not None and found[0] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("rate_hz", [1000.0, 10000.0])
def test_a_floor_is_that_of_the_noise_at_any_rate(rate_hz: float) -> None:
    # an air bearing with a fine encoder, and a cause below the band in which noise is read
    t, torque, position = swing(8.0, rate_hz, coulomb=0.0, step=1e-8)
    noise = 0.003 * np.sqrt(rate_hz / 1000.0) * np.random.default_rng(4).standard_normal(len(t))
    model = arm(0.0, 1e-8)
    missing = 0.02 * np.sin(20.0 * position)
    one, other = (table({"pan.torque": torque + u, "pan.position": position}, t) for u in (noise, 0.0 * noise))
    left = [
        twin.unscaled(twin.structure(()), twin.structure(()).P, 0) for twin in (twin_of(model, x) for x in (one, other))
    ]
    true = float(np.sqrt(np.mean((left[0] - left[1]) ** 2)))
    log = table({"pan.torque": torque + noise + missing, "pan.position": position}, t)
    assert 0.8 * true < floor_of(model, log, 25.0) < 1.4 * true


def test_a_short_slow_log_has_a_floor_that_is_a_number() -> None:
    t, torque, position = swing(5.0, 50.0, 0.003)
    log = table({"pan.torque": torque, "pan.position": position}, t)
    assert 1e-5 < floor_of(arm(), log, 1.6) < 0.01


def test_a_log_that_is_too_short_for_the_band_is_left_out_with_a_note_and_alone_is_refused() -> None:
    logs = []
    for name, seconds in (("one.csv", 8.0), ("other.csv", 7.0), ("blink.csv", 0.25)):
        t, torque, position = swing(seconds, noise=0.001)
        logs.append(SignalsTable.of(("pan",), t, {"pan.torque": torque, "pan.position": position}, None, name))
    result = diagnose(Request(arm(), (logs[0], logs[2]), (logs[1],), only=("viscous",)))
    assert verdict_of(result).notes == ("blink.csv: too short for the scored band, left out",)
    with pytest.raises(BadInputError, match=r"blink\.csv: is too short"):
        diagnose(Request(arm(), (logs[2],), (logs[1],), only=("viscous",)))


def test_what_only_the_model_says_of_a_number_is_as_unsure_as_the_model() -> None:
    # in motion one way friction and an offset of the drive are one number
    t = np.arange(20000) * 1e-3
    rate = 0.4 + 0.2 * np.sin(1.3 * (t + 5e-4))
    position = 0.4 * t + 0.2 / 1.3 * (1.0 - np.cos(1.3 * t))
    torque = INERTIA * 0.26 * np.cos(1.3 * t) + COULOMB + 0.001 * rate - 0.01
    torque += 0.002 * np.random.default_rng(2).standard_normal(len(t))
    log = table({"pan.torque": torque, "pan.position": position}, t)
    unsure = {"value": COULOMB, "uncertainty": "20%"}
    model = arm(unsure, offset={"value": 0.01, "unit": "N m", "uncertainty": 0.01, "source": "assumed"})
    with open_executor(1, None) as executor:
        inquiry, _ = prepared(model, (log,), (log,), None, effect_names((), ()), Policy(), executor, lambda text: None)
        inquiry, state = recalibrated(inquiry, as_stated(inquiry))
        intervals = dict(
            zip((k.path for k in state.hypothesis.floating), number_intervals(inquiry, state), strict=True)
        )
    low, high = intervals["friction.coulomb"]
    # in shares of the level: the prior of 20 % beside an offset that may take as much
    assert 0.1 < 0.5 * (high - low) < 1.0


def test_the_floor_of_a_narrow_band_is_not_read_where_the_encoder_hides_it() -> None:
    # noise of the drive, which from 30 Hz on lies far under the encoder's
    t, torque, position = swing(30.0, noise=0.002, coulomb=0.0, step=1e-9)
    position += 0.3 * STEP * np.random.default_rng(2).standard_normal(len(t))
    log = table({"pan.torque": torque, "pan.position": position}, t)
    twin = twin_of(arm(coulomb=0.0), log, 6.25)
    structure = twin.structure(())
    inside = float(np.sqrt(np.mean(twin.residual(structure, structure.P) ** 2)))
    for hz in (6.25, 12.5, 25.0):
        wide = wide_twin(twin, (log,), hz)
        found = spectral_floor(wide, structure, structure.P, twin.channels[0], twin.records[0].bands)
        assert found == pytest.approx(inside, rel=0.25)


def test_what_could_stand_in_a_name_s_place_is_compared_at_its_best() -> None:
    # in slow motion a gain that is off is nearly a Coulomb level that is off
    logs = []
    for speed in (0.4, 0.32):
        t, torque, position = swing(20.0, noise=0.003, coulomb=1.4 * COULOMB, speed=speed)
        logs.append(table({"pan.torque": torque, "pan.position": position}, t))
    result = diagnose(Request(arm(coulomb={"value": COULOMB, "uncertainty": "10%"}), (logs[0],), (logs[1],)))
    (told,) = result.told
    assert told.standing.label == ("coulomb", "pan")
    (gain,) = (rival for rival in told.standing.rivals if rival.label == ("torque_gain", "pan"))
    again = settled(result.inquiry, gain.state)
    assert float(np.sum(squares_of(again))) > 0.95 * float(np.sum(squares_of(gain.state)))


@pytest.mark.parametrize(("level", "left"), [(1.1, ()), (1.5, (("coulomb", "pan"),))])
def test_a_number_inside_its_uncertainty_is_known_and_no_cause(level: float, left: tuple[tuple[str, str], ...]) -> None:
    logs = []
    for speed in (1.0, 0.8):
        t, torque, position = swing(10.0, noise=0.003, coulomb=level * COULOMB, speed=speed)
        logs.append(table({"pan.torque": torque, "pan.position": position}, t))
    model = arm(coulomb={"value": COULOMB, "uncertainty": "20%"})
    with open_executor(1, None) as executor:
        inquiry, _ = prepared(
            model, logs[:1], logs[1:], None, effect_names(("coulomb",), ()), Policy(), executor, lambda text: None
        )
        inquiry, null = recalibrated(inquiry, as_stated(inquiry))
        (family,) = inquiry.families
        named = settled(
            inquiry, refitted(inquiry, null, null.hypothesis.plus(Cause(family, (0.0,) * len(family.knobs))))
        )
        found = given_back(inquiry, named)
    assert found.hypothesis.labels == left
    if not left:
        moved = {known.path: y for known, y in zip(found.hypothesis.floating, found.hypothesis.y, strict=True)}
        assert np.exp(moved["friction.coulomb"]) == pytest.approx(level, abs=0.01)


@pytest.mark.parametrize(("torque_noise", "position_noise", "share"), [(0.01, 0.0, 0.0), (0.0, 1e-3, 1.0)])
def test_more_inertia_makes_more_noise_of_the_encoders_error_and_none_of_the_torques(
    torque_noise: float, position_noise: float, share: float
) -> None:
    t, torque, position = swing(12.0, noise=torque_noise, step=1e-7)
    position = position + position_noise * np.random.default_rng(2).standard_normal(len(t))
    log, model = table({"pan.torque": torque, "pan.position": position}, t), arm(step=1e-7)
    twin = twin_of(model, log)
    structure = twin.structure(())
    found = encoder_share(wide_twin(twin, (log,)), structure, structure.P, twin.channels[0], twin.records[0].bands)
    assert found == pytest.approx(share, abs=0.1)
    # twice the inertia, and half of it
    heavier, lighter = (
        Hypothesis(floating=(KnownNumber("pan", "body.inertia.zz", 1.0),), y=(math.log(factor),))
        for factor in (2.0, 0.5)
    )
    assert noise_of_motion(twin, heavier, found)[0] == pytest.approx(1.0 + share, abs=0.15)
    assert noise_of_motion(twin, lighter, found)[0] == 1.0
    # what a joint carries it accelerates too
    both = two_joints()
    columns = {f"{axis}.{signal}": torque for axis in both.axes for signal in ("torque", "position")}
    P = twin_of(both, table(columns, t)).structure(()).P
    assert turned_inertia(both, P, "pan") == pytest.approx(INERTIA)
    assert turned_inertia(both, P, "tilt") == pytest.approx(0.5 * INERTIA)
