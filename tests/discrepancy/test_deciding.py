"""How sure a name is said to be follows what speaks for it and against it, each alone."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from gimbal_hil.knowledge.discrepancy.inquiry.policy import Policy
from gimbal_hil.knowledge.discrepancy.judgement import deciding, judging
from gimbal_hil.knowledge.discrepancy.judgement.deciding import Status, Told, class_probability, rejudged
from gimbal_hil.knowledge.discrepancy.judgement.exhaustion import Predictable
from gimbal_hil.knowledge.discrepancy.judgement.judging import Remainder, Standing
from gimbal_hil.knowledge.discrepancy.judgement.rivals import Rival
from gimbal_hil.knowledge.discrepancy.search import curve
from gimbal_hil.knowledge.discrepancy.search.comparing import clearly_better, same_to_a_twin
from gimbal_hil.knowledge.estimation import Paired
from sim_backend.effects import NEUTRAL_ORDER, Ripple

_NOTHING = Predictable(0.0, 0.0)
#: a cause that takes nearly all of a gap of ten floors
SOUND = Standing(
    (0,), ("cable_spring", "outer"), Paired(90.0, 0.9, 0.1, 40), 12.0, 0.95, 0.0, (), _NOTHING, (), False, 0, 90.0,
    np.array([90.0]), True, False, 0.0, 0.02, 1.0,
)  # fmt: skip


def probability(standing: Standing, left: Remainder) -> float:
    return class_probability(standing, left, Policy(), 30)


def test_a_cause_that_leaves_noise_is_nearly_sure() -> None:
    assert probability(SOUND, Remainder(10.0, 1.0, _NOTHING)) > 0.95


@pytest.mark.parametrize(
    ("change", "left"),
    [
        ({"sure": 1.0}, Remainder(10.0, 1.0, _NOTHING)),
        ({"any_curve": True}, Remainder(10.0, 1.0, _NOTHING)),
        # the model leaves no gap where it acts
        ({"explains": False}, Remainder(1.3, 1.0, _NOTHING)),
        # its own variables still predict what is left
        ({"exhausted": Predictable(0.8, 0.0)}, Remainder(10.0, 3.0, _NOTHING)),
        # others predict four fifths of what is left, and that is half of what it takes
        ({"share": 0.62}, Remainder(10.0, 6.0, Predictable(0.8, 0.0))),
        ({"share": 0.01}, Remainder(10.0, 9.9, _NOTHING)),
        # its strength is another from stretch to stretch
        ({"uneven": 0.4}, Remainder(10.0, 1.0, _NOTHING)),
        # the interval of its strength holds nothing
        ({"error": 1.2}, Remainder(10.0, 1.0, _NOTHING)),
        # it does thirty times what was there, which others undo
        ({"does": 30.0}, Remainder(10.0, 1.0, _NOTHING)),
    ],
)
def test_each_doubt_alone_takes_a_name_away(change: dict, left: Remainder) -> None:
    assert probability(replace(SOUND, **change), left) < 0.5


@pytest.mark.parametrize(("uneven", "is_name"), [(0.0, True), (0.06, True), (0.15, False)])
def test_a_strength_that_varies_takes_a_name_before_it_takes_the_cause(uneven: float, is_name: bool) -> None:
    told = probability(replace(SOUND, uneven=uneven), Remainder(10.0, 1.0, _NOTHING))
    assert told > 0.5 and (told >= Policy().named) is is_name


def test_what_is_no_gap_says_nothing_against_what_closed_one() -> None:
    predictable = replace(SOUND, exhausted=Predictable(0.96, 0.0))
    # by itself or as a member of a set: another variable predicts all of what is left, or nothing does
    for left in (Remainder(7.0, 1.4, Predictable(0.9, 0.0)), Remainder(3.0, 1.45, _NOTHING)):
        assert probability(replace(predictable, share=0.3, takes=np.array([0.5])), left) > 0.9
    # of a gap of 1.6 floors a bristle closed a third, and its own variables predict as much of what is left
    hardly = replace(SOUND, share=0.37, takes=np.array([0.81]), exhausted=Predictable(0.6, 0.0))
    assert probability(hardly, Remainder(1.59, 1.25, _NOTHING)) < 0.6
    # and what the fitted logs show alone, nothing of the hold-out speaks against
    assert probability(replace(SOUND, exhausted=Predictable(0.3, 0.0)), Remainder(1.0, 1.01, _NOTHING)) > 0.95
    assert probability(predictable, Remainder(12.0, 1.6, _NOTHING)) < 0.5


def test_what_is_left_above_the_gap_takes_no_name_from_a_cause_that_took_a_thousand_times_as_much() -> None:
    shaped = replace(SOUND, exhausted=Predictable(0.5, 0.0))
    left = Remainder(65.0, 2.5, Predictable(0.5, 0.0))
    assert probability(replace(shaped, share=0.999), left) > 0.9
    # a spring in the place of a stop that hardens takes 19 of 20 parts, or leaves many floors of another shape
    assert probability(shaped, Remainder(13.0, 3.0, _NOTHING)) < 0.5
    assert probability(replace(shaped, share=0.98), Remainder(70.0, 10.0, _NOTHING)) < 0.5


@pytest.mark.parametrize(
    ("takes", "least", "most"), [(90.0, 0.94, 1.0), (3.0, 0.85, 0.94), (2.0, 0.5, 0.6), (0.3, 0.0, 0.1)]
)
def test_what_nothing_predicts_counts_by_what_a_cause_takes(takes: float, least: float, most: float) -> None:
    # a third of a squared floor beside fifteen that nobody knows is no name, however large another cause was
    left = Remainder(100.0, 4.0, _NOTHING)
    assert least < probability(replace(SOUND, takes=np.array([takes])), left) < most


@pytest.mark.parametrize(
    ("unknown", "least", "most"), [(0.0, 0.9, 1.0), (18.0, 0.8, 0.9), (30.0, 0.5, 0.8), (60.0, 0.0, 0.5)]
)
def test_a_cause_not_much_larger_than_what_stands_at_its_bound_is_no_name(
    unknown: float, least: float, most: float
) -> None:
    left = Remainder(10.0, 1.0, _NOTHING)
    assert least < class_probability(SOUND, left, Policy(), 30, unknown) < most


def test_what_others_predict_beside_a_cause_hardly_counts_where_it_is_small() -> None:
    # a ripple of a third of a gap, left beside a drag that takes nine tenths of the squares
    assert probability(replace(SOUND, share=0.9), Remainder(10.0, 3.2, Predictable(0.5, 0.0))) > 0.8


def test_what_nothing_predicts_is_no_sign_of_another_cause() -> None:
    much = replace(SOUND, share=0.62)
    unpredicted = probability(much, Remainder(10.0, 6.0, Predictable(-0.2, -0.4)))
    assert unpredicted == probability(much, Remainder(10.0, 6.0, _NOTHING)) > 0.5


def test_a_rival_that_contains_the_cause_and_hardly_pays_for_its_numbers_is_no_doubt() -> None:
    state: Any = SimpleNamespace(hypothesis=SimpleNamespace(labels=()))
    offset = replace(SOUND, label=("torque_offset", "outer"))
    told = Told(offset, Status.AMBIGUOUS, (), 0.96, 0.96, shown=True)
    spring = Rival(state, (("cable_spring", "outer"),), -0.05, -0.4, same=True, less=0.2, plainer="torque_offset")
    named = rejudged(Policy(), told, (spring,))
    assert named.status is Status.NAMED and named.close == ()
    # surely, but by less than what a cause must take to be added
    assert rejudged(Policy(), told, (replace(spring, sure=-3.5, less=0.05),)).status is Status.NAMED
    for doubt in (replace(spring, plainer=None), replace(spring, sure=-3.5)):
        assert rejudged(Policy(), told, (doubt,)).status is Status.AMBIGUOUS


def test_a_cause_at_its_bound_is_as_likely_something_else_that_acts_like_it() -> None:
    told = Told(replace(SOUND, at_bound=("gap",)), Status.AMBIGUOUS, (), 0.96, 0.96, shown=False)
    found = rejudged(Policy(), told, ())
    assert (found.status, found.probability, found.of_class) == (Status.AMBIGUOUS, 0.48, 0.96)
    # neither its name nor, where there is one, an alternative
    assert found.of_names == pytest.approx(0.48)
    state: Any = SimpleNamespace(hypothesis=SimpleNamespace(labels=()))
    beside = rejudged(Policy(), told, (Rival(state, (("cogging", "outer"),), 0.0, 0.0, same=True),))
    assert (beside.probability, beside.of_names) == (pytest.approx(0.32), pytest.approx(0.64))
    assert replace(told, standing=SOUND).of_names == 0.96


@pytest.mark.parametrize(
    ("now", "kept"), [({}, True), ({"at_bound": ("limit",)}, False), ({"silent": True}, False)], ids=str
)
def test_what_was_named_beside_a_curve_stays_so_while_data_show_it(now: dict[str, Any], kept: bool) -> None:
    before = Told(SOUND, Status.NAMED, (), 0.96, 0.96, shown=True)
    standing = replace(SOUND, share=0.5, **now)
    told = Told(standing, Status.AMBIGUOUS, (), 0.7, 0.7, shown=not now)
    found = deciding._as_before({SOUND.label: before}, told)
    assert found == (replace(before, standing=standing) if kept else told)
    assert deciding._as_before({}, told) == told


@pytest.mark.parametrize(("over", "doubted"), [(Ripple.TORQUE, True), (Ripple.FRICTION, False), (None, False)])
def test_only_orders_of_a_torque_are_a_series_over_the_travel(
    over: Ripple | None, doubted: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    cause = SimpleNamespace(family=SimpleNamespace(ripple=over), x=(1.0, 1.0, 0.0))
    state: Any = SimpleNamespace(hypothesis=SimpleNamespace(causes=(cause,)))
    without: Any = SimpleNamespace(hypothesis=SimpleNamespace(plus=lambda cause: None))
    monkeypatch.setattr(judging, "orders_make_a_series", lambda *_: True)
    monkeypatch.setattr(judging, "refitted", lambda *_, **__: state)
    monkeypatch.setattr(judging, "curve_does_as_well", lambda *_: False)
    inquiry: Any = None
    assert judging._any_curve(inquiry, without, state, (0,)) is doubted


@pytest.mark.parametrize("over", [Ripple.TORQUE, Ripple.FRICTION])
@pytest.mark.parametrize(
    ("both_ways", "turns", "doubted"),
    [
        # half a period is any smooth curve of torque, and of friction where the joint moves one way
        (False, 0.5, {Ripple.TORQUE: True, Ripple.FRICTION: True}),
        (True, 0.5, {Ripple.TORQUE: True, Ripple.FRICTION: False}),
        (True, 6.0, {Ripple.TORQUE: False, Ripple.FRICTION: False}),
    ],
)
def test_a_smooth_curve_of_torque_stands_for_friction_only_where_a_joint_moves_one_way(
    over: Ripple, both_ways: bool, turns: float, doubted: dict[Ripple, bool]
) -> None:
    way = np.linspace(-1.0, 1.0, 2000)
    position = 0.5 * turns * 2.0 * np.pi * np.concatenate([way, way[::-1] if both_ways else way])
    rate = np.repeat([1.0, -1.0 if both_ways else 1.0], len(way))
    ripple = 5.0 * np.sin(position + 0.4) * (np.sign(rate) if over is Ripple.FRICTION else 1.0)
    noise = np.random.default_rng(2).standard_normal((2, len(position)))
    motion = np.column_stack([position, position, rate, rate])
    record = SimpleNamespace(name="", motion=motion, at_scored=lambda column: column)
    cause = SimpleNamespace(family=SimpleNamespace(ripple=over, axis="outer"))
    hypothesis = SimpleNamespace(causes=(cause,), origins=())

    def leaves(gap: np.ndarray) -> Any:
        held = (gap + noise[1])[:, None]
        return SimpleNamespace(
            hypothesis=hypothesis, held=hypothesis, fitted=(gap + noise[0])[:, None], held_out=lambda: held
        )

    channel = SimpleNamespace(axis="outer", signal="torque")
    twin = SimpleNamespace(model=SimpleNamespace(axes=("outer", "inner")), records=(record,), channels=(channel,))
    inquiry: Any = SimpleNamespace(twin=twin, holdout=twin, in_order=lambda state: state.held_out())
    assert curve.curve_does_as_well(inquiry, leaves(ripple), leaves(0.0 * ripple)) is doubted[over]


@pytest.mark.parametrize(("of_class", "named"), [(0.949, False), (0.951, True)])
def test_a_name_is_told_from_a_probability_of_95_per_cent(of_class: float, named: bool) -> None:
    found = rejudged(Policy(), Told(SOUND, Status.AMBIGUOUS, (), of_class, of_class, shown=True), ())
    assert (found.status is Status.NAMED) is named


@pytest.mark.parametrize(
    ("same", "sure", "share"), [(True, 1.9, 0.5), (False, 0.0, 0.5), (False, 1.0, 0.84), (False, 1.8, 0.96)]
)
def test_a_name_shares_its_class_by_the_odds_that_a_difference_is_chance(same: bool, sure: float, share: float) -> None:
    state: Any = SimpleNamespace(hypothesis=SimpleNamespace(labels=()))
    told = Told(SOUND, Status.AMBIGUOUS, (), 0.96, 0.96, shown=True)
    found = rejudged(Policy(), told, (Rival(state, (("cogging", "outer"),), 0.3, sure, same),))
    assert found.probability == pytest.approx(0.96 * share, abs=0.01)
    assert (found.status is Status.NAMED) == (share > 0.95)


@pytest.mark.parametrize(
    ("mine", "theirs", "without", "same"),
    [
        # what a floor is known to, of a small gap
        (1.0, 1.11, 4.0, True),
        (1.0, 1.13, 4.0, False),
        # both within their floor, which then lies above the noise, or one of them well beyond it
        (0.4, 0.9, 190.0, True),
        (0.4, 1.3, 190.0, False),
        # two per cent of what is left
        (50.0, 50.9, 60.0, True),
        (50.0, 51.1, 60.0, False),
        # two per cent of the rms of a cause of a hundred floors
        (1.0, 4.9, 1e4, True),
        (1.0, 5.1, 1e4, False),
    ],
)
def test_no_two_explanations_are_told_apart_by_less_than_a_twin_is_exact_to(
    mine: float, theirs: float, without: float, same: bool
) -> None:
    assert same_to_a_twin(Policy(), np.array([mine]), np.array([theirs]), np.array([without])) is same
    # channels that say nothing of it make it no smaller
    quiet = np.ones(3)
    four = (np.append(quiet, one) for one in (mine, theirs, without))
    assert same_to_a_twin(Policy(), *four) is same


@pytest.mark.parametrize(("noisier", "theirs", "same"), [(0.5, 1.4, True), (0.5, 1.6, False), (400.0, 2.1, False)])
def test_noise_that_comes_through_a_lag_tells_it_from_nothing(noisier: float, theirs: float, same: bool) -> None:
    one, other, without = np.array([1.0]), np.array([theirs]), np.array([4.0])
    assert same_to_a_twin(Policy(), one, other, without, np.array([noisier])) is same


@pytest.mark.parametrize(
    ("missing", "theirs", "same"),
    [
        (0.0, 6.0, False),
        # four tenths of what is left can be predicted: what the other one leaves more may be a part of that
        (0.4, 6.0, True),
        (0.4, 7.0, False),
        # nine tenths: but no more than a quarter of what the cause takes
        (0.9, 17.0, True),
        (0.9, 19.0, False),
    ],
)
def test_two_explanations_are_told_apart_by_more_than_what_both_lack(missing: float, theirs: float, same: bool) -> None:
    one, other, without = np.array([4.0]), np.array([theirs]), np.array([60.0])
    assert same_to_a_twin(Policy(), one, other, without, missing=np.array([missing])) is same


def _leaves(*floors: float) -> Any:
    """A state that leaves white noise of these sizes, a channel each."""
    rows = np.array(floors) * np.random.default_rng(4).standard_normal((4000, len(floors)))
    return SimpleNamespace(fit=SimpleNamespace(squares=np.mean(rows**2, axis=0)), fitted=rows, selecting=rows)


@pytest.mark.parametrize(
    ("new", "old", "better"),
    [
        # where the other channel had no gap, or one of a hundred floors
        ((1.0, 1.0), (1.0, 2.0), True),
        ((100.0, 1.0), (100.0, 2.0), True),
        ((1.0, 1.0), (1.0, 1.01), False),
        # much of one channel for little of the other
        ((1.0, 5.0), (40.0, 1.0), True),
        ((40.0, 1.0), (1.0, 5.0), False),
    ],
)
def test_a_state_is_better_by_what_is_left_of_each_channel(
    new: tuple[float, float], old: tuple[float, float], better: bool
) -> None:
    inquiry: Any = SimpleNamespace(
        policy=Policy(), split=lambda rows: [rows], split_held=lambda rows, selecting: [rows]
    )
    assert clearly_better(inquiry, _leaves(*new), _leaves(*old)) is better


@pytest.mark.parametrize(
    ("orders", "travel_rad", "series"),
    [
        # a field over less than half a turn, and a motor's ripple over three turns and over half of one
        ((2.55, 5.12, 8.12, 10.84), 2.71, True),
        ((7.0, 28.0, 14.0, 12.0), 18.8, False),
        # a ripple and its harmonic over 43 degrees to both sides
        ((7.0, 14.0), 1.5, False),
        ((5.0, 7.5, 10.0), 3.0, True),
        ((7.0, 14.0), 3.0, False),
        ((7.0, 28.0), 1.5, False),
        ((2.55,), 2.71, False),
        # a stop that hardens, as half a period beside a spring, and as two orders of which neither is the other's
        ((2.5,), 1.2, True),
        ((3.72, 6.02), 1.17, True),
        ((3.72, 7.4), 1.17, False),
        # two orders are half as many as periods of the higher one, or more; or nearly a multiple, or not
        ((5.0, 7.5), 3.18, True),
        ((5.0, 7.5), 3.52, False),
        ((4.0, 7.4), 1.5, True),
        ((4.0, 7.8), 1.5, False),
        ((4.0, 8.6), 1.5, True),
        # of two orders over three turns nothing else is asked
        ((7.0, 12.0), 18.8, False),
    ],
)
def test_orders_one_a_period_of_the_travel_are_a_series_and_no_ripple(
    orders: tuple[float, ...], travel_rad: float, series: bool
) -> None:
    # half of the travel in one log, half in the next
    logs = tuple(SimpleNamespace(name="", motion=np.array([[0.0, one], [0.5 * travel_rad, one]])) for one in (0.0, 1.0))
    logs[1].motion[:, 0] += 0.5 * travel_rad
    family = SimpleNamespace(axis="outer")
    causes = tuple(SimpleNamespace(family=family, x=(0.01, order - NEUTRAL_ORDER, 0.0)) for order in orders)
    state: Any = SimpleNamespace(hypothesis=SimpleNamespace(causes=causes, origins=()))
    twin = SimpleNamespace(model=SimpleNamespace(axes=("outer", "inner")), records=logs)
    inquiry: Any = SimpleNamespace(twin=twin)
    assert curve.orders_make_a_series(inquiry, state, tuple(range(len(orders)))) is series
