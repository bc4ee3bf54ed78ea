"""A floor holds what a perfect model would leave: also where a resonance in it rings on the encoder's own error."""

from __future__ import annotations

import warnings

import numpy as np

from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.discrepancy.inquiry.standing import standing
from gimbal_hil.knowledge.discrepancy.noise.floors import Floor, over_own_noise, smaller, spectral_floor, wide_twin
from gimbal_hil.knowledge.discrepancy.twin.record import record_of
from gimbal_hil.knowledge.discrepancy.twin.smoothing import Floats
from gimbal_hil.knowledge.discrepancy.twin.twin import Twin
from gimbal_hil.knowledge.experiments.sequences import SequenceOptions
from gimbal_hil.knowledge.experiments.sequences.survey import survey_motion
from gimbal_hil.knowledge.improvement.rehearsal import rehearse
from gimbal_hil.loop.settings import shipped_settings
from sim_backend.model import AntennaModel, model_from_document, shipped_model

#: just above the scored band, lightly damped
RESONANCE = {"antiresonance_frequency": 28.0, "damping_ratio": 0.03, "inertia_share": 0.4}


def surveyed(antenna: AntennaModel) -> SignalsTable:
    found = rehearse(survey_motion(SequenceOptions(1000.0, short=True), 1), shipped_settings(), antenna, seed=11).table
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


def test_the_smaller_floor_keeps_where_it_comes_from() -> None:
    from_laps, from_spectrum = Floor(1.6, 1.6, 2.0), Floor(1.5, None, 1.5)
    assert smaller([from_laps], [from_spectrum]) == smaller([from_spectrum], [from_laps]) == [from_spectrum]


def test_a_candidate_that_the_twin_cannot_carry_gives_no_numbers_and_no_warnings() -> None:
    model = shipped_model()
    table = surveyed(model)
    twin = Twin(model, (record_of(table, model, 25.0, "log"),))
    structure = twin.structure(())
    broken = np.full_like(structure.P, np.nan)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert np.isnan(twin.unscaled(structure, broken, 0)).all()


def test_white_noise_under_much_more_encoder_noise_is_not_read_too_low() -> None:
    # at 500 Hz the encoder's noise of a heavy turret is ten times the torque's where the floor is read from
    step, t = 2.0 * np.pi / 2**22, np.arange(20000) * 2e-3
    friction = {
        "coulomb": 14.0,
        "breakaway": 17.5,
        "stribeck_velocity": 0.012,
        "sigma0": 24000.0,
        "sigma1": 420.0,
        "viscous": 22.0,
    }
    axis = {"body": {"mass": 400.0, "inertia": {"zz": 30.0}}, "friction": friction, "encoder": {"step": step}}
    model = model_from_document({"schema": 1, "name": "turret", "kind": "rotary", "axes": {"azimuth": axis}}, "turret")
    position = 0.3 * np.sin(1.7 * t) + 0.1 * np.sin(5.3 * t)

    def logged(position: Floats, torque: Floats) -> tuple[Twin, SignalsTable]:
        table = SignalsTable.of(model.axes, t, {"azimuth.position": position, "azimuth.torque": torque})
        return Twin(model, (record_of(table, model, 25.0, "log"),)), table

    exact, _ = logged(position, np.zeros(len(t)))
    structure = exact.structure(())
    needed = np.append(-exact.leftover(structure, structure.P, 0)[:, 0], 0.0)
    twin, table = logged(np.round(position / step) * step, needed + np.random.default_rng(1).normal(0.0, 0.3, len(t)))
    inside = float(np.sqrt(np.mean(twin.scored(structure, structure.P, 0) ** 2)))
    floor = spectral_floor(wide_twin(twin, (table,)), structure, structure.P, twin.channels[0], twin.records[0].bands)
    assert 0.85 < floor / inside < 1.2


def test_noise_whose_level_changes_is_its_own_measure_and_a_ripple_under_it_is_not() -> None:
    model, t = shipped_model(), np.arange(24000) * 1e-3
    motion = {f"{axis}.position": 0.3 * np.sin(1.7 * t) + 0.1 * np.sin(5.3 * t) for axis in model.axes}

    def logged(torque: dict[str, Floats]) -> tuple[Twin, SignalsTable]:
        table = SignalsTable.of(model.axes, t, motion | torque)
        return Twin(model, (record_of(table, model, 25.0, "log"),)), table

    exact, _ = logged({f"{axis}.torque": np.zeros(len(t)) for axis in model.axes})
    structure = exact.structure(())
    needed = exact.leftover(structure, structure.P, 0)
    noise = np.random.default_rng(5).normal(0.0, np.where(t < 14.0, 0.01, 0.05), (2, len(t)))

    def over(ripple: float) -> tuple[float, float]:
        torque = {
            f"{axis}.torque": np.append(-needed[:, i], 0.0) + noise[i] + ripple * np.sin(20.0 * t)
            for i, axis in enumerate(model.axes)
        }
        twin, table = logged(torque)
        wide = wide_twin(twin, (table,))
        floor = np.array(
            [spectral_floor(wide, structure, structure.P, c, twin.records[0].bands) for c in twin.channels]
        )
        gap = np.sqrt(np.mean(twin.scored(structure, structure.P, 0) ** 2, axis=0)) / floor
        return float(gap.max()), over_own_noise(twin, (table,), structure, structure.P, floor)

    gap, own = over(0.0)
    assert gap > 1.5 and own < 1.3
    assert over(0.03)[1] > 2.0
