"""A model that is wrong: what it feeds forward fades out and comes back, loops that shake leave the observer."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from gimbal_hil.loop.host import AxisCommand, EventCode, Mode, Segment, Shape, program_of
from gimbal_hil.loop.settings import DaemonSettings, host_configuration
from gimbal_hil.pointing.arena import Trial, chosen, controller_settings, run_trial, shipped_scenarios, wrong_model
from gimbal_hil.pointing.arena.base_motions import Turbulence
from gimbal_hil.pointing.arena.trial import program_for
from gimbal_hil.realtime.lockstep import CompiledPath, FramePath
from sim_backend.model import AntennaModel, shipped_model

Change = Callable[[AntennaModel, str], AntennaModel]


def heavier(model: AntennaModel, axis: str) -> AntennaModel:
    paths = [f"body.inertia.{key}" for key in ("xx", "yy", "zz", "xy", "xz", "yz")]
    return model.with_numbers(axis, {path: 4.0 * model.number(axis, path) for path in paths})


def turned_round(model: AntennaModel, axis: str) -> AntennaModel:
    paths = [f"body.cog.{key}" for key in "xyz"]
    return model.with_numbers(axis, {path: -model.number(axis, path) for path in paths})


def with_model(change: Change, tmp_path: Path, watch: bool = True, controller: str = "tuned") -> DaemonSettings:
    """A controller of the arena, its numbers from a model that is changed on both axes."""
    model, settings = shipped_model("realistic"), controller_settings(controller)
    for axis in model.axes:
        model = change(model, axis)
    file = tmp_path / "changed.yaml"
    file.write_text(model.to_yaml())
    assert settings.model_control is not None
    update = {"model": str(file), "watch": watch}
    return settings.model_copy(update={"model_control": settings.model_control.model_copy(update=update)})


SWING = program_of(
    [
        Segment(
            AxisCommand(Mode.POSITION, Shape.SINE, (0.0, 0.2, 0.3, 0.0)),
            AxisCommand(Mode.POSITION, Shape.SINE, (0.0, 0.2, 0.3, 0.7)),
            6000,
        )
    ]
)


@pytest.mark.parametrize(
    ("change", "news"),
    [
        pytest.param(heavier, "shakes", id="inertia", marks=pytest.mark.heavy),
        pytest.param(turned_round, "stale", id="unbalance", marks=pytest.mark.heavy),
    ],
)
def test_both_paths_find_the_same_at_the_same_tick_bit_for_bit(change: Change, news: str, tmp_path: Path) -> None:
    logs, found = [], []
    settings = with_model(change, tmp_path)
    tilted = shipped_model("realistic").with_base({"motion": "fixed", "attitude_rad": {"roll": 0.5, "pitch": 0.3}})
    for path in (CompiledPath, FramePath):
        engine = path(settings, tilted, 3)
        engine.connect()
        recorded = engine.run(SWING)
        logs.append(recorded.log)
        found.append([(one.tick, one.data) for one in recorded.events if one.code is EventCode.MODEL])
    np.testing.assert_array_equal(logs[0], logs[1])
    assert found[0] == found[1] and news in {data["news"] for _, data in found[0]}


def test_a_model_that_becomes_right_again_comes_back(tmp_path: Path) -> None:
    settings = with_model(turned_round, tmp_path)
    right = controller_settings("tuned")
    assert settings.model_control is not None and right.model_control is not None
    tilted = shipped_model("realistic").with_base({"motion": "fixed", "attitude_rad": {"roll": 0.5, "pitch": 0.3}})
    engine = FramePath(settings, tilted, 3)
    engine.connect()
    events = [*engine.run(SWING).events]
    engine.host.memory.C[:] = host_configuration(right)
    events += engine.run(SWING).events
    news = [(one.data["axis"], one.data["news"]) for one in events if one.code is EventCode.MODEL]
    for axis in ("outer", "inner"):
        assert [what for who, what in news if who == axis] == ["stale", "right"]


@pytest.mark.parametrize("controller", ["all", "tuned"])
def test_the_first_torques_of_a_motion_are_no_shaking(controller: str) -> None:
    # from rest, its weight not yet held, into a sine: the torque is at its limit for the first thirty ticks
    tilted = shipped_model("realistic").with_base({"motion": "fixed", "attitude_rad": {"roll": 0.5, "pitch": 0.3}})
    engine = CompiledPath(controller_settings(controller), tilted, 3)
    engine.connect()
    assert not [one for one in engine.run(SWING).events if one.code is EventCode.MODEL]


@pytest.mark.parametrize("seed", [1, 2, 9])
def test_a_reference_that_jumps_with_each_attitude_near_the_zenith_is_no_shaking(seed: int, tmp_path: Path) -> None:
    scenario = chosen(shipped_scenarios(), "near the zenith")[0].model_copy(update={"duration_s": 4.0})
    settings, base = controller_settings("tuned"), scenario.base
    trial = Trial(scenario, "tuned", settings, "realistic", shipped_model("realistic"), seed)
    assert isinstance(base, Turbulence)
    base.write(tmp_path / "base.csv", scenario.lead_s + scenario.duration_s + 1.0, seed)
    motion = {"motion": "recorded", "file": str(tmp_path / "base.csv"), "ins_age_s": 0.005}
    engine = CompiledPath(settings, trial.model.with_base(motion), seed)
    engine.connect()
    events = engine.run(program_for(trial)).events
    assert "shakes" not in {one.data["news"] for one in events if one.code is EventCode.MODEL}


def rms(settings: DaemonSettings, words: str, wrong: float = 0.0, seed: int = 1) -> float:
    scenario = chosen(shipped_scenarios(), words)[0].model_copy(update={"duration_s": 8.0})
    model = shipped_model("realistic")
    found = run_trial(Trial(scenario, "x", settings, "realistic", model, seed, wrong=wrong))
    assert not found.tripped
    return found.los_rms


def test_loops_that_swing_on_a_wrong_inertia_are_caught(tmp_path: Path) -> None:
    # those of `tuned` do not swing on four times the inertia
    caught = rms(with_model(heavier, tmp_path, controller="all"), "case 5")
    assert caught < 0.01 * rms(with_model(heavier, tmp_path, False, "all"), "case 5")


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("words", ["case 5", "turn with a pull-up", "0.02 rad at 0.2 Hz"])
def test_with_every_number_a_third_off_it_is_better_than_the_plain_cascade(words: str, seed: int) -> None:
    assert rms(controller_settings("tuned"), words, 0.3, seed) < rms(controller_settings("cascade"), words, 0.0, seed)


def test_wrong_numbers_are_off_by_the_share_asked_for() -> None:
    model = shipped_model("realistic")
    for seed, factor in ((1, 1.3), (2, 0.7)):
        wrong = wrong_model(model, 0.3, seed)
        for key, quantity in model.numbers.items():
            if quantity.source != "default":
                assert wrong.numbers[key].value == pytest.approx(factor * quantity.value)
        assert wrong.effects[0].value("delay") == pytest.approx(factor * 0.002)
    drawn = wrong_model(model, 0.3, 5)
    ratios = {
        round(drawn.number(*key) / model.number(*key), 6) for key in (("outer", "body.mass"), ("inner", "body.mass"))
    }
    assert ratios <= {0.7, 1.3} and drawn.document != wrong_model(model, 0.3, 6).document
