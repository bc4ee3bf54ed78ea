"""The verdict in plain words: what was found, how sure it is, and what is left."""

from __future__ import annotations

from typing import Any

import numpy as np

from gimbal_hil.discrepancy.completeness import COMPLETE_FLOORS, HARDLY_A_GAP
from gimbal_hil.discrepancy.workflow import Diagnosis
from sim_backend.effects import CATALOGUE, FittedNumber

#: one effect, alternative or gap as verdict.json holds it
Entry = dict[str, Any]


def told(diagnosis: Diagnosis, verdict: str, effects: list[Entry], alternatives: list[Entry], gaps: list[Entry]) -> str:
    """What was found and how sure it is, from the entries of verdict.json."""
    if verdict == "no_discrepancy":
        return _nothing_missing(diagnosis, gaps)
    if verdict == "unexplained":
        return _unexplained(diagnosis, gaps)
    doubt = "" if verdict == "named" else _doubt(diagnosis, effects, alternatives)
    against = "".join(f" {e['contradiction']}" for e in effects if "contradiction" in e)
    forms = "".join(_undetermined(e) for e in effects if "form_undetermined" in e)
    return f"{_explained(diagnosis, effects, gaps)}.{doubt}{forms}{against}{_remainder(diagnosis, gaps)}"


def _explained(diagnosis: Diagnosis, effects: list[Entry], gaps: list[Entry]) -> str:
    """The gap and what closes it. Causes are told by the gap that they close, which need not be the largest."""
    largest = _largest(gaps)
    gap = max(gaps, key=lambda g: (g["before"] - g["after"]) / g["noise_floor"])
    if gap["before"] - gap["after"] <= 0.1 * gap["noise_floor"]:
        gap = largest
    share, closed = gap["closed_fraction"], ""
    if gap is largest and gap["before"] - gap["after"] <= 0.02 * gap["before"]:
        # nothing of it shows on the hold-out: what was closed is a gap of the fitted logs
        rms = [float(np.max(np.sqrt(np.mean(state.fit.residual**2, axis=0)))) for state in (diagnosis.null, diagnosis.best)]
        closed = f", which takes the fitted logs from {rms[0]:.1f} to {rms[1]:.1f} floors"
    elif share is not None:
        untouched = "the last part of the same log" if diagnosis.suspected_only else "data that had no part in the search"
        closed = f", which closes {share:.0%} of it on {untouched}"
    names = ", ".join(_name(e["name"], e["axis"]) for e in effects)
    return f"{_size('The largest gap is' if gap is largest else 'A gap is', gap)}. It is explained by {names}{closed}"


def _nothing_missing(diagnosis: Diagnosis, gaps: list[Entry]) -> str:
    gap = _largest(gaps)
    moved = " once the known numbers were refitted within a few per cent" if diagnosis.floated is not None else ""
    changing = diagnosis.only_noise and gap["before"] / gap["noise_floor"] > COMPLETE_FLOORS
    level = " whose level changes from row to row" if changing else ""
    return f"The model explains this data to its noise{level}{moved}; nothing is missing that it could show."


def _unexplained(diagnosis: Diagnosis, gaps: list[Entry]) -> str:
    size = _size("The largest gap is", _largest(gaps))
    least, before = (float(np.max(diagnosis.search.gaps(state))) for state in (diagnosis.best, diagnosis.null))
    tried = ", ".join(_name(*label) for label in diagnosis.best.hypothesis.labels)
    if tried and least <= COMPLETE_FLOORS and before < HARDLY_A_GAP:
        return f"{size}. That is too little to name a cause for: {tried} would take it to {least:.1f} floors, but so may what is no cause."
    nothing = f"{size}. Nothing in the catalogue explains what is there"
    if not tried:
        return f"{nothing}: no candidate earned its place on the hold-out."
    return f"{nothing}: the best attempt ({tried}) leaves {least:.1f} floors on the logs or the hold-out."


def _doubt(diagnosis: Diagnosis, effects: list[Entry], alternatives: list[Entry]) -> str:
    """Why a name is not sure."""
    if diagnosis.suspected_only:
        return " There is no log of another trajectory to judge it on: it is suspected, not shown."
    rivals = {other["instead_of"] for other in alternatives}
    silent = [e for e in effects if e["status"] == "ambiguous" and e["name"] not in rivals]
    names = ", ".join(_name(e["name"], e["axis"]) for e in silent)
    unheard = f" The hold-out has no trace of {names}, which is therefore suspected, not shown." if silent else ""
    if len(silent) == sum(e["status"] == "ambiguous" for e in effects):
        return unheard
    open_ones = "; ".join(_cannot_tell(e, alternatives) for e in effects if e["status"] == "ambiguous" and e["name"] in rivals)
    return f" {open_ones}. The run that would tell is proposed.{unheard}"


def _cannot_tell(effect: Entry, alternatives: list[Entry]) -> str:
    others = [_name(other["name"], other["axis"]) for other in alternatives if other["instead_of"] == effect["name"]]
    return f"{_name(effect['name'], effect['axis']).capitalize()} cannot be told from {' or '.join(dict.fromkeys(others))} on this data"


def _name(effect: str, axis: str) -> str:
    return f"{effect.replace('_', ' ')} on {axis}"


def _largest(gaps: list[Entry]) -> Entry:
    return max(gaps, key=lambda g: g["before"] / g["noise_floor"])


def _size(start: str, gap: Entry) -> str:
    size = f"{gap['before']:.3g} {gap['unit']}, {gap['before'] / gap['noise_floor']:.1f} times its floor"
    return f"{start} in the {gap['signal'].replace('_', ' ')} of {gap['axis']}: {size}"


def _undetermined(effect: Entry) -> str:
    form = effect["form_undetermined"]
    name, alike = _name(effect["name"], effect["axis"]), " and ".join(form["between"])
    return f" The form of {name} is undetermined on this data: {alike} have a canonical correlation of {form['canonical_correlation']:.2f}."


def told_against(found: dict[str, str]) -> str:
    """A contradiction of the logs among themselves, in one sentence."""
    return f" The data contradict themselves on {found['axis']} ({found['rule'].replace('_', ' ')}, {found['text'].split(':')[0]})."


def _remainder(diagnosis: Diagnosis, gaps: list[Entry]) -> str:
    """What the named causes leave untouched on other channels."""
    if not diagnosis.search.exact:
        return ""
    left = [g for g in gaps if g["after"] > COMPLETE_FLOORS * g["noise_floor"]]
    places = ", ".join(f"{g['signal'].replace('_', ' ')} of {g['axis']} {g['after'] / g['noise_floor']:.1f} floors" for g in left)
    return f" Still unexplained beside it: {places}." if places else ""


def contradiction_of(effect: Entry) -> str:
    """What a fitted number says against the law that it belongs to; empty where there is nothing."""
    objection = CATALOGUE[effect["name"]].objection
    return objection({name: FittedNumber(**number) for name, number in effect["parameters"].items()}) if objection is not None else ""
