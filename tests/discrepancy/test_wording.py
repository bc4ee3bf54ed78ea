"""What a verdict says in words."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

from gimbal_hil.knowledge.discrepancy.judgement import Kind, Status
from gimbal_hil.knowledge.discrepancy.verdict import headlines, wording
from gimbal_hil.knowledge.discrepancy.verdict.discrepancy_page import _said
from gimbal_hil.knowledge.discrepancy.verdict.gaps import Gap, share_text
from gimbal_hil.knowledge.discrepancy.verdict.torque_times import _or_in_the_log
from gimbal_hil.knowledge.identification.estimate import Interval
from gimbal_hil.knowledge.identification.timing import Timing


def told(effect: str, axis: str, *rivals: tuple[str, str]) -> Any:
    standing = SimpleNamespace(label=(effect, axis), silent=False, at_bound=())
    close = tuple(SimpleNamespace(label=label) for label in rivals)
    return SimpleNamespace(standing=standing, status=Status.AMBIGUOUS, close=close, probability=0.5, denials=())


def test_an_effect_on_two_axes_has_the_alternatives_of_its_own_axis() -> None:
    both = (told("coulomb", "AZ", ("viscous", "AZ")), told("coulomb", "EL", ("stribeck", "EL")))
    result: Any = SimpleNamespace(suspected_only=False, told=both)
    # the answer says which cannot be told apart, and the grounds do not say it again
    assert wording._doubts(result) == ""
    number = {"value": 0.3, "low": 0.3, "high": 0.3, "unit": "N m", "nominal": 0.25}
    same = {"parameters": {"coulomb": number}, "status": "ambiguous", "probability": 0.5}
    effects = [{"name": "coulomb", "axis": axis, **same} for axis in ("AZ", "EL")]
    others = [
        {"name": name, "axis": axis, "instead_of": "coulomb", "instead_of_axis": axis, **same}
        for name, axis in (("viscous", "AZ"), ("stribeck", "EL"))
    ]
    said = headlines.answer_of(effects, others).splitlines()
    # names of axes stay as they are written
    assert said[0] == "Coulomb or viscous on AZ: these logs cannot tell which."
    assert said[3] == "Coulomb or stribeck on EL: these logs cannot tell which."
    assert headlines.answer_of(effects[:1], []).startswith("Perhaps coulomb on AZ: coulomb 0.3 N m (model")


def test_of_many_causes_each_has_a_short_line_with_its_size_and_the_spread_of_that() -> None:
    def number(value: float, unit: str) -> dict[str, object]:
        return {"value": value, "low": 0.99 * value, "high": 1.01 * value, "unit": unit, "nominal": None}

    mode = {"antiresonance_frequency": number(55.0, "Hz"), "inertia_share": number(0.1, "1")}
    ripple = {"amplitude": number(0.08, "N m"), "order": number(36.0, "1/turn")}
    both = [("structural_resonance", mode), ("cogging", ripple)]
    told = {"axis": "EL", "status": "named", "probability": 0.97}
    effects = [{"name": name, "parameters": parameters, **told} for name, parameters in both]
    short = headlines.answer_of([*effects, effects[0]], []).splitlines()
    assert short[:2] == [
        "Structural resonance on EL: antiresonance frequency 55 Hz (54.5 to 55.5); probability 0.97.",
        "Cogging on EL: amplitude 80 mN m (79.2 to 80.8), 36 per turn; probability 0.97.",
    ]
    assert "inertia share 0.1; probability" in headlines.answer_of(effects, [])


def test_an_effect_that_was_asked_for_and_not_tested_is_told_with_the_reason() -> None:
    path = SimpleNamespace(state=SimpleNamespace(hypothesis=SimpleNamespace(labels=())))
    result: Any = SimpleNamespace(request=SimpleNamespace(only=("gyro_bias",)), told=(), path=path)
    unseen = [{"name": name, "axis": "EL", "reason": "the data has no rate column"} for name in ("gyro_bias", "slip")]
    assert wording.told_unseen(result, unseen) == " Gyro bias on EL was not tested: the data has no rate column."


def _bias(value: float, low: float, high: float) -> dict[str, Any]:
    number = {"value": value, "low": low, "high": high, "unit": "rad/s", "nominal": 0.004}
    return {"name": "gyro_bias", "axis": "EL", "parameters": {"bias": number}, "probability": 0.97}


def test_a_number_that_is_nothing_within_its_interval_has_no_digits() -> None:
    assert "bias 0 ± 10 µrad/s (model: 4 mrad/s)" in headlines.headline(_bias(1e-6, -9e-6, 1.1e-5))
    assert "bias 5 mrad/s (4.9 to 5.1; model: 4 mrad/s)" in headlines.headline(_bias(5e-3, 4.9e-3, 5.1e-3))


def test_a_number_that_is_known_to_a_factor_is_told_by_its_ends_and_never_as_nothing() -> None:
    assert "bias 1 mrad/s to 9 mrad/s (model: 4 mrad/s)" in headlines.headline(_bias(3e-3, 1e-3, 9e-3))
    assert "bias -9 mrad/s to -1 mrad/s" in headlines.headline(_bias(-3e-3, -9e-3, -1e-3))


def test_what_the_model_lacks_and_is_nothing_is_told_only_where_all_is() -> None:
    number = {"value": 0.02, "low": 0.01, "high": 0.03, "unit": "m", "nominal": None}
    nothing = number | {"value": 1e-6, "low": -1.0, "high": 1.0}
    effect = {"name": "static_unbalance", "axis": "EL", "probability": 0.97}
    both = headlines.headline(effect | {"parameters": {"cog_x": number, "cog_z": nothing}})
    assert "cog x 20 mm" in both and "cog z" not in both
    assert "cog z 0 \u00b1 1 m" in headlines.headline(effect | {"parameters": {"cog_z": nothing}})


def test_the_page_says_each_cause_on_a_line_and_a_contradiction_once() -> None:
    effects = [_bias(5e-3, 4.9e-3, 5.1e-3), _bias(6e-3, 5.9e-3, 6.1e-3)]
    against = {"rule": "break_away", "axis": "EL", "text": "breaks away too early: see there"}
    lines = [f"{headlines.headline(effect)}." for effect in effects]
    words = wording.Said("\n".join(lines), "They explain it.", against=wording.told_against(against).strip())
    assert words.text == " ".join([*lines, "They explain it.", words.against])
    found: Any = SimpleNamespace(kind=Kind.NAMED, said=words)
    assert (_said(found).text, _said(found).more) == ("\n".join(lines), "They explain it.")
    assert _said(found).tone == "good"
    # what is left is a line of its own, and no green one
    found.said = replace(words, left="Still unexplained: rate error of EL 7 mrad/s (98.7 noise floors).")
    assert _said(found).tone == "warning" and _said(found).text == "\n".join([*lines, found.said.left])


def test_a_closed_share_of_less_than_all_is_not_100_percent() -> None:
    told = [share_text(share) for share in (0.89, 0.9951, 0.9996, 1.0)]
    assert told == ["89%", "99.5%", "over 99.9%", "100%"]


def test_torque_columns_of_all_axes_are_told_once_and_a_delay_names_the_log_that_looks_like_it() -> None:
    ends = {"late_s": -0.002, "low_s": -0.0021, "high_s": -0.0019}
    early = [
        {"rule": "torque_shifted", "axis": axis, "text": "", **ends, "state_as": f"{axis}.torque=COLUMN@2ms"}
        for axis in ("AZ", "EL")
    ]
    (text,) = wording.told_contradictions(early)
    assert "early against the positions: AZ 2 ms (1.9 to 2.1), EL 2 ms (1.9 to 2.1). A delay of the drive" in text
    assert text.endswith("state it: --column AZ.torque=COLUMN@2ms EL.torque=COLUMN@2ms.")
    number = {"value": 2e-3, "low": 1.9e-3, "high": 2.1e-3, "unit": "s", "nominal": None}
    delay = {"name": "transport_delay", "axis": "AZ", "parameters": {"delay": number}, "probability": 0.97}
    late = Interval(-0.0021, -0.0019)
    said = headlines.headline(_or_in_the_log(delay, Timing(-0.002, late, 0.0, 0.001, True)))
    assert "delay 2 ms (1.9 to 2.1), or a log whose torque is stamped 2 ms early; probability 0.97" in said
    assert _or_in_the_log(delay, Timing(0.002, Interval(0.001, 0.003), 0.0, 0.001, True)) is delay
    assert _or_in_the_log(delay, None) is delay


def test_what_half_or_twice_would_not_have_shown_is_not_said_to_show_from_less() -> None:
    smallest = [SimpleNamespace(name=name, axis="EL", relative=0.4) for name in ("coulomb", "inertia")]
    result: Any = SimpleNamespace(
        model=SimpleNamespace(axes=("EL",)), smallest=smallest, hidden=(("coulomb", "EL"),), told=()
    )
    assert wording._would_have_shown(result) == "Smallest errors that would have shown: on EL inertia 40%."
    assert "half or twice the right Coulomb friction on EL" in wording.told_hidden(result)
    result.hidden = tuple((name, axis) for name in ("coulomb", "inertia", "viscous") for axis in ("AZ", "EL"))
    several = "half or twice the right Coulomb friction, inertia or viscosity on AZ or EL."
    assert wording.told_hidden(result).endswith(several)


def test_a_gap_that_passes_for_noise_is_told_where_logs_cannot_judge() -> None:
    gap = SimpleNamespace(axis="EL", signal="torque", unit="N m", before=2.0, after=2.0, noise_floor=1.0)
    gap.after_recalibration = 2.0
    result: Any = SimpleNamespace(
        model=SimpleNamespace(axes=("EL",)), smallest=(), hidden=(("coulomb", "EL"),), told=(),
        request=SimpleNamespace(policy=SimpleNamespace(least_gap=1.5)),
        decision=SimpleNamespace(kind=Kind.CANNOT_JUDGE),
    )  # fmt: skip
    assert "still has a gap of 2.0 noise floors" in wording.told(result, (), (), [cast(Gap, gap)], ()).grounds


def test_of_two_causes_that_logs_cannot_tell_apart_neither_stands_first() -> None:
    stiffness = {"value": 2.18e-3, "low": 2.1e-3, "high": 2.3e-3, "unit": "N m/rad", "nominal": None}
    cog = {"value": 3e-2, "low": 2.9e-2, "high": 3.1e-2, "unit": "m", "nominal": None}
    spring = {"name": "cable_spring", "axis": "EL", "status": "ambiguous", "probability": 0.48}
    weight = {"name": "static_unbalance", "axis": "EL", "instead_of": "cable_spring", "instead_of_axis": "EL"}
    effects = [{**spring, "parameters": {"stiffness": stiffness}}]
    answer = headlines.answer_of(effects, [{**weight, "parameters": {"cog_x": cog}, "probability": 0.47}])
    assert answer.splitlines() == [
        "Cable spring or static unbalance on EL: these logs cannot tell which.",
        "Cable spring on EL: stiffness 2.18 mN m/rad (2.1 to 2.3); probability 0.48.",
        "Static unbalance on EL: cog x 30 mm (29 to 31); probability 0.47.",
    ]
