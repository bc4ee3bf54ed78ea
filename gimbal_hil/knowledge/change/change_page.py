"""The report of a comparison: what changed, how surely, what was missing on both sides, what would not have shown."""

from __future__ import annotations

from typing import TYPE_CHECKING

from firmware_protocol.json_object import Json
from gimbal_hil.knowledge.change.comparing import ChangeKind, MachineComparison
from gimbal_hil.knowledge.change.telling import answer_of, document_of
from gimbal_hil.knowledge.discrepancy import entries_of, smallest_shown
from gimbal_hil.pages.report import Block, Callout, Details, Heading, Page, Plot, Table, Text, Tiles, quantity

if TYPE_CHECKING:
    from gimbal_hil.pages.plots import Drawing

_TONES = {
    ChangeKind.CHANGED: "warning",
    ChangeKind.AMBIGUOUS: "warning",
    ChangeKind.NO_CHANGE: "good",
    ChangeKind.CANNOT_JUDGE: "warning",
}


def change_page(comparison: MachineComparison) -> Page:
    """The page for one comparison."""
    document = document_of(comparison)
    worst = max(comparison.left, key=lambda one: one.after)
    causes, count = bool(comparison.found.effects), len(document["effects"])
    blocks: list[Block] = [
        _said(comparison),
        Tiles(
            (
                (comparison.kind.value.replace("_", " "), "verdict"),
                (str(count), "cause that changed" if count == 1 else "causes that changed"),
                (f"{worst.before:.1f} → {worst.after:.1f}", "noise floors left, logs before → after"),
                *([(f"{worst.told:.1f}", "left of those after with the causes told for them")] if causes else []),
            )
        ),
    ]
    if document["effects"]:
        blocks += [Heading("What changed"), _changes(document)]
    blocks += [
        Heading("What the model of the machine before leaves"),
        Plot(
            _left_figure(comparison),
            "Rms left by the model that was fitted to the logs before, in noise floors of each channel: of those logs, "
            + (
                "of the logs after, and of the logs after with the causes that were told for them."
                if causes
                else "and of the logs after."
            ),
        ),
    ]
    if document["dismissed"]:
        blocks += [Heading("Found, and no change"), _dismissed(document)]
    if document["shared"]:
        blocks += [Heading("Missing in the model on both sides"), _shared(document)]
    blocks += _unseen(document)
    sides = [f"{side}: {', '.join(document[side]['logs'])}" for side in ("before", "after")]
    blocks.append(Details("Data", [Text("; ".join(sides))]))
    verdict = comparison.kind.value.replace("_", " ")
    return Page("What changed", f"Model {comparison.start.name}; verdict: {verdict}", blocks)


def _said(comparison: MachineComparison) -> Callout:
    """The answer: a line for each cause, then how it is known."""
    causes, first, more = answer_of(comparison)
    tone, perhaps = _TONES[comparison.kind], "" if comparison.kind is ChangeKind.CHANGED else "Perhaps "
    lines = [f"{perhaps}{cause}." if perhaps else f"{cause[0].upper()}{cause[1:]}." for cause in causes]
    return Callout("\n".join(lines), tone, f"{first} {more}".strip()) if lines else Callout(first, tone, more)


def _changes(document: Json) -> Table:
    rows = []
    for entry in document["effects"]:
        against = entry["left_before"]
        for parameters in entries_of(entry):
            for key, number in parameters.items():
                unit = "" if number["unit"] == "1" else f" {number['unit']}"
                rows.append(
                    (
                        f"{entry['name']} ({entry['axis']})",
                        entry["status"],
                        key,
                        "not there" if number["nominal"] is None else f"{number['nominal']:.4g}{unit}",
                        f"{number['value']:.4g}{unit}",
                        f"{number['low']:.4g} .. {number['high']:.4g}",
                        f"{entry['probability']:.2f}",
                        f"{against['without']:.2g} → {against['with']:.2g}",
                    )
                )
    head = ("cause", "status", "parameter", "before", "after", "interval", "probability", "left of the logs before")
    return Table(
        head,
        rows,
        "The last column is the proof: put into the model of the machine before, the cause fits the logs before worse "
        "(rms in noise floors, without → with it).",
    )


def _dismissed(document: Json) -> Table:
    rows = [
        (
            f"{one['name']} ({one['axis']})",
            one["reason"],
            f"{one['left_before']['without']:.2g} → {one['left_before']['with']:.2g}",
        )
        for one in document["dismissed"]
    ]
    return Table(("cause", "why it is no change", "left of the logs before, without → with it"), rows)


def _shared(document: Json) -> Table:
    rows = [
        (
            f"{one['name']} ({one['axis']})",
            one["status"],
            ", ".join(
                f"{key} {quantity(number['value'], number['unit'])}" for key, number in one["parameters"].items()
            ),
        )
        for one in document["shared"]
    ]
    return Table(("cause", "status", "numbers"), rows, "They are part of the model of the machine before.")


def _unseen(document: Json) -> list[Block]:
    """What these logs would not have shown."""
    blocks: list[Block] = [*smallest_shown(document["smallest_shown"], "changes")]
    if document["not_testable"]:
        rows = [(one["name"], one["axis"], one["reason"]) for one in document["not_testable"]]
        blocks.append(Details("Not told by these logs", [Table(("effect", "axis", "reason"), rows)]))
    return blocks


def _left_figure(comparison: MachineComparison) -> Drawing:
    from gimbal_hil.pages.plots import MEASURED, MODEL, REFERENCE, figure, in_floors

    labels = [f"{one.axis}<br>{one.signal.replace('_', ' ')}" for one in comparison.left]
    drawn = figure("Left over, in noise floors", "", "rms / noise floor", 340)
    sides = [
        ("logs before", [one.before for one in comparison.left], REFERENCE),
        ("logs after", [one.after for one in comparison.left], MEASURED),
    ]
    if comparison.found.effects:
        sides.append(("logs after, causes added", [one.told for one in comparison.left], MODEL))
    for name, values, colour in sides:
        drawn.add_bar(name=name, x=labels, y=values, marker=dict(color=colour))
    # room for the words of the line beside the last bars
    drawn.update_xaxes(range=[-0.5, len(labels) - 0.1], tickangle=0)
    in_floors(drawn, [size for one in comparison.left for size in (one.before, one.after, one.told)])
    return drawn
