"""From a result to the verdict as docs/reference/verdict.md describes it: a typed value, from which verdict.json is
written.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace

import numpy as np

from firmware_protocol.json_object import Json
from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.discrepancy.hypotheses import values_of
from gimbal_hil.knowledge.discrepancy.inquiry import State, rms
from gimbal_hil.knowledge.discrepancy.judgement import (
    Kind,
    Result,
    Rival,
    Shows,
    Told,
    intervals_of_both,
    number_intervals,
    odds_against,
    parameter_intervals,
)
from gimbal_hil.knowledge.discrepancy.twin import Channel
from gimbal_hil.knowledge.discrepancy.verdict.contradictions import contradictions
from gimbal_hil.knowledge.discrepancy.verdict.corrected import corrected_model, moved_numbers, recalibrated_model
from gimbal_hil.knowledge.discrepancy.verdict.forms import undetermined_form
from gimbal_hil.knowledge.discrepancy.verdict.gaps import Gap, closed_most, gaps_of, largest
from gimbal_hil.knowledge.discrepancy.verdict.laws import laws_of
from gimbal_hil.knowledge.discrepancy.verdict.next_run import run_for
from gimbal_hil.knowledge.discrepancy.verdict.separating import CHANCE, separating_run
from gimbal_hil.knowledge.discrepancy.verdict.testable import not_testable
from gimbal_hil.knowledge.discrepancy.verdict.where import Regime, RegimeGroup, most_telling, regimes
from gimbal_hil.knowledge.discrepancy.verdict.wording import (
    Said,
    contradiction_of,
    told,
    told_against,
    told_hidden,
    told_standing_in,
    told_unseen,
)
from sim_backend.effects import CATALOGUE
from sim_backend.model import NUMBER_AT, AntennaModel

#: floors above which a second channel is worth a place; standard deviations by which a number has moved at all
_HAS_A_GAP, _HARDLY = 1.3, 0.05


@dataclass(frozen=True)
class Verdict:
    """The content of verdict.json."""

    kind: Kind
    said: Said
    where: tuple[Json, ...]
    effects: tuple[Json, ...]
    alternatives: tuple[Json, ...]
    next_experiment: Json | None
    not_testable: tuple[Json, ...]
    #: the largest; None where logs were refused
    gap: Gap | None
    gaps: tuple[Gap, ...]
    recalibrated: tuple[Json, ...]
    contradictions: tuple[Json, ...]
    #: that none of the told causes is it; None where logs were refused
    something_else: float | None
    #: the smallest error of each number or effect that these logs would have shown
    smallest_shown: tuple[Json, ...]
    #: numbers that could be half or twice what they should be without showing in these logs
    would_not_show: tuple[Json, ...]
    #: where nothing is told: the variable that alone predicts most of what is left, and the share
    depends_on: Json | None
    notes: tuple[str, ...] = ()
    #: where no name fits: what it looks like
    laws: tuple[Json, ...] = ()

    @property
    def text(self) -> str:
        """What was found and how sure it is, in one line."""
        return self.said.text

    @property
    def told_gap(self) -> Gap | None:
        """The gap that the text speaks of; None where logs were refused."""
        return closed_most(self.gaps) if self.effects else self.gap

    @property
    def document(self) -> Json:
        """What verdict.json holds."""
        return {
            "schema": 1,
            "verdict": self.kind.value,
            "answer": self.said.answer,
            "grounds": self.said.grounds,
            "left": self.said.left,
            "text": self.text,
            "where": list(self.where),
            "effects": list(self.effects),
            "laws": list(self.laws),
            "alternatives": list(self.alternatives),
            "next_experiment": self.next_experiment,
            "not_testable": list(self.not_testable),
            "gap": None if self.gap is None else asdict(self.gap),
            "gaps": [asdict(gap) for gap in self.gaps],
            "recalibrated": list(self.recalibrated),
            "contradictions": list(self.contradictions),
            "something_else": None if self.something_else is None else round(self.something_else, 3),
            "smallest_shown": list(self.smallest_shown),
            "would_not_show": list(self.would_not_show),
            "depends_on": self.depends_on,
            "notes": list(self.notes),
        }


def verdict_of(result: Result, logs: Sequence[SignalsTable] = (), notes: Sequence[str] = ()) -> Verdict:
    """What a result says; with the `logs` themselves it also says where they contradict one another."""
    gaps = gaps_of(result)
    worst = _spoken_of(result, gaps)
    entries = [_effect_entry(result, one) for one in result.told]
    effects = tuple(sorted((entry for entry, _, _ in entries), key=lambda e: -e["held_out_gain"]))
    alternatives = tuple(other for _, others, _ in entries for other in others)
    run = next((run for _, _, run in entries if run is not None), None)
    kind = result.decision.kind
    where = (
        ()
        if kind in (Kind.NO_DISCREPANCY, Kind.CANNOT_JUDGE)
        else tuple(_where_entry(r) for r in where_of(result, worst))
    )
    if kind in (Kind.UNEXPLAINED, Kind.DESCRIBED) and run is None:
        run = _run_for(result, worst)
    if kind is Kind.CANNOT_JUDGE:
        run = _run_that_judges(result)
    against = tuple(contradictions(corrected_model(result) or recalibrated_model(result), logs))
    moved = _recalibrated(result)
    said = told(result, effects, alternatives, gaps, moved)
    something_else = 1.0 - min((one.of_names for one in result.told), default=0.0 if kind is Kind.UNEXPLAINED else 1.0)
    over, unseen = result.decision.depends_on, tuple(not_testable(result))
    hidden = "" if kind is Kind.CANNOT_JUDGE else told_hidden(result)
    grounds = [said.grounds, told_standing_in(result), told_unseen(result, unseen), hidden]
    return Verdict(
        kind,
        replace(said, grounds="".join(grounds).strip(), against="".join(map(told_against, against)).strip()),
        where,
        effects,
        alternatives,
        run,
        unseen,
        gaps[worst],
        gaps,
        moved,
        against,
        something_else,
        tuple(_smallest_entry(one) for one in result.smallest),
        tuple({"name": name, "axis": axis} for name, axis in result.hidden),
        None if over is None else {"variable": over[0].value, "share": round(over[1], 3)},
        (*notes, *_notes(result)),
        laws_of(result),
    )


def _spoken_of(result: Result, gaps: Sequence[Gap]) -> int:
    """The channel of the largest gap: on the rows that judge, and of what nothing explains wherever there is one."""
    worst = gaps.index(largest(gaps))
    judged = gaps[worst].before > result.request.policy.least_gap * gaps[worst].noise_floor
    if judged or result.decision.kind is not Kind.UNEXPLAINED:
        return worst
    return int(np.argmax(result.null.left()))


def _smallest_entry(one: Shows) -> Json:
    relative = one.relative
    return {
        "name": one.name,
        "axis": one.axis,
        "parameter": one.parameter,
        "size": float(f"{one.size:.3g}"),
        "unit": one.unit,
        "relative": None if relative is None else float(f"{relative:.3g}"),
    }


def _run_that_judges(result: Result) -> Json:
    """A run that shows what these logs would not have."""
    name, axis = result.hidden[0]
    return {"plan": f"{CATALOGUE[name].excited_by}, on {axis}", "separates": [one for one, _ in result.hidden]}


def refusal(reason: str) -> Verdict:
    """The verdict of logs that were refused: nothing but why."""
    return Verdict(Kind.UNUSABLE_DATA, Said(reason), (), (), (), None, (), None, (), (), (), None, (), (), None)


def entries_of(effect: Json) -> list[Json]:
    """The entries of a told effect, parameters by name: a ripple of several orders has one for each."""
    return effect.get("entries") or [effect["parameters"]]


def _effect_entry(result: Result, one: Told) -> tuple[Json, list[Json], Json | None]:
    """A told cause, what it could also be, and the run that would tell."""
    name, axis = one.standing.label
    index = one.standing.entries[0]
    gain = min(1.0, one.standing.untouched.share if one.standing.silent else _gain(result, one))
    entry: Json = {
        "name": name,
        "axis": axis,
        "status": one.status.value,
        "parameters": _parameters(result, index),
        "held_out_gain": gain,
        # of the same gap: the control is known as a share of what is left without the cause, as `share` is
        "best_control_gain": gain * one.standing.control / max(one.standing.share, 1e-9),
        "probability": round(one.probability, 3),
        "confidence": round(one.probability, 3),
        "probability_of_class": round(one.of_names, 3),
        "predicted_from_its_variables": round(one.standing.exhausted.beyond, 3),
        "strength_varies_by": round(one.standing.uneven, 3),
        "strength_known_within": round(one.standing.error, 3),
    }
    if len(one.standing.entries) > 1:
        entry["entries"] = [_parameters(result, i) for i in one.standing.entries]
    if one.standing.at_bound:
        entry["at_bound"] = list(one.standing.at_bound)
    denials = [asdict(denial) for denial in one.denials if denial.label == one.standing.label]
    if denials:
        entry["denied_by_identify"] = [{k: v for k, v in denial.items() if k != "label"} for denial in denials]
    contradiction = contradiction_of(entry)
    if contradiction:
        entry["contradiction"] = contradiction
    form = undetermined_form(result.inquiry, result.best.fit, index)
    if form is not None:
        entry["form_undetermined"] = form
    others = [
        {
            "name": rival.label[0],
            "axis": rival.label[1],
            "instead_of": name,
            "instead_of_axis": axis,
            "reason": _reason(rival),
            "parameters": _rival_parameters(result, rival),
            "probability": round(one.of_class * odds_against(rival, result.inquiry.policy) * _alone(one), 3),
        }
        for rival in one.close
    ]
    return entry, others, _separating(one, result.suspected_only)


def _notes(result: Result) -> list[str]:
    """What a reader must know of how the logs were used."""
    found = [f"{source}: too short for the scored band, left out" for source in result.inquiry.left_out]
    if result.only_in_hold_out:
        found.append("only the hold-out has a gap: a part of it was fitted with the other logs, and the rest judged")
    return found


def _reason(rival: Rival) -> str:
    more = f"{abs(rival.extra):.1%} {'more' if rival.extra >= 0.0 else 'less'}"
    leaves = f"on this data it leaves {more} of the squared residual, {rival.sure:.1f} standard errors apart"
    leaves += ", which is less than a model is exact to or than what both lack" if rival.same else ""
    beside = " and ".join(f"{name} of the {axis} axis" for name, axis in rival.labels[1:])
    return f"together with {beside}, {leaves}" if beside else leaves


def _alone(one: Told) -> float:
    """The share of a cause in what is known of it or one of its alternatives."""
    return one.probability / one.of_class if one.of_class > 0.0 else 0.0


def _rival_parameters(result: Result, rival: Rival) -> Json:
    """The numbers of an alternative where it stands in the place of the cause; of known numbers, where they moved."""
    if rival.is_cause:
        return _parameters(result, len(rival.state.hypothesis.causes) - 1, rival.state)
    (effect, axis), model = rival.label, result.model
    moved = moved_numbers(model, result.inquiry.twin, rival.state.hypothesis)
    found = {}
    for parameter in CATALOGUE[effect].parameters:
        path = None if parameter.path is None else model.number_path(axis, parameter.path)
        if path is not None and (axis, path) in moved:
            value, unit = moved[axis, path], NUMBER_AT[path].unit_for(model.is_linear)
            nominal = model.number(axis, path)
            found[parameter.name] = {"value": value, "low": value, "high": value, "unit": unit, "nominal": nominal}
    return found


def _parameters(result: Result, index: int, state: State | None = None) -> Json:
    """Numbers of a cause with their intervals, of the best state or another one."""
    model, twin, state = result.model, result.inquiry.twin, state or result.best
    effect = CATALOGUE[state.hypothesis.labels[index][0]]
    intervals = intervals_of_both(
        result.decision, state.hypothesis.labels[index], parameter_intervals(result.inquiry, state, index)
    )
    found = {}
    for name, (value, nominal) in values_of(model, twin, state.hypothesis, index).items():
        parameter = next(p for p in effect.parameters if p.name == name)
        low, high = intervals.get(name, (value, value))
        unit = parameter.linear_unit if model.is_linear and parameter.linear_unit else parameter.unit
        found[name] = {"value": value, "low": low, "high": high, "unit": unit, "nominal": nominal}
    return found


def _gain(result: Result, one: Told) -> float:
    """Share of the squares on the hold-out, over all channels in floors, that a cause takes."""
    before = float(np.sum(rms(np.concatenate([result.null.selecting, result.null.untouched])) ** 2))
    return one.standing.taken / max(before, 1e-9)


def _separating(one: Told, suspected_only: bool) -> Json | None:
    name = one.standing.label[0]
    rivals = [r.label[0] for r in one.close if r.label[0] != CATALOGUE[name].same_by_command]
    if one.standing.silent:
        return {
            "plan": f"the hold-out has no trace of it; as a hold-out, {CATALOGUE[name].excited_by}",
            "separates": [name, CHANCE],
        }
    if rivals:
        plan = separating_run(name, rivals[0], {n: e.excited_by for n, e in CATALOGUE.items()})
        return {"plan": plan, "separates": [name, rivals[0]]}
    if suspected_only:
        return {"plan": "another motion of the same antenna, given as --holdout", "separates": [name, CHANCE]}
    return None


def _run_for(result: Result, worst: int) -> Json:
    """For what nothing explains: a run that shows best what it hangs on."""
    if result.request.limited:
        return {"plan": "first the same logs without --only and --without: they may show what it is", "separates": []}
    over, found = result.decision.depends_on, where_of(result, worst)
    group = found[0].group if found else RegimeGroup.SPEED
    axis = result.inquiry.twin.channels[worst].axis
    return {"plan": run_for(axis, None if over is None else over[0], group), "separates": []}


def where_of(result: Result, worst: int) -> list[Regime]:
    """The most telling regimes of the channel `worst`, which the verdict speaks of, and of the next one that has a
    gap; where the searched logs have none, there is no regime of it.
    """
    levels, found = rms(result.null.fitted), []
    order = dict.fromkeys((worst, *map(int, np.argsort(-levels))))
    for j in [j for j in order if levels[j] > _HAS_A_GAP][:2]:
        channel: Channel = result.inquiry.twin.channels[j]
        found += most_telling(regimes(result.inquiry.twin, result.null.fitted, channel, j), 3)
    return found


def _where_entry(regime: Regime) -> Json:
    return {
        "axis": regime.axis,
        "signal": regime.signal,
        "regime": regime.regime,
        "share_of_gap": round(regime.share_of_gap, 4),
        "low": round(regime.low, 4),
        "high": round(regime.high, 4),
        "share_of_time": round(regime.share_of_time, 4),
    }


def _recalibrated(result: Result) -> tuple[Json, ...]:
    """Known numbers that moved: inside their uncertainty by themselves, or beyond it as a named cause."""
    model, hypothesis = result.model, result.best.hypothesis
    named = {
        (axis, model.number_path(axis, p.path))
        for effect, axis in hypothesis.labels
        for p in CATALOGUE[effect].parameters
        if p.path
    }
    found = []
    intervals = number_intervals(result.under, result.best)
    numbers = moved_numbers(model, result.under.twin, replace(hypothesis, causes=()))
    for known, y, (low, high) in zip(hypothesis.floating, hypothesis.y, intervals, strict=True):
        nominal = model.number(known.axis, known.path)
        if abs(y) < _HARDLY * known.trust or (known.axis, known.path) in named:
            continue
        ends = {"low": known.moved(nominal, low), "high": known.moved(nominal, high)}
        number = {"nominal": nominal, "value": numbers[known.axis, known.path], **ends}
        found.append(_moved(model, known.axis, known.path, number, named=False))
    for one in result.told:
        effect, axis = one.standing.label
        for name, number in _parameters(result, one.standing.entries[0]).items():
            parameter = next(p for p in CATALOGUE[effect].parameters if p.name == name)
            if parameter.path is None or number["nominal"] is None or number["value"] == number["nominal"]:
                continue
            found.append(_moved(model, axis, model.number_path(axis, parameter.path), number, named=True))
    return tuple(found)


def _moved(model: AntennaModel, axis: str, path: str, number: Json, named: bool) -> Json:
    """A number of the model and where it went."""
    return {
        "axis": axis,
        "path": path,
        "from": number["nominal"],
        "to": number["value"],
        "low": number["low"],
        "high": number["high"],
        "uncertainty": model.uncertainty(axis, path),
        "named": named,
        "value": number["value"],
        "nominal": number["nominal"],
    }


__all__ = ["Verdict", "refusal", "verdict_of", "where_of"]
