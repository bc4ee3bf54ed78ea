"""A floor holds what a perfect model would leave: also where a resonance in it rings on the encoder's own error."""

from __future__ import annotations

import warnings

import numpy as np

from gimbal_hil.discrepancy.record import record_of
from gimbal_hil.discrepancy.standing import standing
from gimbal_hil.discrepancy.twin import Twin
from gimbal_hil.experiments.sequences import SequenceOptions
from gimbal_hil.experiments.sequences.survey import survey
from gimbal_hil.improvement.rehearsal import rehearse
from gimbal_hil.settings import shipped_settings
from gimbal_hil.signals import SignalsTable
from sim_backend.model import AntennaModel, shipped_model

#: just above the scored band, lightly damped
RESONANCE = {"antiresonance_frequency": 28.0, "damping_ratio": 0.03, "inertia_share": 0.4}


def surveyed(antenna: AntennaModel) -> SignalsTable:
    found = rehearse(survey(SequenceOptions(1000.0, short=True), 1), shipped_settings(), antenna, seed=11).table
    assert found is not None
    return found


def outer_torque(model: AntennaModel, table: SignalsTable) -> float:
    """What a model leaves of the outer axis' torque, in floors."""
    gap = standing(model, table)[0]
    return float(gap["before"] / gap["noise_floor"])


def test_a_model_with_the_resonance_of_its_antenna_is_at_the_floor_and_one_without_is_not() -> None:
    antenna = shipped_model().with_effect("structural_resonance", "outer", RESONANCE)
    table = surveyed(antenna)
    assert outer_torque(antenna, table) < 1.4
    assert outer_torque(shipped_model(), table) > 3.0


def test_a_candidate_that_the_twin_cannot_carry_gives_no_numbers_and_no_warnings() -> None:
    model = shipped_model()
    table = surveyed(model)
    twin = Twin(model, (record_of(table, model, 25.0, "log"),))
    structure = twin.structure(())
    broken = np.full_like(structure.P, np.nan)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert np.isnan(twin.unscaled(structure, broken, 0)).all()
