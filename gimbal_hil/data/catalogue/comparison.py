"""Two runs side by side: figures, what their configurations and models differ in, and both drawn over each other."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.errors import GimbalHilError
from gimbal_hil.data.catalogue.summary import Measure, measures_of
from gimbal_hil.data.runs import RecordedRun, damage_of
from gimbal_hil.data.signals import SignalsTable, signals_of_run, unit_of
from gimbal_hil.pages.report import Block, Callout, Heading, Page, Plot, Table, Text, quantity, scaled_unit

Floats = NDArray[np.float64]

_ABSENT = "-"
#: settings that differ, by name in the headline; the table has all
_MOST_TOLD = 2
_DRAWN = ("position", "rate", "torque")


@dataclass(frozen=True)
class Comparison:
    """`measures`: (name, unit, value of the first, of the second; None where it has none). `settings`: (key, value,
    value) of what differs. `notes`: why a run could not be made a table, or is not as recorded (`sound`: both are).
    """

    names: tuple[str, str]
    measures: tuple[tuple[str, str, float | None, float | None], ...]
    settings: tuple[tuple[str, str, str], ...]
    tables: tuple[SignalsTable | None, SignalsTable | None]
    notes: tuple[str, ...]
    sound: bool

    def apart(self, tolerance: float) -> tuple[str, ...]:
        """Names of the figures that differ by more than this share of the larger one, or that only one run has."""
        return tuple(name for name, _, first, second in self.measures if _differs(first, second, tolerance))

    def within(self, tolerance: float) -> str:
        """The answer to a tolerance in words."""
        apart = self.apart(tolerance)
        if not apart:
            return f"no figure differs by more than {100.0 * tolerance:g} %"
        return f"further apart than {100.0 * tolerance:g} %: {', '.join(apart)}"

    def as_dict(self) -> dict[str, object]:
        """For JSON."""
        return {
            "runs": list(self.names),
            "figures": [
                {"name": name, "unit": unit, "first": first, "second": second}
                for name, unit, first, second in self.measures
            ],
            "settings": [{"key": key, "first": first, "second": second} for key, first, second in self.settings],
            "notes": list(self.notes),
            "sound": self.sound,
        }


def _differs(first: float | None, second: float | None, tolerance: float) -> bool:
    if first is None or second is None:
        return first is not second
    return abs(second - first) > tolerance * max(abs(first), abs(second))


def compare(first: RecordedRun, second: RecordedRun) -> Comparison:
    """How two runs differ."""
    tables: list[SignalsTable | None] = []
    notes: list[str] = []
    sound = True
    for run in (first, second):
        damage = [f"{run.folder}: damaged: {found.in_words()}" for found in damage_of(run)]
        notes += damage
        sound = sound and not damage
        try:
            tables.append(signals_of_run(run, drop_invalid=True))
        except GimbalHilError as error:
            tables.append(None)
            notes.append(str(error))
    ours, theirs = (
        {one.name: one for one in measures_of(run, table)} for run, table in zip((first, second), tables, strict=True)
    )
    measures = tuple(
        (name, (ours.get(name) or theirs[name]).unit, _value(ours.get(name)), _value(theirs.get(name)))
        for name in dict.fromkeys([*ours, *theirs])
    )
    names = (str(first.folder), str(second.folder))
    return Comparison(names, measures, _differences(first, second), (tables[0], tables[1]), tuple(notes), sound)


def comparison_page(found: Comparison, tolerance: float | None = None) -> Page:
    """The report: figures, differences, and every signal of both over each other; with a tolerance its answer first."""
    first, second = found.names
    count = len(found.settings)
    lead = comparison_headline(found)
    lead = lead if found.sound else f"Not both are what was recorded: this is of the rest. {lead}"
    blocks: list[Block] = []
    if tolerance is not None:
        said = found.within(tolerance)
        blocks.append(Callout(f"{said[:1].upper()}{said[1:]}.", "bad" if found.apart(tolerance) else "good"))
    blocks.append(Callout(lead))
    blocks += [*(Text(note) for note in found.notes), *_overlays(found), Heading("Figures")]
    rows = [[name, unit, _shown(a), _shown(b), _change(a, b)] for name, unit, a, b in found.measures]
    blocks.append(Table(["", "unit", first, second, "change"], rows, "Following errors where a loop was closed."))
    blocks += [Heading("What differs in configuration and model")]
    blocks.append(Table(["key", first, second], [list(row) for row in found.settings]) if count else Text("Nothing."))
    return Page("Two runs compared", f"gimbal-hil runs compare {first} {second}", blocks)


def comparison_headline(found: Comparison) -> str:
    """Which settings differ, and the figure that changed most."""
    settings = found.settings
    if not settings:
        return f"Configuration, model and seed are the same. {_largest_change(found)}"
    told = ", ".join(f"{key} ({first}, then {second})" for key, first, second in settings[:_MOST_TOLD])
    more = len(settings) - _MOST_TOLD
    return f"The runs differ in {told}{f' and {more} more' if more > 0 else ''}. {_largest_change(found)}"


def _largest_change(found: Comparison) -> str:
    """The figure of both that changed most against its size; what came from nothing changed most of all. How long a run
    is says nothing about the antenna.
    """
    both = [
        (name, unit, a, b)
        for name, unit, a, b in found.measures
        if a is not None and b is not None and a != b and name != "ticks"
    ]
    if not both:
        return "No figure differs."
    name, unit, a, b = max(both, key=lambda row: abs(row[3] / row[2] - 1.0) if row[2] else math.inf)
    old, new = (quantity(value, unit) if unit else f"{value:.6g}" for value in (a, b))
    return f"Most changed: {name}, from {old} to {new}."


def _overlays(found: Comparison) -> list[Block]:
    from gimbal_hil.pages.plots import ALERT, MEASURED, MODEL, peaks_kept, stacked

    first, second = found.tables
    if first is None or second is None:
        return [Text("Not both runs make a table of signals.")]
    blocks: list[Block] = []
    for axis in [axis for axis in first.axes if axis in second.axes]:
        columns = [f"{axis}.{name}" for name in _DRAWN]
        columns = [name for name in columns if name in first.columns and name in second.columns]
        titles = [title for name in columns for title in (name, f"{name}: {found.names[1]} minus {found.names[0]}")]
        apart = [difference_of(first, second, name) for name in columns]
        scales = [
            scaled_unit(float(np.max(np.abs(off), initial=0.0)), unit_of(name))
            for (_, off), name in zip(apart, columns, strict=True)
        ]
        units = [
            f"[{unit}]" for name, (_, scaled) in zip(columns, scales, strict=True) for unit in (unit_of(name), scaled)
        ]
        drawn = stacked(titles, "time since the first row [s]", units, height_each=150)
        for table, colour, label in ((first, MEASURED, found.names[0]), (second, MODEL, found.names[1])):
            for place, name in enumerate(columns):
                part = peaks_kept(table.columns[name], 1500)
                drawn.add_scatter(
                    x=table.time_s[part], y=table.columns[name][part], name=label, legendgroup=label,
                    showlegend=place == 0, line={"color": colour, "width": 1.2}, row=2 * place + 1,
                )  # fmt: skip
        for place, ((time_s, off), (factor, _)) in enumerate(zip(apart, scales, strict=True)):
            part = peaks_kept(off, 1500)
            line = {"color": ALERT, "width": 1.2}
            drawn.add_scatter(x=time_s[part], y=factor * off[part], line=line, row=2 * place + 2, showlegend=False)
        blocks.append(Plot(drawn, f"{axis}: both runs from their first row on, and their difference."))
    return blocks


def difference_of(first: SignalsTable, second: SignalsTable, name: str) -> tuple[Floats, Floats]:
    """Times (n,) of the first run that the second covers too, and by how much a signal of the second is larger there,
    (n,), on a straight line between its rows.
    """
    both = (first.time_s >= second.time_s[0]) & (first.time_s <= second.time_s[-1])
    time_s = first.time_s[both]
    return time_s, np.interp(time_s, second.time_s, second.columns[name]) - first.columns[name][both]


def _differences(first: RecordedRun, second: RecordedRun) -> tuple[tuple[str, str, str], ...]:
    ours, theirs = (_flat(_told(run)) for run in (first, second))
    keys = sorted(set(ours) | set(theirs))
    rows = ((key, ours.get(key, _ABSENT), theirs.get(key, _ABSENT)) for key in keys)
    return tuple(row for row in rows if row[1] != row[2])


def _told(run: RecordedRun) -> dict[str, object]:
    header = run.record.header
    return {
        "configuration": header.configuration,
        "model": header.model,
        "seed": header.seed,
        "lockstep": header.lockstep,
        "period_ns": header.period_ns,
        "axes": list(header.axes),
        "title": header.title,
        "software": run.record.software.get("gimbal_hil"),
    }


def _flat(content: object, prefix: str = "") -> dict[str, str]:
    """Every number and word by its dotted key; lists by their places."""
    if isinstance(content, Mapping) and content:
        pairs = content.items()
    elif isinstance(content, list) and any(isinstance(one, Mapping | list) for one in content):
        pairs = {str(place): one for place, one in enumerate(content)}.items()
    else:
        return {prefix: f"{content:.9g}" if isinstance(content, float) else str(content)}
    found: dict[str, str] = {}
    for key, value in pairs:
        found |= _flat(value, f"{prefix}.{key}" if prefix else str(key))
    return found


def _value(measure: Measure | None) -> float | None:
    return None if measure is None else measure.value


def _shown(value: float | None) -> str:
    return _ABSENT if value is None else f"{value:.6g}"


def _change(first: float | None, second: float | None) -> str:
    if first is None or second is None or first == second:
        return "" if first == second else _ABSENT
    return f"{100.0 * (second - first) / abs(first):+.2f} %" if first else "new"
