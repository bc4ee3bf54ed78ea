"""Which named part of an improved model paid for which part of the pointing: each left out in turn, in the arena."""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from firmware_protocol.errors import BadInputError
from firmware_protocol.json_object import Json
from gimbal_hil.loop.settings import DaemonSettings
from gimbal_hil.pages.report import Block, Callout, Heading, Plot, Table, Text
from gimbal_hil.pointing.arena.arena import ArenaResult, Entrant, run_arena
from gimbal_hil.pointing.arena.error_dots import Dots, error_dots
from gimbal_hil.pointing.arena.gained import answered, tone_of
from gimbal_hil.pointing.arena.scenarios import Scenario
from sim_backend.model import AntennaModel, model_from_document

if TYPE_CHECKING:
    from gimbal_hil.pages.plots import Drawing

BEFORE, FIRST, IMPROVED = "before", "first model", "improved"
_MICRO = 1e6
#: share of the mean squares below which two models point alike
_LEAST_GAIN = 0.05
#: share of the gain below which no part is said to carry it
_LEAST_SHARE = 0.1
#: numbers are grouped by the part that they belong to
_CALLED = {"body.mass": "weight", "body.cog": "weight", "body.inertia": "inertia"}


@dataclass(frozen=True)
class Paid:
    """An arena of a configuration before, tuned with a first model, with the improved one, and with that less each
    named part in turn.
    """

    found: ArenaResult
    antenna: str
    parts: tuple[str, ...]

    def rms(self, scenario: str, controller: str) -> float:
        """Line-of-sight error, rad rms; infinite where a guard stopped it."""
        spread = self.found.spread(scenario, self.antenna, controller, lambda one: one.los_rms)
        return float("inf") if spread is None else spread.mean

    def share(self, part: str) -> float:
        """What of the gain from the first model to the improved one is lost without a part: mean squares, summed over
        the scenarios after each was divided by its first.
        """
        lost = 0.0
        for one in self.found.scenarios:
            first, improved = self.rms(one.name, FIRST), self.rms(one.name, IMPROVED)
            lost += (self.rms(one.name, _without(part)) / first) ** 2 - (improved / first) ** 2
        return lost / (self.gained * len(self.found.scenarios)) if self.gains else 0.0

    @property
    def gained(self) -> float:
        """Share of the first model's mean squares that the improved one takes away, each scenario weighed alike."""
        ratios = [self.rms(one.name, IMPROVED) / self.rms(one.name, FIRST) for one in self.found.scenarios]
        return 1.0 - sum(ratio**2 for ratio in ratios) / len(ratios)

    @property
    def gains(self) -> bool:
        """Whether the improved model points better than the first one by so much that parts can be paid from it."""
        return self.gained > _LEAST_GAIN


def _without(part: str) -> str:
    return f"without {part}"


def changed_parts(first: AntennaModel, improved: AntennaModel) -> dict[str, AntennaModel]:
    """By name, the improved model with one changed part as the first model has it: friction, weight, inertia or a
    sensor of an axis, or an effect that was added or has other numbers. What cannot be taken back alone is left out.
    """
    groups: dict[tuple[str, str], dict[str, float]] = {}
    for (axis, path), quantity in improved.numbers.items():
        was = first.numbers.get((axis, path))
        if was is not None and abs(was.value - quantity.value) > 1e-9 * abs(was.value):
            stem = path.rsplit(".", 1)[0]
            name = _CALLED.get(path) or _CALLED.get(stem) or path.split(".")[0]
            groups.setdefault((axis, name), {})[path] = was.value
    found: dict[str, AntennaModel] = {}
    for (axis, name), values in groups.items():
        try:
            found[f"{axis} {name}"] = improved.with_numbers(axis, values)
        except BadInputError:
            continue
    before, after = _effects_by_kind(first), _effects_by_kind(improved)
    for (axis, effect), entries in after.items():
        given = before.get((axis, effect), [])
        if _amounts(given) == _amounts(entries):
            continue
        document = copy.deepcopy(improved.document)
        kept = [one for kind, ones in after.items() if kind != (axis, effect) for one in ones]
        document["effects"] = copy.deepcopy([*kept, *given])
        found[f"{axis} {effect.replace('_', ' ')}"] = model_from_document(document, improved.where)
    return found


def _effects_by_kind(model: AntennaModel) -> dict[tuple[str, str], list[Json]]:
    """Entries of the model's document by axis and name; an axis may have several of a name, as ripples."""
    found: dict[tuple[str, str], list[Json]] = {}
    for entry, effect in zip(model.document.get("effects", []), model.effects, strict=True):
        found.setdefault((effect.axis, effect.effect.name), []).append(entry)
    return found


def _amounts(entries: Sequence[Json]) -> list[dict[str, object]]:
    """What of effects acts: their numbers, wherever they come from."""
    return [
        {key: one["value"] if isinstance(one, dict) and "value" in one else one for key, one in entry.items()}
        for entry in entries
    ]


def what_paid(
    scenarios: Sequence[Scenario],
    antenna: str,
    controllers: Mapping[str, DaemonSettings],
    parts: Mapping[str, AntennaModel],
    folder: Path,
    seeds: int,
    say: Callable[[str], None] = lambda scenario: None,
) -> Paid:
    """Run the arena: `controllers` are those called BEFORE, FIRST and IMPROVED; models without a part are written into
    `folder`.
    """
    entrants = [Entrant(name, settings, name) for name, settings in controllers.items()]
    improved = controllers[IMPROVED]
    assert improved.model_control is not None, "a tuned gimbal has it"
    folder.mkdir(parents=True, exist_ok=True)
    for name, model in parts.items():
        file = folder / f"without_{name.replace(' ', '_')}.yaml"
        file.write_text(model.to_yaml(), encoding="utf-8")
        control = improved.model_control.model_copy(update={"model": str(file)})
        settings = improved.model_copy(update={"model_control": control})
        entrants.append(Entrant(_without(name), settings, f"improved, {name} as the first model has it"))
    return Paid(run_arena(scenarios, [antenna], entrants, seeds, say=say), antenna, tuple(parts))


def paid_text(paid: Paid) -> str:
    """Both tables for the terminal."""
    rows = [("scenario", BEFORE, FIRST, IMPROVED), *_gains(paid)]
    lines = [_answer(paid), "line of sight, µrad rms", *_aligned(rows), ""]
    if paid.parts:
        lines += ["left out of the improved model", *_aligned([_header(paid), *_losses(paid)])]
    return "\n".join(lines)


def paid_blocks(paid: Paid) -> list[Block]:
    """The report as sections of a page."""
    blocks: list[Block] = [
        Callout(_answer(paid), tone_of(_pairs(paid))),
        Plot(_dots(paid), "Line-of-sight error; the axis is logarithmic."),
        Heading("Pointing before and after"),
        Text(
            "Line-of-sight error, µrad rms, of the antenna's true joints: the configuration as it was, tuned with the "
            "first model, and tuned with the improved one."
        ),
        Table(("Scenario", BEFORE, FIRST, IMPROVED), _gains(paid)),
        Heading("What paid for it"),
    ]
    if not paid.parts:
        return [*blocks, Text("The improved model differs from the first one in nothing that the loops use.")]
    return [
        *blocks,
        Text(
            "Each named part in turn as the first model has it, all else improved. Shares are of mean squares, each "
            "scenario weighed alike; parts that help each other do not add up to the whole."
        ),
        Table(tuple(word[:1].upper() + word[1:] for word in _header(paid)), _losses(paid)),
    ]


def _answer(paid: Paid) -> str:
    """How many times smaller the error is, and which part that hangs on."""
    said = answered("Tuned with the improved model", _pairs(paid), paid.antenna)
    if not paid.gains:
        said += (
            " With the first model it is as good: it is the tuning that gains here, and what the improved model knows "
            "better matters to none of these motions."
        )
    elif paid.parts:
        most = max(paid.parts, key=paid.share)
        if paid.share(most) < _LEAST_SHARE:
            said += " No part alone carries a tenth of the gain over the first model."
        else:
            said += f" Most is lost without {most}: {100.0 * paid.share(most):.0f} % of the gain over the first model."
    return said


def _pairs(paid: Paid) -> dict[str, tuple[float, float]]:
    return {one.name: (paid.rms(one.name, BEFORE), paid.rms(one.name, IMPROVED)) for one in paid.found.scenarios}


def _dots(paid: Paid) -> Drawing:
    from gimbal_hil.pages.plots import MEASURED, MODEL, REFERENCE

    names = [one.name for one in paid.found.scenarios]
    compared = [
        Dots(which, colour, [_MICRO * paid.rms(name, which) for name in names])
        for which, colour in ((BEFORE, REFERENCE), (FIRST, MODEL), (IMPROVED, MEASURED))
    ]
    return error_dots("Line-of-sight error", names, compared)


def _gains(paid: Paid) -> list[tuple[str, ...]]:
    return [
        (one.name, *(f"{_MICRO * paid.rms(one.name, name):.3g}" for name in (BEFORE, FIRST, IMPROVED)))
        for one in paid.found.scenarios
    ]


def _header(paid: Paid) -> tuple[str, ...]:
    return ("without", "of the gain", *(one.name for one in paid.found.scenarios))


def _losses(paid: Paid) -> list[tuple[str, ...]]:
    ordered = sorted(paid.parts, key=paid.share, reverse=True)
    return [
        (
            part,
            f"{100.0 * paid.share(part):.1f} %" if paid.gains else "-",
            *(f"{_MICRO * paid.rms(one.name, _without(part)):.3g}" for one in paid.found.scenarios),
        )
        for part in ordered
    ]


def _aligned(rows: Sequence[Sequence[str]]) -> list[str]:
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    return ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows]
