"""Loops with a model in lockstep: same bits on both paths, every part alone, and what it is for."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from gimbal_hil.loop.host import AxisCommand, Mode, Segment, Shape, program_of
from gimbal_hil.pointing.arena import Trial, chosen, controller_settings, run_trial, shipped_scenarios
from gimbal_hil.realtime.lockstep import CompiledPath, FramePath
from sim_backend.model import AntennaModel, shipped_model

PARTS = ("bodies", "friction", "position", "base", "observer", "all", "levels", "learned")


def moving_base() -> AntennaModel:
    swing = {"roll": 0.01, "pitch": 0.02, "yaw": 0.03}
    base = {"motion": "sinusoid", "amplitude_rad": swing, "frequency_hz": {"roll": 0.7, "pitch": 0.4, "yaw": 1.0}}
    return shipped_model("realistic").with_base({**base, "ins_age_s": 0.005})


PROGRAM = program_of(
    [
        Segment(
            AxisCommand(Mode.POSITION, Shape.HOLD, (0.4,)), AxisCommand(Mode.RATE, Shape.HOLD, (0.1,)), 1200, label=0
        ),
        Segment(
            AxisCommand(Mode.INERTIAL_RATE, Shape.HOLD, (0.05,)),
            AxisCommand(Mode.POSITION, Shape.SINE, (0.0, 0.2, 0.5, 0.0)),
            1200,
            label=1,
        ),
        Segment(AxisCommand(Mode.TORQUE, Shape.HOLD, (0.3,)), AxisCommand(Mode.OFF), 300, label=2),
        Segment(
            AxisCommand(Mode.POSITION, Shape.HOLD, (0.1,)),
            AxisCommand(Mode.POSITION, Shape.HOLD, (0.0,)),
            800,
            label=3,
            switch_off_afterwards=True,
        ),
    ]
)


@pytest.mark.parametrize("part", PARTS)
def test_compiled_path_and_frame_path_leave_the_same_bits(part: str) -> None:
    logs = []
    for path in (CompiledPath, FramePath):
        engine = path(controller_settings(part), moving_base(), 3)
        engine.connect()
        logs.append(engine.run(PROGRAM).log)
    assert len(logs[0]) > 3000
    np.testing.assert_array_equal(logs[0], logs[1])


def outcome(words: str, controller: str, antenna: str = "realistic") -> tuple[np.ndarray, np.ndarray]:
    """Rms of both axes and peaks after reversals, rad."""
    scenario = chosen(shipped_scenarios(), words)[0]
    found = run_trial(
        Trial(scenario, controller, controller_settings(controller), antenna, shipped_model(antenna), seed=1)
    )
    assert not found.tripped
    return np.array(found.rms), np.array(found.reversal_peak)


@pytest.mark.parametrize("words", ["table 3.1, case 5", "table 3.2, case 4"])
def test_all_parts_hold_both_axes_to_five_microradians_on_the_thesis_bases(words: str) -> None:
    assert np.all(outcome(words, "all")[0] < 5e-6)


def test_friction_fed_forward_takes_reversals_to_a_tenth() -> None:
    scenario = "0.02 rad at 0.2 Hz"
    assert np.all(outcome(scenario, "friction")[1] < 0.15 * outcome(scenario, "shipped")[1])
    assert np.all(outcome(scenario, "all")[1] < 0.1 * outcome(scenario, "shipped")[1])


def test_an_extrapolated_base_halves_the_error_on_one_that_swings_and_all_parts_take_nineteen_twentieths() -> None:
    scenario = "5 deg/s at 1 Hz"
    shipped = outcome(scenario, "shipped")[0]
    assert np.all(outcome(scenario, "base")[0] < 0.5 * shipped)
    assert np.all(outcome(scenario, "all")[0] < 0.05 * shipped)


def test_with_every_number_of_the_model_a_third_off_the_loops_still_hold(tmp_path: Path) -> None:
    from gimbal_hil.loop.settings import settings_from_document

    model = shipped_model("realistic")
    for axis in model.axes:
        wrong = [f"body.inertia.{entry}" for entry in ("xx", "yy", "zz", "xy", "xz", "yz")] + ["body.mass"]
        wrong += [f"friction.{key}" for key in ("coulomb", "breakaway", "viscous", "sigma0", "sigma1")]
        model = model.with_numbers(axis, {path: 0.7 * model.number(axis, path) for path in wrong})
    file = tmp_path / "wrong.yaml"
    file.write_text(model.to_yaml())
    document = controller_settings("all").model_dump(mode="json", by_alias=True)
    document["model_control"]["model"] = str(file)
    scenario = chosen(shipped_scenarios(), "5 deg/s at 1 Hz")[0]
    settings = settings_from_document(document, "wrong")
    found = run_trial(Trial(scenario, "wrong", settings, "realistic", shipped_model("realistic"), 1))
    assert not found.tripped
    assert np.all(np.array(found.rms) < outcome("5 deg/s at 1 Hz", "shipped")[0])
