"""Every effect says how it is searched, and never beyond what the catalogue allows."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from gimbal_hil.knowledge.discrepancy.hypotheses import Cause, Family
from sim_backend.effects import (
    CATALOGUE,
    AxisScale,
    Domain,
    Effect,
    Hook,
    Knob,
    Move,
    Need,
    Parameter,
    Variable,
    confused_with,
)
from sim_backend.effects.default_search import default_profile, unit_scale
from sim_backend.model import shipped_model

every_effect = pytest.mark.parametrize("effect", CATALOGUE.values(), ids=lambda effect: effect.name)
EVERYTHING = Need.GYRO | Need.MOVING_BASE | Need.TEMPERATURE | Need.TORQUE_REVERSALS | Need.SECOND_AXIS | Need.SLIDING


def scale(axis: str = "outer") -> AxisScale:
    """An axis of the shipped model that has been through some ordinary data."""
    model = shipped_model()
    numbers = {path: quantity.value for (owner, path), quantity in model.numbers.items() if owner == axis}
    numbers["body.own_inertia"] = numbers[model.own_inertia_path(axis)]
    levels = (1.0, 1.2, 1.4, 1.6, 1.8, 1.9)
    return AxisScale(0.7, 2.0, levels, 1.5, -0.4, 1.2, numbers, False, 2, model.axes.index(axis), EVERYTHING)


def effect_of(*parameters: Parameter, hook: Hook | None = Hook.TORQUE, **more: object) -> Effect:
    return Effect("guest", Domain.DRIVE, parameters, "text", "equation", "source", "a run", hook, **more)  # type: ignore[arg-type]


@every_effect
def test_an_effect_is_searched_from_starts_that_lie_inside_its_bounds(effect: Effect) -> None:
    profile = effect.profile(scale())
    assert profile is not None and profile.knobs and (profile.starts or profile.ripple)
    for start in profile.starts:
        for x in (start.base, *start.probes):
            assert len(x) == len(profile.knobs)
            assert all(knob.low <= value <= knob.high for knob, value in zip(profile.knobs, x, strict=True))


@pytest.mark.parametrize("is_linear", [False, True])
@pytest.mark.parametrize("stated", [1.0, 0.01, 5e-3, 1e-3, 1e-4])
def test_without_a_bristle_a_bump_at_a_speed_of_which_the_model_says_nothing_stands_at_its_bound(
    stated: float, is_linear: bool
) -> None:
    here = scale()
    numbers = {**here.numbers, "friction.sigma0": 0.0, "friction.stribeck_velocity": stated}
    rigid = replace(here, numbers=numbers, is_linear=is_linear)
    lowest = 2e-4 if is_linear else 4e-3
    assert (rigid.least_stated_speed, here.least_stated_speed) == (lowest, 0.0)
    profile = CATALOGUE["stribeck"].profile(rigid)
    assert profile is not None
    which = next(i for i, knob in enumerate(profile.knobs) if knob.parameters == ("stribeck_velocity",))
    knob = profile.knobs[which]
    assert knob.moved(stated, knob.low) == pytest.approx(max(lowest, stated * math.exp(-3.5)))
    assert knob.moved(stated, 0.0) == pytest.approx(max(lowest, stated))
    assert all(start.base[which] >= knob.low for start in profile.starts)
    family = Family(**vars(profile), effect="stribeck", axis="outer")
    slowest = Cause(family, tuple(knob.low if i == which else 0.1 for i in range(len(profile.knobs))))
    assert slowest.knobs_at_bound == ("stribeck_velocity",)


def test_a_backlash_takes_inertia_from_the_joint_and_adds_none() -> None:
    profile = CATALOGUE["backlash"].profile(scale())
    assert profile is not None
    (taken,) = (knob for knob in profile.knobs if knob.along == "body.own_inertia")
    own = scale().own_inertia
    assert taken.moved(own, taken.high) <= 1.05 * own and taken.moved(own, taken.low) < 0.1 * own


@every_effect
def test_no_coordinate_leads_a_parameter_out_of_the_catalogues_bounds(effect: Effect) -> None:
    here = scale()
    profile = effect.profile(here)
    assert profile is not None
    for knob in profile.knobs:
        for parameter in (p for p in effect.parameters if p.name in knob.parameters and not p.periodic):
            base = here.numbers[parameter.path] if parameter.path is not None else parameter.neutral
            mirrored = any(p.half_turn_of == parameter.name for p in effect.parameters)
            for x in (max(knob.low, -50.0), min(knob.high, 50.0)):
                value = abs(knob.moved(base, x)) if mirrored else knob.moved(base, x)
                room = 1e-9 * max(abs(parameter.low), abs(parameter.high))
                assert min(parameter.low, base) - room <= value <= max(parameter.high, base) + room


@pytest.mark.parametrize("torque", [1e-3, 1.0, 50.0])
def test_steps_follow_from_the_torque_where_a_model_states_no_size(torque: float) -> None:
    numbers = scale().numbers | {"body.mass": 1.0} | {f"body.cog.{c}": 0.0 for c in "xyz"}  # type: ignore[operator]
    here = replace(scale(), torque_rms=torque, numbers=numbers)
    # numbers of a cause are held loosely, at a hundred steps: a step is a few per cent of the torque
    unbalance, spring = (CATALOGUE[name].profile(here) for name in ("static_unbalance", "cable_spring"))
    assert unbalance is not None and spring is not None
    assert 0.02 < unbalance.knobs[0].size * 9.8 / torque < 0.1
    assert 0.02 < spring.knobs[0].size * here.travel / torque < 0.2


@every_effect
def test_an_effect_says_what_it_acts_through_and_names_that_exist(effect: Effect) -> None:
    assert effect.acts_through and effect.unseen
    others = {effect.same_by_command, effect.plainer.name if effect.plainer else None} - {None}
    assert others <= set(CATALOGUE) - {effect.name}
    names = {p.name for p in effect.parameters}
    assert {p.half_turn_of for p in effect.parameters} <= names | {None}
    assert {name for name, _, _ in effect.plainer.where} <= names if effect.plainer else True


def test_confusion_is_mutual() -> None:
    for name in CATALOGUE:
        assert all(name in confused_with(other) for other in confused_with(name))
    assert "encoder_eccentricity" in confused_with("cogging") and confused_with("back_emf") == ("viscous",)


@pytest.mark.parametrize(("need", "one_of_them"), [(Need.GYRO, "gyro_bias"), (Need.SLIDING, "coulomb")])
def test_without_a_gyro_or_sliding_nothing_that_only_shows_there_is_searched(need: Need, one_of_them: str) -> None:
    blind = replace(scale(), present=EVERYTHING & ~need)
    absent = {name for name, effect in CATALOGUE.items() if effect.profile(blind) is None}
    assert absent == {name for name, effect in CATALOGUE.items() if need in effect.needs} and one_of_them in absent


def test_on_one_linear_axis_neither_gravity_by_turning_nor_a_second_axis_is_searched() -> None:
    slide = replace(scale(), is_linear=True, axis_count=1)
    absent = {name for name, effect in CATALOGUE.items() if effect.profile(slide) is None}
    assert absent == {name for name, effect in CATALOGUE.items() if effect.rotary_only or effect.two_axis_only}


def test_a_ripple_of_one_turn_has_a_plainer_name_and_one_of_twelve_has_not() -> None:
    plainer = CATALOGUE["cogging"].plainer
    assert (
        plainer is not None
        and plainer.holds({"amplitude": 0.1, "order": 1.02})
        and not plainer.holds({"amplitude": 0.1, "order": 12.0})
    )


def test_a_knob_that_moves_by_factors_keeps_what_has_a_sign() -> None:
    knob = Knob(("width",), Move.FACTOR).within(0.01, 2.0, 0.1)
    assert knob.moved(0.1, knob.low) == pytest.approx(0.01) and knob.moved(0.1, knob.high) == pytest.approx(2.0)
    level = Knob(("limit",), Move.LEVEL, 3.0)
    assert level.moved(99.0, 0.0) == 3.0


def test_units_amount_to_what_the_data_have() -> None:
    here = scale()
    place = 0.6
    assert unit_scale("N m", here) == pytest.approx(here.torque_rms)
    assert unit_scale("N m s/rad", here) == pytest.approx(here.torque_rms / here.speed)
    assert unit_scale("N m/rad3", here) == pytest.approx(here.torque_rms / place**3)
    assert unit_scale("kg m2", here) == here.own_inertia
    assert unit_scale("1", here) == 1.0
    slide = replace(here, is_linear=True)
    assert unit_scale("N/m", slide) == pytest.approx(here.torque_rms / place)


def test_what_only_shapes_an_effect_is_tried_on_a_grid_and_its_strength_from_nothing() -> None:
    pull = Parameter("pull", "N m", 0.0, 1e3, 0.0, "how strong")
    place = Parameter("place", "rad", -10.0, 10.0, 0.0, "where")
    profile = default_profile((place, pull), scale())
    assert profile is not None and [k.parameters for k in profile.knobs] == [("pull",), ("place",)]
    places = [profile.knobs[1].moved(0.0, start.base[1]) for start in profile.starts]
    assert -0.4 < min(places) < -0.3 and 1.1 < max(places) < 1.2 and np.ptp(np.diff(places)) < 1e-9
    assert all(start.base[0] == 0.0 and start.probes == ((1.0, start.base[1]),) for start in profile.starts)


def test_a_strength_with_an_angle_is_read_in_both_quarters() -> None:
    push = Parameter("push", "N m", -50.0, 50.0, 0.0, "largest torque")
    angle = Parameter("direction", "rad", -math.pi, math.pi, 0.0, "where from", periodic=True)
    profile = effect_of(push, angle).profile(scale())
    assert profile is not None and len(profile.starts) == 1
    assert profile.starts[0].coordinates(np.array([3.0, 4.0])) == pytest.approx((5.0, math.atan2(4.0, 3.0)))


def test_a_number_of_the_model_moves_from_where_it_stands() -> None:
    noise = Parameter("viscous", "N m s/rad", 0.0, 1e6, 0.0, "another name for it", path="friction.viscous")
    profile = effect_of(noise, hook=None).profile(scale())
    assert profile is not None
    base = scale().numbers["friction.viscous"]
    assert profile.knobs[0].moved(base, profile.knobs[0].low) == pytest.approx(0.0, abs=1e-15)
    assert profile.knobs[0].size == pytest.approx(0.05 * base)


def test_an_effect_that_does_not_say_acts_through_what_its_place_is_given() -> None:
    push = Parameter("push", "N m", -50.0, 50.0, 0.0, "largest torque")
    assert effect_of(push).acts_through == {Variable.POSITION, Variable.RATE}
    assert effect_of(push, states=2).acts_through == {Variable.POSITION, Variable.RATE, Variable.PAST}
