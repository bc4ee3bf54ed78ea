"""The travel that the page on experiments announces is the travel that the sequences ask for."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from gimbal_hil.knowledge.experiments.sequences import SEQUENCES, SequenceOptions, build_experiment
from gimbal_hil.loop.host import AxisCommand, Mode, Shape

PAGE = Path(__file__).resolve().parents[2] / "docs" / "reference" / "experiments.md"
#: those that command torque or rates: their bounds stand in words below the table
NOT_BY_POSITION = ("presliding", "sweep")


def asked(command: AxisCommand) -> list[float]:
    """Positions (rad) that a command leads to."""
    if command.mode is not Mode.POSITION:
        return []
    if command.shape is Shape.TABLE:
        return [float(value) for value in np.asarray(command.table) * command.parameters[1]]
    if command.shape is Shape.RAMP:
        start, slope, span = command.parameters[:3]
        return [start, start + float(np.sign(slope)) * span]
    return [float(command.parameters[0])] if command.parameters else []


@pytest.mark.skipif(not PAGE.exists(), reason="needs the source checkout")
@pytest.mark.parametrize("name", [name for name in SEQUENCES if name not in NOT_BY_POSITION])
def test_the_page_announces_the_travel_of_a_sequence(name: str) -> None:
    bounds = []
    for place in range(2):
        reached = [
            position
            for short in (False, True)
            for step in build_experiment(name, SequenceOptions(1000.0, short=short)).steps
            for position in asked((step.segment.outer, step.segment.inner)[place])
        ]
        bounds.append(f"{min(0.0, *reached):.2f} to {max(0.0, *reached):.2f}")
    assert f"| `{name}` | {bounds[0]} | {bounds[1]} |" in PAGE.read_text(encoding="utf-8")
