"""A search that comes to nothing new is over, and what it compares it compares beside the same noise."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from gimbal_hil.knowledge.discrepancy import run
from gimbal_hil.knowledge.discrepancy.hypotheses import Hypothesis, KnownNumber
from gimbal_hil.knowledge.discrepancy.inquiry import Inquiry, Policy, rms, stands_out
from gimbal_hil.knowledge.discrepancy.inquiry import inquiry as inquiry_module
from gimbal_hil.knowledge.discrepancy.search import Path, candidates, search, stories
from gimbal_hil.knowledge.executor import open_executor
from sim_backend.model import shipped_model


@pytest.mark.parametrize("still_pays", [False, True])
def test_several_numbers_of_which_nothing_new_is_left_end_the_round(
    still_pays: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    before, several, pruned = (SimpleNamespace(name=name) for name in ("before", "several", "pruned"))
    inquiry: Any = SimpleNamespace()
    monkeypatch.setattr(search, "candidates", lambda *_: [])
    monkeypatch.setattr(search, "released", lambda *_: several)
    monkeypatch.setattr(search, "pruned", lambda *_: (pruned, {}))
    monkeypatch.setattr(search, "_takes_over", lambda i, b, f, state: state is several or still_pays)
    path = search.Path(before, (), ())  # type: ignore[arg-type]
    ended = search.one_more(inquiry, path, release=True, room=1).state
    assert ended is (pruned if still_pays else before)


@pytest.mark.parametrize(
    ("was", "left", "anew"),
    [
        # a large gap of which hardly anything is left, in one channel of two
        ((400.0, 1.0), (20.0, 1.0), True),
        ((400.0, 1.0), (60.0, 1.0), False),
        # a channel far below its floor from the start tells nothing
        ((9.0, 0.02), (4.0, 0.02), False),
    ],
)
def test_close_candidates_are_fitted_again_where_the_best_leaves_little_of_a_large_gap(
    was: tuple[float, ...], left: tuple[float, ...], anew: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    def state(squares: tuple[float, ...], name: str = "") -> Any:
        return SimpleNamespace(fit=SimpleNamespace(squares=np.array(squares)), hypothesis=name)

    best, second = state(left, "best"), state(left, "second")
    fitted: list[str] = []

    def refitted(inquiry: Any, beside: Any, hypothesis: str) -> Any:
        assert beside is best
        fitted.append(hypothesis)
        return state((1.0, 1.0), hypothesis)

    monkeypatch.setattr(candidates, "refitted", refitted)
    # anew, the second comes out ahead
    monkeypatch.setattr(candidates, "advantage", lambda inquiry, before, found: float(found.hypothesis == "second"))
    inquiry: Any = SimpleNamespace()
    found = candidates._beside_the_best(inquiry, state(was), [best, second])
    assert fitted == (["best", "second"] if anew else [])
    assert [one.hypothesis for one in found] == (["second", "best"] if anew else ["best", "second"])


@pytest.mark.parametrize("better", ["further", "anew"])
def test_under_lower_floors_what_was_found_competes_with_what_is_found_anew(
    better: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    mass, level, other = (KnownNumber("pan", path, 0.1) for path in ("body.mass", "coulomb", "viscous"))
    start: Any = SimpleNamespace(hypothesis=Hypothesis(floating=(mass, level), y=(0.01, 0.02)))
    before = Hypothesis(floating=(level, other), y=(0.05, 0.06))
    asked: list[Hypothesis] = []

    def refitted(inquiry: Any, state: Any, hypothesis: Hypothesis) -> Any:
        asked.append(hypothesis)
        return SimpleNamespace(hypothesis=hypothesis)

    anew, further = (Path(SimpleNamespace(hypothesis=name), (name,), ()) for name in ("anew", "further"))  # type: ignore[arg-type]
    monkeypatch.setattr(stories, "explain", lambda *_, heard: anew)
    monkeypatch.setattr(stories, "refitted", refitted)
    monkeypatch.setattr(stories, "extended", lambda *_: further)
    monkeypatch.setattr(stories, "settled", lambda inquiry, state: state)
    # what was found has more numbers
    monkeypatch.setattr(stories, "_free_numbers", lambda hypothesis: ["anew", "further"].index(hypothesis))
    monkeypatch.setattr(stories, "_more_is_there", lambda *_: better == "further")
    nothing: Any = None
    path = stories.explain_again(nothing, start, before, ())
    assert path.state.hypothesis == better and path.rounds == ("anew", "further")
    # known numbers are those that may move under these floors, where they were
    assert asked[0].floating == (mass, level) and asked[0].y == (0.01, 0.05)


@pytest.mark.parametrize(("numbers", "first"), [((2, 2), True), ((3, 2), False), ((2, 3), True)])
def test_of_stories_with_equally_many_numbers_the_first_is_the_plainer(
    numbers: tuple[int, int], first: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    one, other = (Path(SimpleNamespace(hypothesis=n), (), ()) for n in (0, 1))  # type: ignore[arg-type]
    monkeypatch.setattr(stories, "settled", lambda inquiry, state: state)
    monkeypatch.setattr(stories, "_free_numbers", lambda which: numbers[which])
    monkeypatch.setattr(stories, "_more_is_there", lambda *_: False)
    nothing: Any = None
    assert stories._better(nothing, nothing, one, other).state is (one if first else other).state


def test_under_lower_floors_a_search_begins_anew_from_the_model(monkeypatch: pytest.MonkeyPatch) -> None:
    nothing: Any = None
    with open_executor(1, None) as executor:
        before = Inquiry(
            nothing, nothing, nothing, np.array([True]), np.array([1.0]), (), executor=executor, known=np.eye(1)
        )
        floors: Any = SimpleNamespace(effective=lambda twin: np.array([0.1]), processing=np.array([0.05]))
        null, found = ("null", "found")
        old: Any = SimpleNamespace(hypothesis="what was found")
        begun: list[tuple[Inquiry, Any, Any, Any]] = []

        def explain_again(inquiry: Inquiry, start: Any, before: Any, heard: Any) -> Path:
            begun.append((inquiry, start, before, heard))
            return Path(found, ("a round",), ())  # type: ignore[arg-type]

        monkeypatch.setattr(run, "as_stated", lambda inquiry: "stated")
        monkeypatch.setattr(run, "recalibrated", lambda inquiry, stated: (inquiry, null))
        monkeypatch.setattr(run, "explain_again", explain_again)
        heard: Any = SimpleNamespace(over=lambda ratio: ("heard", float(ratio[0])))
        path = Path(old, ("a first round", "a second"), (heard,))  # type: ignore[arg-type]
        _, _, stated, start, anew = run._under(before, floors, path)
    ((inquiry, began, was, again),) = begun
    assert (began, was, start, stated, again) == (null, "what was found", null, "stated", (("heard", 10.0),))
    assert inquiry.floor == 0.1 and inquiry.inexact == 0.5 and inquiry.known is None
    assert anew.state == found and anew.over_others == 2
    assert anew.rounds == ("a first round", "a second", "a round")


@pytest.mark.parametrize(("best_leaves", "stands"), [(None, False), (0.3, True), (5.0, False)])
def test_the_pipeline_is_no_more_inexact_than_what_the_best_explanation_leaves(
    best_leaves: float | None, stands: bool
) -> None:
    inquiry: Any = SimpleNamespace(policy=Policy(), inexact=np.array([4.0]))
    state: Any = SimpleNamespace(left=lambda: np.array([5.6]), hypothesis=SimpleNamespace(labels=()))
    best: Any = None
    if best_leaves is not None:
        more = SimpleNamespace(labels=(("viscous", "outer"),))
        best = SimpleNamespace(left=lambda: np.array([best_leaves]), hypothesis=more)
    assert stands_out(inquiry, state, best) is stands


@pytest.mark.parametrize(
    ("effect", "stands"),
    [("structural_resonance", False), ("actuator_lag", False), ("presliding", True), ("static_unbalance", True)],
)
def test_noise_that_a_larger_inertia_makes_is_no_gap_to_what_smooths_it(
    effect: str, stands: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(inquiry_module, "noise_of_motion", lambda *_: np.array([2.0]))
    inquiry: Any = SimpleNamespace(policy=Policy(), inexact=0.0, twin=None, from_encoder=1.0)
    inertia = ("inertia", "outer")
    state: Any = SimpleNamespace(left=lambda: np.array([1.7]), hypothesis=SimpleNamespace(labels=(inertia,)))
    more = SimpleNamespace(labels=(inertia, (effect, "outer")))
    best: Any = SimpleNamespace(left=lambda: np.array([1.0]), hypothesis=more)
    assert stands_out(inquiry, state) and stands_out(inquiry, state, best) is stands


def _left(fitted: float, selecting: float) -> Any:
    """A state that leaves so many floors in both halves."""
    rows = SimpleNamespace(fitted=np.full((4, 1), fitted), selecting=np.full((4, 1), selecting))
    rows.left = lambda: np.maximum(rms(rows.fitted), rms(rows.selecting))
    return rows


@pytest.mark.parametrize(
    ("before", "after", "is_all"),
    [
        # no gap
        ((200.0, 190.0), (1.2, 1.4), True),
        # two floors of two hundred, in both halves
        ((200.0, 190.0), (2.1, 2.3), True),
        # a twentieth of the squares: more is there
        ((200.0, 190.0), (45.0, 2.0), False),
        # one of the halves keeps what it had
        ((200.0, 190.0), (2.0, 180.0), False),
        # of a half without a gap there is nothing to take
        ((200.0, 0.9), (2.0, 0.8), True),
    ],
)
def test_two_causes_at_once_explain_as_good_as_all_of_both_halves(
    before: tuple[float, float], after: tuple[float, float], is_all: bool
) -> None:
    inquiry: Any = SimpleNamespace(policy=Policy(), inexact=0.0)
    assert search._as_good_as_all(inquiry, _left(*before), _left(*after)) is is_all


def test_what_pays_beside_more_causes_is_not_asked_again_beside_fewer(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of four causes the second and the last do not pay; without the last, which takes least, the second does."""

    def state(*causes: str) -> Any:
        hypothesis = SimpleNamespace(causes=causes, minus=lambda i: (*causes[:i], *causes[i + 1 :]))
        return SimpleNamespace(hypothesis=hypothesis)

    asked: list[tuple[str, str]] = []

    def refitted(inquiry: Any, beside: Any, causes: tuple[str, ...]) -> Any:
        gone = next(one for one in beside.hypothesis.causes if one not in causes)
        asked.append(("".join(beside.hypothesis.causes), gone))
        return state(*causes)

    def pays(inquiry: Any, without: Any, whole: Any) -> bool:
        gone = next(one for one in whole.hypothesis.causes if one not in without.hypothesis.causes)
        return gone in "ac" or (gone == "b" and "d" not in whole.hypothesis.causes)

    def gain(inquiry: Any, without: Any, whole: Any, part: str) -> Any:
        gone = next(one for one in whole.hypothesis.causes if one not in without.hypothesis.causes)
        return SimpleNamespace(mean={"b": 2.0, "d": 1.0}[gone])

    monkeypatch.setattr(search, "refitted", refitted)
    monkeypatch.setattr(search, "pays", pays)
    monkeypatch.setattr(search, "gain_on", gain)
    inquiry: Any = SimpleNamespace()
    kept, without = search.pruned(inquiry, state("a", "b", "c", "d"))
    assert kept.hypothesis.causes == ("a", "b", "c")
    assert asked == [("abcd", "a"), ("abcd", "b"), ("abcd", "c"), ("abcd", "d"), ("abc", "b")]
    assert {index: one.hypothesis.causes for index, one in without.items()} == {1: ("a", "c")}


@pytest.mark.parametrize(
    ("stiffness", "cause", "anew"),
    [
        (0.0, "presliding", {("coulomb", "outer"), ("presliding", "outer")}),
        # beside bristles that the model has, and beside something that is none
        (238.88, "presliding", set()),
        (0.0, "torque_gain", set()),
    ],
)
def test_friction_is_heard_anew_beside_bristles_that_the_model_lacks(
    stiffness: float, cause: str, anew: set[tuple[str, str]]
) -> None:
    def family(effect: str, axis: str) -> Any:
        return SimpleNamespace(effect=effect, axis=axis, label=(effect, axis))

    model = shipped_model().with_number("outer", "friction.sigma0", stiffness, "test")
    families = [family(effect, axis) for effect in ("coulomb", "inertia", "presliding") for axis in model.axes]
    inquiry: Any = SimpleNamespace(twin=SimpleNamespace(model=model), families=families)
    hypothesis: Any = SimpleNamespace(causes=[SimpleNamespace(family=family(cause, "outer"))])
    assert candidates._acts_otherwise(inquiry, hypothesis) == anew
