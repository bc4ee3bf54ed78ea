"""What changed, in words and as the content of changed.json."""

from __future__ import annotations

from firmware_protocol.json_object import Json
from gimbal_hil.knowledge.change.comparing import FITTED, AskedCause, ChangeKind, Heard, MachineComparison
from gimbal_hil.knowledge.change.one_gain import as_one_gain
from gimbal_hil.knowledge.discrepancy import entries_of
from gimbal_hil.pages.report import between, quantity
from sim_backend.effects import CATALOGUE
from sim_backend.model import NUMBER_AT

_LISTED = 4
#: what is told of a number that moved
_OF_A_NUMBER = ("axis", "path", "from", "to", "low", "high")
#: a share of a cause that the logs before had already and that is worth saying
_HAD = 0.1


def document_of(comparison: MachineComparison) -> Json:
    """What changed.json holds."""
    found = comparison.found
    changed = {one.label: one for one in comparison.changes}
    effects, of_a_gain = _changes(comparison)
    return {
        "schema": 1,
        "verdict": comparison.kind.value,
        "text": text_of(comparison),
        "effects": effects,
        "alternatives": [
            *of_a_gain,
            *(other for other in found.alternatives if (other["instead_of"], other["instead_of_axis"]) in changed),
        ],
        "dismissed": [
            {"name": one.label[0], "axis": one.label[1], "reason": one.heard.value, **_sides(one)}
            for one in comparison.asked
            if one.heard is not Heard.AGAINST
        ],
        "shared": [
            {"name": entry["name"], "axis": entry["axis"], "status": entry["status"], "parameters": entry["parameters"]}
            for entry in comparison.shared.effects
        ],
        "something_else": None if found.something_else is None or not changed else round(found.something_else, 3),
        "moved": [{key: entry[key] for key in _OF_A_NUMBER} for entry in comparison.moved],
        "left": [
            {"axis": one.axis, "signal": one.signal, "unit": "noise floors", "before": round(one.before, 3),
             "after": round(one.after, 3), "after_with_changes": round(one.told, 3)}
            for one in comparison.left
        ],
        "smallest_shown": list(found.smallest_shown),
        "not_testable": list(found.not_testable),
        "before": {"verdict": comparison.shared.kind.value, "logs": [table.source for table in comparison.before]},
        "after": {"verdict": found.kind.value, "logs": [table.source for table in comparison.after]},
    }  # fmt: skip


def text_of(comparison: MachineComparison) -> str:
    """The answer in sentences."""
    causes, first, more = answer_of(comparison)
    rest = f"{first} {more}".strip()
    begin = "What changed" if comparison.kind is ChangeKind.CHANGED else "Something changed, perhaps this"
    return f"{begin}: {'; '.join(causes)}. {rest}" if causes else rest


def answer_of(comparison: MachineComparison) -> tuple[list[str], str, str]:
    """Each cause that changed in words, what else there is to say, and how it is known."""
    worst = max(comparison.left, key=lambda one: one.after)
    size = f"{worst.after:.1f} noise floors of the {worst.signal.replace('_', ' ')} of {worst.axis}"
    if comparison.changes:
        causes = [_change_in_words(entry) for entry in _changes(comparison)[0]]
        others = sum(one.heard is not Heard.AGAINST for one in comparison.asked)
        rest = " Other causes that were found are no change: the logs before have them too." if others else ""
        return causes, f"The model that fits the logs before leaves {size} in those after.{rest}", ""
    if comparison.kind is ChangeKind.NO_CHANGE:
        had = " and ".join(f"{one.label[0].replace('_', ' ')} on {one.label[1]}" for one in comparison.asked)
        rest = f" What is left is {had}, which the logs before have too." if had else ""
        nothing = (
            f"Nothing changed that these logs show: the model that fits those before leaves {size} in those after."
        )
        return [], nothing, f"{rest}{_would_have_shown(comparison)}".strip()
    if comparison.moved:
        numbers = [_moved_in_words(comparison, entry) for entry in comparison.moved]
        return (
            numbers,
            (
                f"The model that fits the logs before leaves {size} in those after, and {worst.told:.1f} with these "
                f"numbers, none of which moved by more than {FITTED:.0%}: a gain or a sensor's scale may be it as well."
            ),
            "",
        )
    if comparison.kind is ChangeKind.AMBIGUOUS:
        return (
            [],
            f"Something without a name changed: the model that fits the logs before leaves {size} in those after.",
            "",
        )
    asked = comparison.result.request
    rest = "Not all effects were searched: without --only and --without they may tell." if asked.limited else ""
    return (
        [],
        (
            f"These logs cannot tell: the model that fits those before leaves {size} in those after, and those before "
            f"{worst.before:.1f}; what is missing may be missing in both."
        ),
        rest,
    )


def _would_have_shown(comparison: MachineComparison) -> str:
    shown = [
        f"{CATALOGUE[one['name']].asked_as} of {one['axis']} {one['relative']:.1%}"
        for one in comparison.found.smallest_shown
        if CATALOGUE[one["name"]].asked_as and one["relative"] is not None
    ]
    return f" Smallest changes that would have shown: {', '.join(shown)}." if shown else ""


def _changes(comparison: MachineComparison) -> tuple[list[Json], list[Json]]:
    """What changed, and what a gain among them may be instead."""
    changed = {one.label: one for one in comparison.changes}
    told = [entry for entry in comparison.found.effects if _label(entry) in changed]
    return as_one_gain([_with_sides(entry, changed[_label(entry)]) for entry in told], FITTED)


def _change_in_words(entry: Json) -> str:
    parts = []
    periodic = {one.name for one in CATALOGUE[entry["name"]].parameters if one.periodic}
    for parameters in entries_of(entry):
        shown = [(key, number) for key, number in parameters.items() if key not in periodic][:_LISTED]
        for key, number in shown:
            is_now = between(number["value"], number["low"], number["high"], number["unit"])
            was = "" if number["nominal"] is None else f"was {quantity(number['nominal'], number['unit'])} and is "
            # "8 per turn" says what it is
            name = "" if number["unit"].startswith("1/") else f"{key.replace('_', ' ')} "
            parts.append(f"{name}{was}{is_now}")
    had = entry.get("share_before", 0.0)
    if had > _HAD and not CATALOGUE[entry["name"]].is_number:
        parts.append(f"{had:.0%} of it was there before")
    name = entry["name"].replace("_", " ")
    return f"{name} on {entry['axis']}: {', '.join(parts)}, probability {entry['probability']:.2f}"


def _moved_in_words(comparison: MachineComparison, entry: Json) -> str:
    """A number that moved by less than it is known to."""
    unit = NUMBER_AT[entry["path"]].unit_for(comparison.model.is_linear)
    is_now = between(entry["to"], entry["low"], entry["high"], unit)
    return f"{entry['path']} of {entry['axis']} was {quantity(entry['from'], unit)} and is {is_now}"


def _with_sides(entry: Json, one: AskedCause) -> Json:
    return {**entry, "reason": one.heard.value, "share_before": round(one.share_before, 3), **_sides(one)}


def _sides(one: AskedCause) -> Json:
    """What both sides say of a cause, rms in noise floors."""
    return {
        key: {"without": round(without**0.5, 3), "with": round(having**0.5, 3), "unit": "noise floors"}
        for key, (without, having) in (("left_before", one.before), ("left_after", one.after))
    }


def _label(entry: Json) -> tuple[str, str]:
    return entry["name"], entry["axis"]
