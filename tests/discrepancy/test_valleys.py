"""A gap and its rotor trade against each other along a bent, bumpy valley: its bottom is found, and no gap is told
larger than need be.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from gimbal_hil.discrepancy.families import Family, families
from gimbal_hil.discrepancy.hypothesis import Cause, Hypothesis
from gimbal_hil.discrepancy.record import record_of
from gimbal_hil.discrepancy.search import Scored, Search
from gimbal_hil.discrepancy.valleys import further, polished
from gimbal_hil.signals import SignalsTable
from sim_backend.model import shipped_model


@pytest.fixture(scope="module")
def backlash() -> Family:
    model, t = shipped_model(), np.arange(4000) * 1e-3
    columns = {f"{axis}.{signal}": np.sin(3.0 * t) for axis in model.axes for signal in ("torque", "position")}
    record = record_of(SignalsTable.of(model.axes, t, columns), model, 25.0, "log")
    return next(family for family in families(model, "inner", (record,)) if family.effect == "backlash")


@dataclass
class Landscape:
    """Stands for a search: a refit finds the valley (the rotor that goes with a gap), and only that."""

    depth: Callable[[float], float]

    def refitted(self, hypothesis: Hypothesis, rounds: int = 6, enough: float = 1e-4) -> Scored:
        gap, _, *others = hypothesis.causes[0].x
        cause = replace(hypothesis.causes[0], x=(gap, self.rotor(gap), *others))
        found = SimpleNamespace(hypothesis=replace(hypothesis, causes=(cause,)), cost=self.depth(gap))
        return cast(Scored, found)

    @staticmethod
    def rotor(gap: float) -> float:
        return -2.0 - gap + 0.3 * gap**2


def start(search: Landscape, family: Family, gap: float) -> Scored:
    return search.refitted(Hypothesis((Cause(family, (gap, 0.0, 0.0, 0.0, 0.0)),)))


def gap_of(state: Scored) -> float:
    return state.hypothesis.causes[0].x[0]


@pytest.mark.parametrize("at", [-0.9, 0.0, 0.8])
def test_the_bottom_is_found_from_either_side_and_over_bumps(backlash: Family, at: float) -> None:
    search = Landscape(lambda gap: 10.0 + 100.0 * (gap - at) ** 2 + 1.5 * np.cos(40.0 * gap))
    best = polished(cast(Search, search), start(search, backlash, 0.0))
    assert gap_of(best) == pytest.approx(at, abs=0.15)
    assert best.hypothesis.causes[0].x[1] == pytest.approx(search.rotor(gap_of(best)))


def test_of_gaps_that_do_as_well_the_smallest_is_told(backlash: Family) -> None:
    # a gap that is never crossed has no size: all from a small one on leave the same
    search = Landscape(lambda gap: 10.0 if gap > -1.0 else 50.0)
    best = polished(cast(Search, search), start(search, backlash, 2.0))
    assert np.exp(gap_of(best)) == pytest.approx(0.5)


def test_a_step_along_the_valley_goes_both_ways(backlash: Family) -> None:
    search = Landscape(lambda gap: gap**2)
    here = start(search, backlash, 0.4)
    assert gap_of(further(cast(Search, search), here, 0, 2.0)) == pytest.approx(0.7)
    assert gap_of(further(cast(Search, search), here, 0, -2.0)) == pytest.approx(0.1)


def test_causes_without_a_valley_are_left_where_they_are(backlash: Family) -> None:
    search = Landscape(lambda gap: (gap - 1.0) ** 2)
    flat = replace(backlash, valley=())
    assert gap_of(polished(cast(Search, search), start(search, flat, 0.0))) == 0.0
