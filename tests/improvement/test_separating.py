"""Every entry of the separating menu is a sequence that the antenna can do within its limits, and that shows what it
was made for.
"""

from __future__ import annotations

import pytest

from gimbal_hil.knowledge.discrepancy.verdict.separating import separating_run, separating_runs, showing_sequences
from gimbal_hil.knowledge.experiments.sequences import SequenceOptions, breakaway_torques, build_experiment
from gimbal_hil.knowledge.experiments.sequences.registry import SEQUENCES
from gimbal_hil.knowledge.improvement import budgets_of
from gimbal_hil.knowledge.improvement.rehearsal import rehearse
from gimbal_hil.loop.settings import shipped_settings
from sim_backend.effects import CATALOGUE
from sim_backend.model import shipped_model

MENU = showing_sequences(*CATALOGUE)


def test_the_menu_names_sequences_that_there_are() -> None:
    assert set(MENU) <= set(SEQUENCES)
    assert len(MENU) >= 8


@pytest.mark.parametrize("axis", ["outer", "inner"])
@pytest.mark.parametrize("name", MENU)
def test_a_separating_sequence_stays_within_the_limits_of_the_antenna(name: str, axis: str) -> None:
    settings = shipped_settings()
    experiment = build_experiment(
        name, SequenceOptions(1000.0, (axis,), short=True, every=1, breakaway_nm=breakaway_torques(shipped_model()))
    )
    rehearsal = rehearse(experiment, settings, shipped_model())
    assert budgets_of(settings, 1000.0, 1, {}, {}).refusal(experiment, rehearsal, 1000.0, 0.0) is None
    low, high = rehearsal.travel_rad[axis]
    assert high - low > 1e-3


@pytest.mark.parametrize(
    ("pair", "sequence"),
    [
        (("viscous", "quadratic_drag"), "plateaus"),
        (("static_unbalance", "cable_spring"), "full_turn"),
        (("cogging", "encoder_eccentricity"), "full_turn"),
        (("transport_delay", "structural_resonance"), "sweep"),
        (("stribeck", "presliding"), "creep"),
        (("backlash", "presliding"), "reversals"),
        (("temperature_viscosity", "viscous"), "warm_and_cool"),
        (("torque_gain", "load_dependent_friction"), "two_loads"),
        (("dynamic_unbalance", "gyro_misalignment"), "one_locked"),
    ],
)
def test_each_line_of_the_table_has_its_sequence_and_says_the_command(pair: tuple[str, str], sequence: str) -> None:
    assert sequence in [run.sequence for run in separating_runs(*pair)]
    assert f"gimbal-hil experiment {sequence}" in separating_run(*pair, {})


@pytest.mark.parametrize("pair", [("viscous", "back_emf"), ("torque_gain", "inertia")])
def test_what_needs_a_person_is_said_as_such(pair: tuple[str, str]) -> None:
    assert any(run.sequence is None for run in separating_runs(*pair))
