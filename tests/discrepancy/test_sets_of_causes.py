"""Of causes that a search found together those that do not stand go one at a time; what that says of the others."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from gimbal_hil.knowledge.discrepancy.inquiry.policy import Policy
from gimbal_hil.knowledge.discrepancy.judgement import deciding, instead, judging
from gimbal_hil.knowledge.discrepancy.judgement.deciding import Decision, Kind, Status, Told
from gimbal_hil.knowledge.discrepancy.judgement.exhaustion import Predictable
from gimbal_hil.knowledge.discrepancy.judgement.judging import Remainder, Standing
from gimbal_hil.knowledge.discrepancy.judgement.rivals import Rival
from tests.discrepancy.test_deciding import SOUND

Label = tuple[str, str]


def a_state(*labels: Label) -> Any:
    return SimpleNamespace(hypothesis=SimpleNamespace(labels=labels, causes=labels), untouched=np.ones((4, 1)))


def decided(monkeypatch: pytest.MonkeyPatch, found: Any, left: Remainder) -> tuple[Decision, list[Label]]:
    """What is told of a state that a search found, whose fits all leave as much, and which causes went, in order."""
    gone = []

    def left_out(inquiry: Any, state: Any, fallen: Standing) -> Any:
        gone.append(fallen.label)
        return a_state(*(label for label in state.hypothesis.labels if label != fallen.label))

    monkeypatch.setattr(deciding, "_left_out", left_out)
    monkeypatch.setattr(deciding, "remainders", lambda *_: (left,))
    for name in ("settled", "given_back"):
        monkeypatch.setattr(deciding, name, lambda inquiry, state: state)
    monkeypatch.setattr(deciding, "_leaves_a_gap", lambda *_: True)
    monkeypatch.setattr(deciding, "_only_noise", lambda *_: False)
    monkeypatch.setattr(deciding, "depends_on", lambda *_: None)
    monkeypatch.setattr(instead, "stands_out", lambda *_: False)
    inquiry: Any = SimpleNamespace(policy=Policy(), families=range(30))
    path: Any = SimpleNamespace(state=found)
    return deciding.decide(inquiry, a_state(), a_state(), path, False, False), gone


@pytest.mark.parametrize(
    ("gone", "silent", "takes", "closed", "stays"),
    [
        # a lag acts through torque, an inertia through acceleration: what the lag leaves is no part of it
        ("actuator_lag", False, 98.0, 0.98, True),
        # it closes a third of the gap that is there beside the others
        ("actuator_lag", False, 1.0, 1.0 / 3.0, False),
        ("structural_resonance", False, 98.0, 0.98, False),
        ("actuator_lag", True, 98.0, 0.98, False),
    ],
)
def test_what_a_cause_that_is_gone_leaves_is_no_doubt_about_what_acts_through_others(
    gone: str, silent: bool, takes: float, closed: float, stays: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    inertia, other = ("inertia", "outer"), (gone, "outer")

    def standings(inquiry: Any, stated: Any, null: Any, state: Any, path: Any, left: Any) -> tuple[Standing, ...]:
        sound = replace(SOUND, takes=np.array([takes]))
        return tuple(replace(sound, entries=(k,), label=one) for k, one in enumerate(state.hypothesis.labels))

    def told(inquiry: Any, standing: Standing, found: Any, left: Any, suspected_only: bool) -> Told:
        probable = (0.96 if len(found) == 2 else 0.4) if standing.label == inertia else 0.2
        return Told(standing, Status.NAMED, (), probable, probable, shown=len(found) == 2 or not silent)

    monkeypatch.setattr(deciding, "standings", standings)
    monkeypatch.setattr(deciding, "_told", told)
    # others close nearly all of what the model leaves: that is no merit of this one
    left = Remainder(40.0, float(np.sqrt(3.0)), Predictable(0.0, 0.0))
    found, went = decided(monkeypatch, a_state(inertia, other), left)
    assert went == ([other] if stays else [other, inertia])
    assert [one.standing.label for one in found.told] == ([inertia] if stays else [])
    assert found.kind is (Kind.AMBIGUOUS if stays else Kind.UNEXPLAINED)
    if stays:
        assert found.told[0].of_class == pytest.approx(0.96 * closed)


@pytest.mark.parametrize(
    ("cause", "rival", "same", "plainer"),
    [
        ("cable_spring", "static_unbalance", True, True),
        ("cable_spring", "static_unbalance", False, False),
        # a spring contains an offset, and the search has weighed the two
        ("cable_spring", "torque_offset", True, False),
        ("static_unbalance", "cable_spring", True, False),
    ],
)
def test_of_two_that_data_do_not_tell_apart_a_number_of_the_model_is_plainer(
    cause: str, rival: str, same: bool, plainer: bool
) -> None:
    state: Any = SimpleNamespace(hypothesis=SimpleNamespace(labels=((rival, "outer"),)))
    standing = replace(SOUND, label=(cause, "outer"))
    assert instead._is_plainer(Rival(state, ((rival, "outer"),), 0.0, 0.0, same=same), standing) is plainer


def test_a_further_order_of_a_ripple_that_is_there_is_plainer_than_a_new_name() -> None:
    ripple = ("cogging", "outer")
    state: Any = SimpleNamespace(hypothesis=SimpleNamespace(labels=(ripple, ripple)))
    further = Rival(state, (ripple,), 0.1, 1.0, same=False)
    for cause, plainer in (("position_dependent_friction", True), ("static_unbalance", False)):
        assert instead._is_plainer(further, replace(SOUND, label=(cause, "outer"))) is plainer


@dataclass(frozen=True)
class _Asked:
    families: tuple
    policy: Policy = field(default_factory=Policy)
    twin: None = None


@pytest.mark.parametrize(("better", "names_stay"), [(True, True), (False, True), (True, False)])
def test_where_a_cause_does_not_stand_further_orders_of_a_ripple_are_looked_for(
    better: bool, names_stay: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    ripple, other = ("cogging", "outer"), ("quadratic_drag", "outer")
    without = SimpleNamespace(hypothesis=SimpleNamespace(labels=(ripple,)))
    families = tuple(SimpleNamespace(label=x, ripple=x == ripple or None) for x in (ripple, other))
    asked = []
    names = (ripple, ripple, ripple) if names_stay else (ripple, other)
    longer = SimpleNamespace(state=SimpleNamespace(hypothesis=SimpleNamespace(labels=names)))
    monkeypatch.setattr(deciding, "extended", lambda one, *rest: asked.append((one.families, rest[0])) or longer)
    monkeypatch.setattr(deciding, "refitted", lambda *_: without)
    monkeypatch.setattr(deciding, "clearly_better", lambda inquiry, new, old: better)
    rest = SimpleNamespace(labels=(ripple,))
    state: Any = SimpleNamespace(hypothesis=SimpleNamespace(minus=lambda index: rest))
    monkeypatch.setattr(deciding, "plainer_of", lambda *_: None)
    found = deciding._left_out(_Asked(families), state, SOUND)
    # other names are not looked for, none goes, and what explains no more than before is not taken
    assert asked == [(families[:1], without)]
    assert found is (longer.state if better and names_stay else without)


@pytest.mark.parametrize("is_there", [False, True])
def test_in_the_place_of_a_cause_that_falls_stands_the_plainer_one_that_it_contains(
    is_there: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    labels = (("coulomb", "outer"), ("static_unbalance", "outer"))
    families = tuple(SimpleNamespace(label=label, ripple=None, knobs=(1, 2, 3)) for label in labels)
    asked: list[Any] = []
    rest = SimpleNamespace(labels=labels if is_there else labels[:1])
    rest.plus = lambda cause: asked.append(cause) or rest
    state: Any = SimpleNamespace(hypothesis=SimpleNamespace(minus=lambda index: rest))
    monkeypatch.setattr(deciding, "plainer_of", lambda *_: "static_unbalance")
    monkeypatch.setattr(deciding, "refitted", lambda *_: SimpleNamespace(hypothesis=rest))
    deciding._left_out(_Asked(families), state, replace(SOUND, label=("cogging", "outer")))
    assert [(one.family, one.x) for one in asked] == ([] if is_there else [(families[1], (0.0, 0.0, 0.0))])


@pytest.mark.parametrize(("contained", "gone"), [({0: "static_unbalance", 1: None}, [0]), ({0: None, 1: None}, [1, 0])])
def test_of_a_ripple_that_falls_orders_beside_one_that_is_something_plainer_stay(
    contained: dict[int, str | None], gone: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    family = SimpleNamespace(label=("static_unbalance", "outer"), ripple=None, knobs=(1,))
    asked: list[int] = []
    state: Any = SimpleNamespace(hypothesis=SimpleNamespace(labels=()))
    state.hypothesis.minus = lambda index: asked.append(index) or state.hypothesis
    state.hypothesis.plus = lambda cause: state.hypothesis
    monkeypatch.setattr(deciding, "plainer_of", lambda twin, hypothesis, index: contained[index])
    monkeypatch.setattr(deciding, "refitted", lambda *_: state)
    deciding._left_out(_Asked((family,)), state, replace(SOUND, label=("cogging", "outer"), entries=(0, 1)))
    assert asked == gone


def test_where_no_ripple_is_left_nothing_is_looked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    without = SimpleNamespace(hypothesis=SimpleNamespace(labels=(("viscous", "outer"),)))
    monkeypatch.setattr(deciding, "refitted", lambda *_: without)
    monkeypatch.setattr(deciding, "extended", lambda *_: pytest.fail("nothing to look for"))
    monkeypatch.setattr(deciding, "plainer_of", lambda *_: None)
    state: Any = SimpleNamespace(hypothesis=SimpleNamespace(minus=lambda index: SimpleNamespace(labels=())))
    families = (SimpleNamespace(label=("cogging", "outer"), ripple=True),)
    asked: Any = _Asked(families)
    assert deciding._left_out(asked, state, SOUND) is without


def test_of_causes_that_do_not_stand_the_least_probable_goes_first_however_few_numbers_it_has(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # an unbalance of three numbers is nearly sure; of the two others, which need it, the friction is the less probable
    unbalance, viscous, load = ((name, "joint") for name in ("static_unbalance", "viscous", "load_dependent_friction"))
    sureness = {unbalance: 2.0, viscous: 1.8, load: 1.0}

    def standings(inquiry: Any, stated: Any, null: Any, state: Any, path: Any, left: Any) -> tuple[Standing, ...]:
        alone = len(state.hypothesis.labels) == 2
        return tuple(
            replace(SOUND, entries=(k,), label=label, sure=9.0 if alone else sureness[label])
            for k, label in enumerate(state.hypothesis.labels)
        )

    monkeypatch.setattr(deciding, "standings", standings)
    found, gone = decided(monkeypatch, a_state(unbalance, viscous, load), Remainder(7.0, 1.4, Predictable(0.9, 0.0)))
    assert gone == [load]
    assert [one.standing.label for one in found.told] == [unbalance, viscous] and found.kind is Kind.NAMED


def test_of_two_that_take_each_others_place_in_turn_the_one_that_explains_surely_more_is_judged(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    spring, unbalance = ("cable_spring", "inner"), ("static_unbalance", "inner")

    def standings(inquiry: Any, stated: Any, null: Any, state: Any, path: Any, left: Any) -> tuple[Standing, ...]:
        (label,) = state.hypothesis.labels
        other = unbalance if label == spring else spring
        rival: Any = SimpleNamespace(
            state=a_state(other), label=other, is_cause=True, at_bound=(), extra=0.1, close=lambda _: True
        )
        return (replace(SOUND, label=label, rivals=(rival,)),)

    def told(inquiry: Any, standing: Standing, found: Any, left: Any, suspected_only: bool) -> Told:
        return Told(standing, Status.AMBIGUOUS, (), 0.48, 0.97, shown=True)

    monkeypatch.setattr(deciding, "standings", standings)
    monkeypatch.setattr(deciding, "_told", told)
    monkeypatch.setattr(instead, "_is_plainer", lambda rival, standing: rival.label == unbalance)
    monkeypatch.setattr(instead, "_surely_beats", lambda inquiry, state, standing, rival: rival.label == spring)
    found, went = decided(monkeypatch, a_state(spring), Remainder(6.8, 0.7, Predictable(0.0, 0.0)))
    assert [one.standing.label for one in found.told] == [spring] and found.kind is Kind.AMBIGUOUS and not went


@pytest.mark.parametrize(("spring_does_as_well", "ripple"), [(False, False), (True, False), (False, True)])
def test_where_a_gap_is_left_a_rival_with_one_cause_beside_it_is_weighed_against_the_cause_with_the_same(
    spring_does_as_well: bool, ripple: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    spring, unbalance, offset = ((name, "inner") for name in ("cable_spring", "static_unbalance", "coulomb_asymmetry"))

    class Held(SimpleNamespace):
        """A hypothesis by its labels."""

        def plus(self, cause: Any) -> Any:
            return Held(labels=(*self.labels, cause.label), causes=(*self.causes, cause))

    def state(*labels: Label) -> Any:
        causes = tuple(SimpleNamespace(label=one, family=SimpleNamespace(ripple=ripple)) for one in labels)
        return SimpleNamespace(hypothesis=Held(labels=labels, causes=causes))

    rival: Any = SimpleNamespace(
        state=state(unbalance), label=unbalance, is_cause=True, same=False, is_there=False, at_bound=(), extra=0.9,
        close=lambda _: False, plainer=None,
    )  # fmt: skip
    weighed: list[tuple[Label, ...]] = []

    def surely(inquiry: Any, old: Any, new: Any) -> float:
        weighed.append(old.hypothesis.labels)
        return 0.0 if spring_does_as_well else 9.0

    monkeypatch.setattr(instead, "stands_out", lambda *_: True)
    monkeypatch.setattr(instead, "extended", lambda *_: SimpleNamespace(state=state(unbalance, offset)))
    monkeypatch.setattr(instead, "refitted", lambda inquiry, state, hypothesis: SimpleNamespace(hypothesis=hypothesis))
    monkeypatch.setattr(instead, "settled", lambda inquiry, state: state)
    monkeypatch.setattr(instead, "surely", surely)
    monkeypatch.setattr(instead, "clearly_better", lambda *_: not spring_does_as_well)
    inquiry: Any = SimpleNamespace(policy=Policy(), tell=lambda _: None)
    standing = replace(SOUND, label=spring, rivals=(rival,))
    found = instead.better_instead(inquiry, state(spring), (standing,), set(), SimpleNamespace(heard=()))  # type: ignore[arg-type]
    if spring_does_as_well or ripple:
        assert found is None
    else:
        assert found is not None and found.hypothesis.labels == (unbalance, offset)
    assert all(one == (spring, offset) for one in weighed) and bool(weighed) is not ripple


GAIN, WEIGHT, LEVEL, BRISTLE = (
    (name, "inner") for name in ("torque_gain", "static_unbalance", "coulomb", "presliding")
)


@pytest.mark.parametrize(
    ("sure", "clear", "pays", "was_there", "bound", "taken"),
    [
        (9.0, True, {WEIGHT, LEVEL, BRISTLE}, False, False, True),
        # the gain is there as well
        (9.0, True, {WEIGHT, GAIN, LEVEL}, False, False, True),
        (2.9, True, {WEIGHT, LEVEL, BRISTLE}, False, False, False),
        (9.0, False, {WEIGHT, LEVEL, BRISTLE}, False, False, False),
        # beside the gain none of them pays
        (9.0, True, {WEIGHT, GAIN}, False, False, False),
        (9.0, True, set(), False, False, False),
        (9.0, True, {WEIGHT, LEVEL, BRISTLE}, True, False, False),
        (9.0, True, {WEIGHT, LEVEL, BRISTLE}, False, True, False),
    ],
)
def test_numbers_that_surely_explain_more_take_the_place_of_a_cause_that_does_not_pay_beside_them(
    sure: float, clear: bool, pays: set[Label], was_there: bool, bound: bool, taken: bool,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    def kept(inquiry: Any, state: Any) -> Any:
        assert set(state.hypothesis.labels) == {WEIGHT, GAIN, LEVEL, BRISTLE}
        return a_state(*(label for label in state.hypothesis.labels if label in pays)), {}

    rival: Any = SimpleNamespace(state=a_state(WEIGHT), labels=(LEVEL, BRISTLE), is_cause=False)
    monkeypatch.setattr(instead, "surely", lambda *_: sure)
    monkeypatch.setattr(instead, "clearly_better", lambda *_: clear)
    monkeypatch.setattr(instead, "as_causes", lambda inquiry, state, labels: a_state(*state.hypothesis.labels, *labels))
    monkeypatch.setattr(instead, "pruned", kept)
    monkeypatch.setattr(instead, "settled", lambda inquiry, state: state)
    monkeypatch.setattr(instead, "squares_of", lambda state: np.ones(1))
    monkeypatch.setattr(instead, "at_bound", lambda twin, hypothesis, i: ("sigma0",) if bound else ())
    inquiry: Any = SimpleNamespace(policy=Policy(), twin=None)
    standing = replace(SOUND, label=GAIN, rivals=(rival,))
    replaced = {frozenset(pays)} if was_there else set()
    found = instead._by_numbers(inquiry, a_state(WEIGHT, GAIN), (standing,), replaced)
    assert (None if found is None else set(found.hypothesis.labels)) == (pays if taken else None)


def test_what_stands_when_nothing_more_may_be_replaced_is_judged(monkeypatch: pytest.MonkeyPatch) -> None:
    names = [("cable_spring", "inner"), ("static_unbalance", "inner")]
    asked: list[tuple[Label, ...]] = []

    def another(inquiry: Any, state: Any, *_: Any) -> Any:
        asked.append(state.hypothesis.labels)
        return a_state(names[len(asked) % 2])

    def standings(inquiry: Any, stated: Any, null: Any, state: Any, path: Any, left: Any) -> tuple[Standing, ...]:
        return (replace(SOUND, label=state.hypothesis.labels[0]),)

    def told(inquiry: Any, standing: Standing, found: Any, left: Any, suspected_only: bool) -> Told:
        return Told(standing, Status.NAMED, (), 0.97, 0.97, shown=True)

    monkeypatch.setattr(deciding, "standings", standings)
    monkeypatch.setattr(deciding, "_told", told)
    monkeypatch.setattr(deciding, "better_instead", another)
    found, went = decided(monkeypatch, a_state(names[0]), Remainder(6.8, 0.7, Predictable(0.0, 0.0)))
    assert len(asked) == deciding._TURNS and not went
    assert [one.standing.label for one in found.told] == [names[1]] and found.kind is Kind.NAMED


def test_of_several_that_explain_nothing_the_one_that_takes_least_goes_first(monkeypatch: pytest.MonkeyPatch) -> None:
    labels = (("inertia", "outer"), ("stribeck", "outer"))

    def standings(inquiry: Any, stated: Any, null: Any, state: Any, path: Any, left: Any) -> tuple[Standing, ...]:
        there = enumerate(state.hypothesis.labels)
        # either alone leaves no gap for the other
        alone = len(state.hypothesis.labels) == 1
        return tuple(replace(SOUND, entries=(k,), label=one, explains=alone, share=0.9 - 0.4 * k) for k, one in there)

    monkeypatch.setattr(deciding, "standings", standings)
    found, went = decided(monkeypatch, a_state(*labels), Remainder(10.0, 1.0, Predictable(0.0, 0.0)))
    assert went == [labels[1]]
    assert [one.standing.label for one in found.told] == [labels[0]]


@pytest.mark.parametrize(("beside", "explains"), [(1.8, True), (1.4, False)])
def test_beside_others_that_leave_no_gap_there_is_nothing_to_explain(beside: float, explains: bool) -> None:
    def leaves(floors: float) -> Any:
        return SimpleNamespace(fitted=np.full((8, 1), floors), held=np.full((8, 1), floors))

    inquiry: Any = SimpleNamespace(
        policy=Policy(), inexact=0.0, selecting=np.arange(8) < 4, in_order=lambda state: state.held
    )
    assert judging._explains(inquiry, leaves(20.0), leaves(beside), np.array([0.9])) is explains
    assert not judging._explains(inquiry, leaves(1.4), leaves(beside), np.array([0.9]))


@pytest.mark.parametrize(
    ("effect", "high", "limit", "stands"),
    [
        ("coulomb", 15.6, 15.5, ("coulomb",)),
        ("coulomb", 15.4, 15.5, ()),
        ("coulomb", 15.6, 0.0, ()),
        ("viscous", 15.6, 15.5, ()),
    ],
)
def test_friction_that_takes_all_that_the_motor_gives_stands_at_a_bound(
    effect: str, high: float, limit: float, stands: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    model = SimpleNamespace(number=lambda axis, path: {"actuator.limit": limit}[path])
    inquiry: Any = SimpleNamespace(twin=SimpleNamespace(model=model))
    ends = {"coulomb": (0.9 * high, high), "breakaway": (0.0, 0.0), "viscous": (0.9 * high, high)}
    monkeypatch.setattr(judging, "parameter_intervals", lambda *_: ends)
    monkeypatch.setattr(judging, "strengths_to_their_end", lambda *_: ())
    monkeypatch.setattr(judging, "at_bound", lambda *_: ())
    assert judging._at_bound(inquiry, a_state((effect, "outer")), (0,)) == stands
