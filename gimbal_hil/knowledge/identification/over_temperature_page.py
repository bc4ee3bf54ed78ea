"""The report of friction over temperature: every number against temperature with its interval, and the table itself."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from gimbal_hil.knowledge.identification.over_temperature import TemperatureResult, gaps, uncovered, values_at
from gimbal_hil.knowledge.identification.over_temperature_text import answer, axes_of, rows_of, still_open
from gimbal_hil.knowledge.identification.stribeck import LUGRE_NAMES
from gimbal_hil.pages.report import Block, Callout, Heading, Page, Plot, Table, Text
from sim_backend.model import AntennaModel

if TYPE_CHECKING:
    from gimbal_hil.pages.plots import Drawing

#: what is drawn, from the top
_DRAWN = ("coulomb", "breakaway", "viscous", "stribeck_velocity")


def over_temperature_page(model: AntennaModel, found: Sequence[TemperatureResult], sources: Sequence[str]) -> Page:
    """Everything that the runs said, `model` being the one with the table."""
    blocks: list[Block] = [Callout(answer(found), "warning" if uncovered(found) else "good")]
    for axis in axes_of(found):
        blocks += [
            Heading(axis),
            Plot(_figure(found, axis), "Identified and weakly identified numbers with their 95 % intervals."),
            Table(
                ("Temperature [degC]", *(name.replace("_", " ") for name in LUGRE_NAMES)),
                rows_of(found, axis),
                "SI units, with half of the 95 % interval; in brackets what was not identified: the prior's is kept.",
            ),
        ]
    if unsettled := still_open(found):
        blocks += [Heading("What is open"), *(Text(f"{one}.") for one in unsettled)]
    if notes := gaps(found):
        blocks += [Heading("Where another run would help"), *(Text(note) for note in notes)]
    blocks.append(Text(f"From {', '.join(sources)}. Between rows friction is interpolated, beyond them held."))
    return Page("Friction over temperature", f"model {model.name}", blocks)


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
