"""The report of friction over temperature: every number against temperature with its interval, and the table itself."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from gimbal_hil.knowledge.identification.estimate import Determination, number_text
from gimbal_hil.knowledge.identification.over_temperature import TemperatureResult, gaps, uncovered, values_at
from gimbal_hil.knowledge.identification.stribeck import LUGRE_NAMES
from gimbal_hil.pages.report import Block, Callout, Heading, Page, Plot, Table, Text
from sim_backend.model import AntennaModel

if TYPE_CHECKING:
    from gimbal_hil.pages.plots import Drawing

#: what is drawn, from the top
_DRAWN = ("coulomb", "breakaway", "viscous", "stribeck_velocity")


def over_temperature_page(model: AntennaModel, found: Sequence[TemperatureResult], sources: Sequence[str]) -> Page:
    """Everything that the runs said, `model` being the one with the table."""
    axes = [result.axis for result in found[0].results]
    told = [e for one in found for result in one.results for e in result.estimates if e.name in LUGRE_NAMES]
    sure = sum(e.verdict is Determination.IDENTIFIED for e in told)
    missing = uncovered(found)
    temperatures = ", ".join(f"{one.temperature_degc:.0f}" for one in found)
    said = f"Friction at {temperatures} degC; {sure} of {len(told)} numbers identified."
    blocks: list[Block] = [
        Callout(f"{said} {missing[:1].upper()}{missing[1:]}{'.' if missing else ''}", "warning" if missing else "good")
    ]
    for axis in axes:
        blocks += [
            Heading(axis),
            Plot(_figure(found, axis), "Identified and weakly identified numbers with their 95 % intervals."),
            Table(
                ("Temperature [degC]", *(name.replace("_", " ") for name in LUGRE_NAMES)),
                [(f"{one.temperature_degc:.1f}", *(_cell(one, axis, name) for name in LUGRE_NAMES)) for one in found],
                "SI units, with half of the 95 % interval; in brackets what was not identified: the prior's is kept.",
            ),
        ]
    if notes := gaps(found):
        blocks += [Heading("Where another run would help"), *(Text(note) for note in notes)]
    blocks.append(Text(f"From {', '.join(sources)}. Between rows friction is interpolated, beyond them held."))
    return Page("Friction over temperature", f"model {model.name}", blocks)


def _cell(one: TemperatureResult, axis: str, name: str) -> str:
    estimates = next(result.estimates for result in one.results if result.axis == axis)
    found = next((e for e in estimates if e.name == name), None)
    if found is None:
        return "-"
    if found.verdict is Determination.NOT_IDENTIFIED:
        return f"({number_text(found.value, 4)})"
    return f"{number_text(found.value, 4)} ± {number_text(found.interval.half_width, 2)}"


def _figure(found: Sequence[TemperatureResult], axis: str) -> Drawing:
    from gimbal_hil.pages.plots import MEASURED, stacked

    units = {e.name: e.unit for result in found[0].results for e in result.estimates}
    titles = [name.replace("_", " ") for name in _DRAWN]
    drawn = stacked(titles, "temperature [degC]", [units.get(name, "") for name in _DRAWN], 150)
    for row, name in enumerate(_DRAWN, 1):
        values = values_at(found, axis, name)
        drawn.add_scatter(
            x=list(values),
            y=[e.value for e in values.values()],
            error_y={
                "type": "data",
                "symmetric": False,
                "array": [max(0.0, e.interval.high - e.value) for e in values.values()],
                "arrayminus": [max(0.0, e.value - e.interval.low) for e in values.values()],
                "thickness": 1,
            },
            mode="lines+markers",
            line=dict(color=MEASURED),
            showlegend=False,
            row=row,
        )
    return drawn
