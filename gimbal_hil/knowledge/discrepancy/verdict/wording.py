"""The verdict in plain words: what was found, how sure it is, and what is left."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from firmware_protocol.json_object import Json
from gimbal_hil.knowledge.discrepancy.inquiry import rms
from gimbal_hil.knowledge.discrepancy.judgement import Denial, Kind, Result, Status, Told
from gimbal_hil.knowledge.discrepancy.verdict.gaps import Gap, closed_most, largest, share_text, still_open
from gimbal_hil.knowledge.discrepancy.verdict.headlines import MOST_NUMBERS, answer_of, at_first, name_of
from gimbal_hil.knowledge.discrepancy.verdict.laws import told_laws
from gimbal_hil.knowledge.discrepancy.verdict.separating import UPRIGHT
from gimbal_hil.pages.report import between, quantity
from sim_backend.effects import CATALOGUE, FittedNumber, Variable
from sim_backend.model import NUMBER_AT, AntennaModel, mass_stands_in

#: the share of `Policy.uneven` from which a varying strength alone costs a name; and one that is known to this share
_TOLD = 0.45
#: the rule of a torque column that is early or late
SHIFTED = "torque_shifted"
#: what looks like a torque column that is late, or early: nothing acts before its command, but a drive may act late
_ELSE = {
    True: "No drive acts before its command, so it is the log; state it",
    False: "A delay of the drive looks the same; if it is the log, state it",
}


@dataclass(frozen=True)
class Said:
    """A verdict in words. `answer`: what was found, a line for each cause; `grounds`: how large and how sure; `left`:
    what it leaves unexplained; `against`: where the logs contradict themselves.
    """

    answer: str
    grounds: str = ""
    left: str = ""
    against: str = ""
    #: whether it is true of other numbers than the model's
    moved: bool = False

    @property
    def text(self) -> str:
        """All of it in one line."""
        parts = (self.answer.replace("\n", " "), self.grounds, self.left, self.against)
        return " ".join(part for part in parts if part)


def told(
    result: Result,
    effects: Sequence[Json],
    alternatives: Sequence[Json],
    gaps: Sequence[Gap],
    moved_numbers: Sequence[Json],
) -> Said:
    """What was found and how sure it is; `moved_numbers` are known ones, as in `recalibrated`."""
    kind = result.decision.kind
    left = _recalibration(gaps)
    only_moved = left and f"{_where_moved(result.model, moved_numbers)}; {left}"
    if kind is Kind.NO_DISCREPANCY:
        limit = _no_gap(gaps, result.request.policy.least_gap)
        only = f" only {only_moved}" if left else ""
        others = bool(left) and any(not one["named"] for one in moved_numbers)
        grounds = f"{_would_have_shown(result)}{limit}"
        return Said(f"The model explains this data to its noise{only}.", grounds, moved=others)
    if kind is Kind.CANNOT_JUDGE:
        moved = f" ({only_moved})" if left else ""
        least = result.request.policy.least_gap
        limits = ", ".join(f"{quantity(least * g.noise_floor, g.unit)} in the {_of_channel(g)}" for g in gaps)
        return Said(
            f"There is no gap{moved}, but these logs cannot judge the model.",
            f"{told_hidden(result)} {_would_have_shown(result)} Gaps below these sizes do not show: {limits}."
            f"{_no_gap(gaps, least)}".strip(),
        )
    if kind is Kind.UNEXPLAINED:
        return _unexplained(result, gaps)
    if kind is Kind.DESCRIBED:
        looks, known = told_laws(result)
        size = _size("The largest gap is", largest(gaps))
        return Said(f"No name fits. {looks}", f"{size}. {known}", _remainder(gaps))
    gap = closed_most(gaps)
    moved = f" ({left} where known numbers move within their stated uncertainty)" if left else ""
    it = "They explain" if len(effects) > 1 else "Either explains" if alternatives else "It explains"
    share = "" if gap.closed_fraction is None else f" {share_text(gap.closed_fraction)} of"
    which = "the largest gap" if gap is largest(gaps) else "a gap"
    size = f"the {_of_channel(gap)}, {_floors(gap)}"
    first = f"{it}{share} {which} {_where_judged(result)}: {size}{moved}."
    if all(one.standing.silent for one in result.told):
        first = f"Only the searched logs show a gap{moved}."
    against = "".join(f" {e['contradiction']}" for e in effects if "contradiction" in e)
    forms = "".join(_undetermined(e) for e in effects if "form_undetermined" in e)
    return Said(answer_of(effects, alternatives), first + _doubts(result) + forms + against, _remainder(gaps))


def _would_have_shown(result: Result) -> str:
    """From which size on errors of the numbers that people ask about would have shown."""
    said = []
    for axis in result.model.axes:
        sizes = {one.name: one.relative for one in result.smallest if one.axis == axis and one.relative is not None}
        asked = {effect.name: effect.asked_as for effect in CATALOGUE.values() if effect.asked_as}
        # what would not have shown at half or twice the number is said apart
        asked = {name: words for name, words in asked.items() if (name, axis) not in result.hidden}
        shown = [f"{words} {_share(sizes[name])}" for name, words in asked.items() if sizes.get(name, 2.0) <= 1.0]
        said.append(f"on {axis} {', '.join(shown)}" if shown else f"on {axis} none")
    return f"Smallest errors that would have shown: {'; '.join(said)}."


def _share(size: float) -> str:
    return f"{size:.0%}" if size >= 0.01 else f"{100.0 * size:.1g}%"


def _of_channel(gap: Gap) -> str:
    return f"{gap.signal.replace('_', ' ')} of {gap.axis}"


def _no_gap(gaps: Sequence[Gap], least: float) -> str:
    """What passes for noise although it is larger than its floor."""
    gap = max(gaps, key=lambda g: g.after / g.noise_floor)
    floors = gap.after / gap.noise_floor
    if floors <= least:
        return ""
    where = f"The {_of_channel(gap)} still has a gap of {floors:.1f} noise floors"
    return f" {where}: motion that does not repeat, or friction whose level wanders a little, leaves as much."


def _recalibration(gaps: Sequence[Gap]) -> str:
    """What is left once known numbers move, where that is less."""
    gap = largest(gaps)
    if gap.before - gap.after_recalibration <= 0.1 * gap.before or gap.before <= 1.1 * gap.noise_floor:
        return ""
    return f"that leaves {quantity(gap.after_recalibration, gap.unit)}"


def _where_moved(model: AntennaModel, numbers: Sequence[Json]) -> str:
    """The known numbers that moved farthest."""
    inside = [one for one in numbers if not one["named"]]
    if not inside:
        return "where its numbers and the zeros of the logs move a little"
    farthest = sorted(inside, key=lambda one: -abs(one["to"] - one["from"]) / one["uncertainty"])[:MOST_NUMBERS]
    said = ", ".join(_moved(model, one) for one in farthest)
    rest = f" and {len(inside) - MOST_NUMBERS} more" if len(inside) > MOST_NUMBERS else ""
    return f"where known numbers move within their stated uncertainty: {said}{rest}"


def _moved(model: AntennaModel, one: Json) -> str:
    """A known number that moved: where to, from where, and between which limits these logs know it."""
    unit = NUMBER_AT[one["path"]].unit_for(model.is_linear)
    interval = f"{one['low']:.4g} to {one['high']:.4g}"
    return f"{one['axis']} {one['path']} {one['to']:.4g} {unit} ({interval}; model: {one['from']:.4g})"


def _where_judged(result: Result) -> str:
    return "on the last part of the same log" if result.suspected_only else "on data that had no part in the search"


def _unexplained(result: Result, gaps: Sequence[Gap]) -> Said:
    tried = ", ".join(dict.fromkeys(name_of(*label) for label in result.path.state.hypothesis.labels))
    shape = max(result.decision.remainders, key=lambda r: r.after)
    seen = ""
    over = result.decision.depends_on
    if over is not None:
        seen = f" From the {over[0].value} alone, {over[1]:.0%} of what is left can be predicted."
    elif shape.predictable.beyond > 0.1:
        seen = f" From the motion, {shape.predictable.beyond:.0%} of what is left can be predicted."
    searched = "Nothing in the catalogue"
    if result.request.only or result.request.without:
        searched = "None of the effects that were searched"
    attempt = "no candidate makes the hold-out better"
    if tried:
        least = float(np.max(result.path.state.left()))
        attempt = f"the best attempt ({tried}) leaves {least:.1f} noise floors and is not confirmed"
    where = " Only the hold-out has this gap." if result.only_in_hold_out else ""
    gap = largest(gaps)
    if gap.before > result.request.policy.least_gap * gap.noise_floor:
        answer = f"{searched} explains the {_of_channel(gap)}: {_floors(gap)}."
    else:
        answer = f"{searched} explains {_elsewhere(result, gaps)}, and the rows that judge do not have it."
    return Said(answer, f"{at_first(attempt)}.{where}{seen}")


def _elsewhere(result: Result, gaps: Sequence[Gap]) -> str:
    """The largest gap of rows that were fitted or that selected, which is all that there is where those that judge have
    none.
    """
    parts = {"in the searched logs": result.null.fitted, "in the first half of the hold-out": result.null.selecting}
    found = [(float(left), gap, of) for of, rows in parts.items() for left, gap in zip(rms(rows), gaps, strict=True)]
    floors, gap, of = max(found, key=lambda one: one[0])
    size = f"{quantity(floors * gap.noise_floor, gap.unit)} or {floors:.3g} times the noise floor"
    return f"the {_of_channel(gap)} {of}: {size}"


def _doubts(result: Result) -> str:
    """Why a name is not sure, where that is not what cannot be told from it, which the answer says."""
    if result.suspected_only and result.only_in_hold_out:
        return " Only the hold-out has this gap, and no log of another trajectory: it is suspected, not shown."
    if result.suspected_only:
        return " There is no log of another trajectory to judge it on: it is suspected, not shown."
    found = []
    for one in result.told:
        if one.status is Status.NAMED:
            continue
        name, axis = one.standing.label
        said = name_of(name, axis)
        denied = [denial for denial in one.denials if denial.label == one.standing.label]
        if denied:
            found += [f" {_denied(denial)}" for denial in denied]
        elif one.standing.silent:
            found.append(f" The hold-out has no trace of {said}, which is therefore suspected, not shown.")
        elif one.standing.at_bound:
            stands = ", ".join(one.standing.at_bound)
            found.append(
                f" {at_first(said)} stands at the bound of what is possible ({stands}): nothing is known of it."
            )
        elif not (one.close or one.denials):
            found.append(f" {at_first(said)} is probable only ({one.probability:.0%}){_why(result, one)}.")
    return "".join(found)


def _denied(one: Denial) -> str:
    """What `identify` says against a number that would be off."""
    said = f"{one.identified:.4g} {one.unit} ({one.low:.4g} to {one.high:.4g})"
    return (
        f"identify denies {name_of(*one.label)}: of the same logs it says {one.parameter} {said}, nearer to the "
        f"model's {one.stated:.4g} than to {one.told:.4g}; nothing beside it on {one.label[1]} is a name then."
    )


def _why(result: Result, one: Told) -> str:
    """What about its strength alone would cost a cause its name; empty where nothing would."""
    if one.standing.uneven > _TOLD * result.request.policy.uneven:
        return f": fitted to stretches of the logs by themselves, its strength differs by {one.standing.uneven:.0%}"
    if one.standing.error > _TOLD:
        return f": beside everything else that is there, its strength is known to {one.standing.error:.0%} only"
    return ""


def _floors(gap: Gap) -> str:
    size = between(gap.before, gap.before_low, gap.before_high, gap.unit)
    return f"{size} or {gap.before / gap.noise_floor:.3g} times the noise floor"


def _size(start: str, gap: Gap) -> str:
    return f"{start} in the {_of_channel(gap)}: {_floors(gap)}"


def _undetermined(effect: Json) -> str:
    form = effect["form_undetermined"]
    name, alike = name_of(effect["name"], effect["axis"]), " and ".join(form["between"])
    correlation = f"{alike} have a canonical correlation of {form['canonical_correlation']:.2f}"
    return f" The form of {name} is undetermined on this data: {correlation}."


def told_standing_in(result: Result) -> str:
    """That a weight is told of an axis whose model states no mass."""
    labels = (one.standing.label for one in result.told)
    weighed = (axis for name, axis in labels if Variable.ATTITUDE in CATALOGUE[name].acts_through)
    return "".join(
        f" The model states no mass of {axis}: 1 kg stands in for it, and the centre of mass is where 1 kg would be."
        for axis in dict.fromkeys(weighed)
        if mass_stands_in(result.model, axis)
    )


def told_unseen(result: Result, unseen: Sequence[Json]) -> str:
    """Which effects that were asked for these data cannot show; a weight too, where something over position is told of
    an axis that the model has upright, or was tried there.
    """
    labels = [one.standing.label for one in result.told] or result.path.state.hypothesis.labels
    placed = {axis for name, axis in labels if name in CATALOGUE and Variable.POSITION in CATALOGUE[name].acts_through}
    asked = [e for e in unseen if e["name"] in result.request.only or (e["reason"] == UPRIGHT and e["axis"] in placed)]
    return "".join(f" {at_first(name_of(e['name'], e['axis']))} was not tested: {e['reason']}." for e in asked)


def told_hidden(result: Result) -> str:
    """Which numbers could be off by a factor of two, except those that the verdict names."""
    told = {one.standing.label for one in result.told}
    axes_of: dict[str, list[str]] = {}
    for name, axis in result.hidden:
        if (name, axis) not in told:
            axes_of.setdefault(CATALOGUE[name].asked_as, []).append(axis)
    # what is hidden on the same axes is told once
    names_on: dict[str, list[str]] = {}
    for name, axes in axes_of.items():
        names_on.setdefault(" or ".join(axes), []).append(name)
    hidden = ", or the right ".join(f"{_one_of(names)} on {axes}" for axes, names in names_on.items())
    return f" These logs would not have shown half or twice the right {hidden}." if hidden else ""


def _one_of(names: Sequence[str]) -> str:
    """`inertia, torque gain or viscosity`."""
    return " or ".join(part for part in (", ".join(names[:-1]), names[-1]) if part)


def told_against(found: Json) -> str:
    """A contradiction of the logs among themselves, in one sentence."""
    rule, why = found["rule"].replace("_", " "), found["text"].split(":")[0]
    return f" The data contradict themselves on {found['axis']} ({rule}, {why})."


def told_shifts(found: Sequence[Json]) -> str:
    """Torque columns that are early or late, all axes together: how much, what looks the same, and how to state it."""
    said = []
    for late, otherwise in _ELSE.items():
        those = [one for one in found if (one["late_s"] > 0.0) == late]
        if not those:
            continue
        sizes = ", ".join(map(_shift, those))
        options = " ".join(one["state_as"] for one in those)
        columns = "The torque column is" if len(those) == 1 else "The torque columns are"
        way = "late" if late else "early"
        said.append(f"{columns} {way} against the positions: {sizes}. {otherwise}: --column {options}.")
    return " ".join(said)


def _shift(one: Json) -> str:
    low, size, high = (1e3 * value for value in sorted(abs(one[key]) for key in ("low_s", "late_s", "high_s")))
    return f"{one['axis']} {size:.3g} ms ({low:.3g} to {high:.3g})"


def told_contradictions(found: Sequence[Json]) -> list[str]:
    """Each contradiction in full, torque columns of all axes in one."""
    shifted = [one for one in found if one["rule"] == SHIFTED]
    others = [f"{one['axis']}: {one['text']}." for one in found if one["rule"] != SHIFTED]
    return [*others, *([told_shifts(shifted)] if shifted else [])]


def _remainder(gaps: Sequence[Gap]) -> str:
    """What the causes leave, in its unit and in floors of the model with them."""
    left = ((gap, f"{gap.after / gap.noise_floor_after:.3g} noise floors") for gap in still_open(gaps))
    places = ", ".join(f"{_of_channel(gap)} {quantity(gap.after, gap.unit)} ({floors})" for gap, floors in left)
    return f"Still unexplained: {places}." if places else ""


def contradiction_of(effect: Json) -> str:
    """What a fitted number says against the law that it belongs to; empty where there is nothing."""
    objection = CATALOGUE[effect["name"]].objection
    return (
        objection({name: FittedNumber(**number) for name, number in effect["parameters"].items()})
        if objection is not None
        else ""
    )
