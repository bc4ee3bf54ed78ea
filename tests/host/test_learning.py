"""What the loops learn beside their model, in lockstep: what it is worth, frozen, kept in a run, begun with again."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from firmware_protocol.errors import BadInputError
from gimbal_hil.loop.settings import DaemonSettings, load_settings, shipped_settings_path, with_changes
from gimbal_hil.pointing.arena import Trial, TrialOutcome, controller_settings, load_scenarios, run_trial
from gimbal_hil.surface.cli import app
from sim_backend.model import shipped_model

SCENARIOS = Path(__file__).parents[2] / "config" / "scenarios" / "learning.yaml"


def swings(settings: DaemonSettings, wrong: float = 0.0, times_as_viscous: float = 1.0) -> TrialOutcome:
    """Four swings, judged from the third on."""
    scenario = load_scenarios(SCENARIOS)[0].model_copy(update={"duration_s": 80.0, "settle_s": 40.0})
    antenna = shipped_model("realistic")
    for axis in antenna.axes:
        viscous = times_as_viscous * antenna.number(axis, "friction.viscous")
        antenna = antenna.with_numbers(axis, {"friction.viscous": viscous})
    return run_trial(Trial(scenario, "it", settings, "realistic", antenna, 1, wrong=wrong))


@pytest.mark.heavy
def test_a_table_learns_the_cogging_that_the_model_does_not_name() -> None:
    blind = with_changes(controller_settings("tuned"), {"model_control.position_torque": False})
    learns = with_changes(blind, {"axes.outer.learned": {}, "axes.inner.learned": {}})
    assert swings(learns).los_rms < 0.6 * swings(blind).los_rms
    named = swings(controller_settings("tuned")).los_rms
    assert named < 0.2 * swings(blind).los_rms
    # where the model is right there is nothing to learn, and next to nothing is lost by it
    assert swings(controller_settings("learned")).los_rms < 1.2 * named


@pytest.mark.heavy
def test_levels_take_a_friction_that_is_off_out_of_the_reversals() -> None:
    off, followed = (swings(controller_settings(name), 0.3) for name in ("tuned", "levels"))
    assert followed.los_rms < off.los_rms
    assert max(followed.reversal_peak) < 0.8 * max(off.reversal_peak)


def test_levels_cost_nothing_where_a_cold_joint_is_six_times_as_viscous() -> None:
    plain, followed = (swings(controller_settings(name), times_as_viscous=6.05) for name in ("tuned", "levels"))
    # viscosity that was taken for sliding friction would be wrong at every reversal
    assert followed.los_rms < 1.1 * plain.los_rms


def document_with(**learned: Any) -> dict[str, Any]:
    """The shipped configuration with a model and tables."""
    found: dict[str, Any] = yaml.safe_load(shipped_settings_path().read_text(encoding="utf-8"))
    found["model_control"] = {"model": "realistic", "position_torque": False}
    for axis in found["axes"].values():
        axis["observer"], axis["learned"] = {"bandwidth_rad_s": 150.0}, learned
    return found


def run_of(folder: Path, name: str, **learned: Any) -> Path:
    config = folder / f"{name}.yaml"
    config.write_text(yaml.safe_dump(document_with(**learned)), encoding="utf-8")
    run = folder / name
    words = ["reversals", "--lockstep", "--short", "--config", str(config), "--out", str(run)]
    assert app.run("experiment", words) == 0
    return run


def test_a_run_keeps_what_was_learned_and_another_one_begins_with_it_frozen(tmp_path: Path) -> None:
    table = tmp_path / "learned.yaml"
    assert app.run("replay", [str(run_of(tmp_path, "first")), "--learned", str(table)]) == 0
    learned = yaml.safe_load(table.read_text(encoding="utf-8"))["axes"]
    assert len(learned["outer"]) > 20
    with pytest.raises(SystemExit) as refused:
        app.run("replay", [str(tmp_path / "first"), "--learned", str(table)])
    assert refused.value.code == 2
    frozen, again = run_of(tmp_path, "second", share=0.0, table="learned.yaml"), tmp_path / "again.yaml"
    # a run holds the table itself: it replays without the file
    table.unlink()
    assert app.run("replay", [str(frozen), "--learned", str(again)]) == 0
    kept = yaml.safe_load(again.read_text(encoding="utf-8"))["axes"]
    for axis, rows in learned.items():
        np.testing.assert_allclose(kept[axis], rows, rtol=1e-5)


def test_tables_and_levels_are_refused_where_they_have_nothing_to_add_to(tmp_path: Path) -> None:
    for changes, told in (
        ({"model_control": None, "axes.outer.observer": None, "axes.inner.observer": None}, "need model_control"),
        ({"model_control": {"model": "realistic", "friction": False}, "axes.outer.friction_levels": {}}, "is off"),
        ({"axes.outer.learned": {"slowest_rad_s": 0.5}}, "not below"),
        ({"axes.outer.learned": {"entries": [[720, 0.0, 0.0]]}}, "719|720"),
    ):
        with pytest.raises(BadInputError, match=told):
            with_changes(controller_settings("learned"), changes)
    table, config = tmp_path / "t.yaml", tmp_path / "c.yaml"
    table.write_text("schema: 1\naxes: {azimuth: []}\n", encoding="utf-8")
    config.write_text(yaml.safe_dump(document_with(table="t.yaml")), encoding="utf-8")
    with pytest.raises(BadInputError, match="azimuth"):
        load_settings(config).with_model()
