"""Two runs side by side: figures, what their configurations and models differ in, and both drawn over each other."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.errors import GimbalHilError
from gimbal_hil.data.catalogue.differences import ABSENT, EFFECTS, Rows, differences, keys_that_differ
from gimbal_hil.data.catalogue.summary import Measure, measures_of
from gimbal_hil.data.runs import RecordedRun, damage_of
from gimbal_hil.data.signals import SignalsTable, signals_of_run, unit_of
from gimbal_hil.pages.report import (
    Block,
    Callout,
    Details,
    Heading,
    Page,
    Plot,
    Table,
    Text,
    counted,
    quantity,
    scaled_unit,
)

Floats = NDArray[np.float64]

#: settings that differ, by name in the headline; the table has all
_MOST_TOLD = 2
#: figures in the headline, and the change below which a further one is not told
_MOST_FIGURES, _WORTH_TELLING = 3, 0.01
_IN_WORDS = {"seed": "seed", "title": "sequence", "axes": "axes", "software": "version"}
#: the first run, drawn wide below the second
_PALE = "#8fc1d4"
_DRAWN = ("position", "rate", "torque")


@dataclass(frozen=True)
class Comparison:
    """`measures`: (name, unit, value of the first, of the second; None where it has none). `settings`: (key, value,
    value) of what differs, `differences` the same as a person reads it. `notes`: why a run could not be made a table,
    or is not as recorded (`sound`: both are).
    """

    names: tuple[str, str]
    measures: tuple[tuple[str, str, float | None, float | None], ...]
    settings: Rows
    differences: Rows
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
    settings, readable = keys_that_differ(first, second), differences(first, second)
    return Comparison(names, measures, settings, readable, (tables[0], tables[1]), tuple(notes), sound)


def comparison_page(found: Comparison, tolerance: float | None = None) -> Page:
    """The report: what changed most, figures, what is set otherwise, every signal of both over each other, and the keys
    of all that differs; with a tolerance its answer first.
    """
    first, second = found.names
    lead = comparison_headline(found)
    blocks: list[Block] = []
    if tolerance is not None:
        said = found.within(tolerance)
        blocks.append(Callout(f"{said[:1].upper()}{said[1:]}.", "bad" if found.apart(tolerance) else "good"))
    blocks.append(Callout(lead if found.sound else f"Not both are what was recorded: this is of the rest.\n{lead}"))
    blocks += [*(Text(note) for note in found.notes), Heading("Figures")]
    rows = [[name, unit, _shown(a), _shown(b), _change(a, b)] for name, unit, a, b in found.measures]
    blocks.append(Table(["", "unit", first, second, "change"], rows, "Following errors where a loop was closed."))
    blocks.append(Heading("What differs in configuration and model"))
    settings = [list(row) for row in found.differences]
    blocks.append(Table(["", first, second], settings) if settings else Text("Nothing."))
    blocks += [Heading("Both over each other"), *_overlays(found)]
    if found.settings:
        keys = Table(["key", first, second], [list(row) for row in found.settings])
        blocks.append(Details("Every key that differs", [keys]))
    return Page("Two runs compared", f"gimbal-hil runs compare {first} {second}", blocks)


def comparison_headline(found: Comparison) -> str:
    """The figures that changed most, and on the next line what is set otherwise."""
    return f"{_largest_changes(found)}.\n{_set_otherwise(found)}."


def _set_otherwise(found: Comparison) -> str:
    """What differs in model, seed and configuration, in a few words."""
    rows = {key: (one, two) for key, one, two in found.differences}
    if not rows:
        return "Configuration, model and seed are the same" if not found.settings else "The models say it otherwise"
    told = []
    if any(key.startswith("model.") for key in rows):
        numbers = [key for key in rows if key.startswith("model.") and key not in ("model.name", EFFECTS)]
        names = ", then ".join(rows.get("model.name", ()))
        of_each = zip(("first", "second"), rows.get(EFFECTS, ()), strict=False)
        more = [f"{words.partition(' more')[0]} only in the {which}" for which, words in of_each if words != ABSENT]
        more += [counted(len(numbers), "number" if not more else "other number")] if numbers else []
        told.append(f"model ({': '.join(filter(None, (names, ', '.join(more))))})")
    told += [f"{words} {_pair(rows[key])}" for key, words in _IN_WORDS.items() if key in rows]
    rest = [key for key in rows if not key.startswith("model.") and key not in _IN_WORDS]
    told += [f"{key.removeprefix('configuration.')} {_pair(rows[key])}" for key in rest[:_MOST_TOLD]]
    told += [f"{len(rest) - _MOST_TOLD} settings more"] if len(rest) > _MOST_TOLD else []
    return f"Set otherwise: {'; '.join(told)}"


def _pair(values: tuple[str, str]) -> str:
    return f"({values[0]}, then {values[1]})"


def _largest_changes(found: Comparison) -> str:
    """The figures of both that changed most against their size; what came from nothing changed most of all. How long a
    run is says nothing about the antenna.
    """
    both = [
        (abs(b / a - 1.0) if a else math.inf, name, unit, a, b)
        for name, unit, a, b in found.measures
        if a is not None and b is not None and a != b and name != "ticks"
    ]
    both.sort(key=lambda row: -row[0])
    row_by_row = _signal_apart(found)
    if row_by_row and (not both or both[0][0] <= _WORTH_TELLING):
        # figures that are nearly the same say little of two runs of which one has a ripple
        most = f"no figure by more than {_percent(100.0 * both[0][0])}" if both else "no figure differs"
        return f"{row_by_row}; {most}"
    if not both:
        return "No figure differs"
    # the largest is told however small it is
    told = [row for number, row in enumerate(both[:_MOST_FIGURES]) if number == 0 or row[0] > _WORTH_TELLING]
    said = ", ".join(_change_in_words(*row[1:]) for row in told)
    return f"{said[:1].upper()}{said[1:]}"


def _signal_apart(found: Comparison) -> str:
    """Which signal differs most from row to row, against its own size; empty where none does, or there are no rows."""
    first, second = found.tables
    if first is None or second is None:
        return ""
    apart = []
    for name in (f"{axis}.{signal}" for axis in first.axes if axis in second.axes for signal in _DRAWN):
        if name in first.columns and name in second.columns and np.any(first.columns[name]):
            off = _rms(difference_of(first, second, name)[1])
            apart.append((off / _rms(first.columns[name]), name, off))
    share, name, off = max(apart, default=(0.0, "", 0.0))
    if share <= 0.0:
        return ""
    axis, _, signal = name.rpartition(".")
    return (
        f"Row by row the {signal} of {axis} differs by {quantity(off, unit_of(name))} rms ({_percent(100.0 * share)})"
    )


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2))) if len(values) else 0.0


def _change_in_words(name: str, unit: str, a: float, b: float) -> str:
    axis, colon, what = name.partition(": ")
    whose = f"{what} of {axis}" if colon else name
    old, new = (quantity(value, unit) if unit else f"{value:.6g}" for value in (a, b))
    if old == new:
        old, new = f"{a:.6g} {unit}".rstrip(), f"{b:.6g} {unit}".rstrip()
    number, _, scaled = old.partition(" ")
    if scaled and scaled == new.partition(" ")[2]:
        old = number
    return f"{whose} {_change(a, b)} ({old} to {new})"


def _overlays(found: Comparison) -> list[Block]:
    from gimbal_hil.pages.plots import ALERT, MODEL, peaks_kept, stacked

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
        # the first is seen beside the second where both are the same
        for table, colour, width, label in (
            (first, _PALE, 5.0, found.names[0]),
            (second, MODEL, 1.4, found.names[1]),
        ):
            for place, name in enumerate(columns):
                part = peaks_kept(table.columns[name], 1500)
                drawn.add_scatter(
                    x=table.time_s[part], y=table.columns[name][part], name=label, legendgroup=label,
                    showlegend=place == 0, line={"color": colour, "width": width}, row=2 * place + 1,
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


def _value(measure: Measure | None) -> float | None:
    return None if measure is None else measure.value


def _shown(value: float | None) -> str:
    return ABSENT if value is None else f"{value:.6g}"


def _change(first: float | None, second: float | None) -> str:
    if first is None or second is None or first == second:
        return "" if first == second else ABSENT
    if not first:
        return "new"
    return _percent(100.0 * (second - first) / abs(first), sign=True)


def _percent(share: float, sign: bool = False) -> str:
    """Two digits without an exponent; of many times as much whole percents."""
    if abs(share) >= 10.0:
        return f"{share:{'+' if sign else ''}.0f} %"
    return f"{np.format_float_positional(float(f'{share:.2g}'), sign=sign, trim='-')} %"
