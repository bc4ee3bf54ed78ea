"""Known numbers that leave their uncertainty, those that nothing could tell, and what data do not see."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pytest

from gimbal_hil.knowledge.discrepancy import Request, diagnose, verdict_of
from gimbal_hil.knowledge.discrepancy.hypotheses import PLAUSIBLE, Cause, known_numbers
from gimbal_hil.knowledge.discrepancy.inquiry import Inquiry, Policy, State, refitted, squares_of
from gimbal_hil.knowledge.discrepancy.inquiry.prepare import as_stated, effect_names, prepared, recalibrated
from gimbal_hil.knowledge.discrepancy.search.release import _giving_way, numbers_instead
from gimbal_hil.knowledge.executor import open_executor
from sim_backend.model import AntennaModel, load_model, model_from_document
from tests.blind.files import SHIPPED_MODEL
from tests.discrepancy.test_logs_of_strangers import COULOMB, INERTIA, STEP, swing, table
from tests.parts import heavy_but


def arm(**more: object) -> AntennaModel:
    """One joint with a mass, whose numbers are known to 10 %; `more` are sections of its file."""
    axis = {
        "body": {"mass": 1.0, "inertia": {"zz": INERTIA}},
        "friction": {"coulomb": COULOMB, "breakaway": COULOMB, "viscous": 0.001},
        "encoder": {"step": STEP},
    }
    document = {"schema": 1, "name": "arm", "kind": "rotary", "incline_sine": 0.0, "uncertainty": "10%"}
    return model_from_document(document | {"axes": {"pan": axis}} | more, "arm")


@contextmanager
def _asked(*effects: str, times: float = 1.0) -> Iterator[tuple[Inquiry, State]]:
    """Two logs of the arm, whose torque is so many times what its model says, effects to look for, and what the
    known numbers leave.
    """
    logs = []
    for speed in (1.0, 0.8):
        t, torque, position = swing(10.0, noise=0.003, speed=speed)
        logs.append(table({"pan.torque": times * torque, "pan.position": position}, t))
    with open_executor(1, None) as executor:
        names = effect_names(effects, ())
        inquiry, _ = prepared(
            arm(), tuple(logs[:1]), tuple(logs[1:]), None, names, Policy(), executor, lambda text: None
        )
        yield recalibrated(inquiry, as_stated(inquiry))


def test_a_coordinate_that_data_do_not_see_goes_back_to_where_it_does_nothing() -> None:
    # upright, a centre of mass off the pivot weighs nothing: wherever a step led it, no data hold it there
    with _asked("static_unbalance") as (inquiry, null):
        (family,) = inquiry.families
        far = null.hypothesis.plus(Cause(family, (0.0, -300.0, 300.0)))
        assert np.abs(refitted(inquiry, null, far).hypothesis.causes[0].x).max() < 1.0


def test_a_number_that_no_effect_tells_may_go_as_far_as_is_plausible() -> None:
    rooms = {(known.axis, known.path): known.room for known in known_numbers(load_model(SHIPPED_MODEL))}
    assert rooms["outer", "body.inertia.yy"] == rooms["inner", "body.inertia.xx"] == PLAUSIBLE
    assert rooms["outer", "body.inertia.zz"] == rooms["inner", "friction.coulomb"] == 1.0


def test_numbers_make_up_for_a_gain_from_where_it_gives_way_to_them() -> None:
    with _asked("torque_gain", "coulomb", "inertia", times=1.2) as (inquiry, null):
        family = next(family for family in inquiry.families if family.effect == "torque_gain")
        state = refitted(inquiry, null, null.hypothesis.plus(Cause(family, (0.0,) * len(family.knobs))))
        led = _giving_way(inquiry, state, family.label)
        taken = np.sum(squares_of(refitted(inquiry, state, state.hypothesis.minus(0), rounds=0)))
        given = np.sum(squares_of(refitted(inquiry, state, led, rounds=0, leash=PLAUSIBLE)))
        instead = numbers_instead(inquiry, null, state, family.label)
    assert led.labels == () and given < 0.1 * taken
    assert instead is not None
    free, names = instead
    assert {name for name, _ in names} >= {"coulomb", "inertia"}
    assert np.sum(squares_of(free)) < 1.1 * np.sum(squares_of(state))


@pytest.mark.heavy
def test_two_numbers_that_are_off_are_told_as_themselves_each_beside_its_control() -> None:
    logs = []
    for speed in (1.0, 0.8):
        t, torque, position = swing(20.0, noise=0.001, coulomb=0.7 * COULOMB, speed=speed)
        logs.append(table({"pan.torque": 1.18 * torque, "pan.position": position}, t))
    model = arm()
    result = diagnose(Request(model, tuple(logs[:1]), tuple(logs[1:])))
    found = verdict_of(result)
    assert {e["name"] for e in found.document["effects"]} == {"coulomb", "inertia"}
    # both as shares of the whole gap, of which the second cause takes little
    assert all(e["best_control_gain"] < 0.5 * e["held_out_gain"] for e in found.document["effects"])


def test_centres_and_products_go_either_side_of_zero_also_from_there() -> None:
    model = load_model(SHIPPED_MODEL).with_numbers("outer", {"body.inertia.yz": 0.0, "body.cog.z": 0.0}, "CAD")
    known = {(k.axis, k.path): k for k in known_numbers(model)}
    for path in ("body.inertia.yz", "body.inertia.xz", "body.cog.z", "body.cog.x"):
        one, stated = known["outer", path], model.number("outer", path)
        spread = model.uncertainty("outer", path)
        ends = [one.moved(stated, side * one.trust) - stated for side in (-1.0, 1.0)]
        assert ends == pytest.approx([-spread, spread])
        assert one.coordinate(stated, stated + spread) == pytest.approx(one.trust)
    assert known["outer", "body.inertia.zz"].moved(2.0, 0.1) == pytest.approx(2.0 * math.exp(0.1))


def test_a_number_that_is_zero_floats_as_far_as_the_file_says_of_it() -> None:
    document = arm().document
    document["axes"]["pan"]["body"]["cog"] = {"z": {"value": 0.0, "uncertainty": 0.005}}
    document["axes"]["pan"]["actuator"] = {"offset": {"value": 0.0, "uncertainty": 0.02}}
    known = {k.path: k for k in known_numbers(model_from_document(document, "arm"))}
    assert known["body.cog.z"].moved(0.0, -known["body.cog.z"].trust) == pytest.approx(-0.005)
    assert known["actuator.offset"].moved(0.0, known["actuator.offset"].reach) == pytest.approx(0.02)
    assert "body.cog.x" not in known


@pytest.mark.parametrize(
    "actuator",
    [{"torque_constant": {"value": 0.12, "uncertainty": "15%"}}, {"gain_error": {"value": 0, "uncertainty": 0.15}}],
)
@pytest.mark.parametrize("ripple", heavy_but((0.01,), (0.0, 0.01)))
def test_a_gain_that_is_known_to_a_share_moves_within_it_and_nothing_is_told_in_its_place(
    ripple: float, actuator: dict[str, object]
) -> None:
    logs = []
    for speed in (1.0, 0.8):
        t, torque, position = swing(20.0, noise=0.001, speed=speed)
        commanded = (torque + ripple * np.sin(9.0 * position)) / 1.1
        logs.append(table({"pan.torque": commanded, "pan.position": position}, t))
    document = arm().document | {"uncertainty": "1%"}
    document["axes"]["pan"]["actuator"] = actuator
    found = verdict_of(
        diagnose(Request(model_from_document(document, "arm"), tuple(logs[:1]), tuple(logs[1:])))
    ).document
    assert [e["name"] for e in found["effects"]] == (["cogging"] if ripple else [])
    moved = {one["path"]: one["to"] for one in found["recalibrated"]}
    assert moved["actuator.gain_error"] == pytest.approx(0.1, abs=0.02)
    assert moved.get("friction.coulomb", COULOMB) == pytest.approx(COULOMB, rel=0.02)


def test_a_gain_of_which_the_file_says_nothing_stays() -> None:
    assert not [known for known in known_numbers(arm()) if known.path == "actuator.gain_error"]
