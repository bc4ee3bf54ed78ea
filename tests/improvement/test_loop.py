"""The closed loop on virtual antennas whose effects it is not told."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from gimbal_hil.improvement import Ending, Improvement, Journal, Started, Task, VirtualSite, budgets_of, improve
from gimbal_hil.settings import load_settings
from sim_backend.model import shipped_model
from sim_backend.shipped import shipped_file


def configuration(folder: Path, *effects: tuple[str, str, dict[str, float]]) -> Path:
    """A configuration file whose embedded antenna has hidden effects."""
    model = shipped_model()
    for name, axis, parameters in effects:
        model = model.with_effect(name, axis, parameters)
    (folder / "hidden.yaml").write_text(model.to_yaml())
    document = yaml.safe_load(shipped_file("virtual_antenna.yaml").read_text())
    document["link"] = {"embedded": {"model": "./hidden.yaml", "seed": 5}}
    (folder / "antenna.yaml").write_text(yaml.safe_dump(document))
    return folder / "antenna.yaml"


def test_an_antenna_without_hidden_effects_ends_at_the_floor_with_the_model_unchanged(tmp_path: Path) -> None:
    done = improve(load_settings(configuration(tmp_path)), shipped_model(), tmp_path / "out", short=True, workers=1)
    assert done.ending is Ending.AT_THE_FLOOR
    assert done.model.document == shipped_model().document


COGGING = {"amplitude": 0.03, "order": 12.0, "phase": 0.7}
HIDDEN = (
    (("cogging", "outer", COGGING), ("coulomb_asymmetry", "inner", {"asymmetry": 0.15})),
    (("gyro_bias", "outer", {"bias": 0.002}), ("cogging", "inner", {"amplitude": 0.02, "order": 9.0, "phase": 0.2})),
)


@pytest.mark.heavy
@pytest.mark.parametrize("hidden", HIDDEN)
def test_two_hidden_effects_are_added_until_the_model_is_at_the_floor(
    tmp_path: Path, hidden: tuple[tuple[str, str, dict[str, float]], ...]
) -> None:
    done = improve(load_settings(configuration(tmp_path, *hidden)), shipped_model(), tmp_path / "out", short=True, workers=2)
    assert done.ending is Ending.AT_THE_FLOOR
    named = {(effect["name"], effect["axis"]) for verdict in done.verdicts for effect in verdict["effects"]}
    assert named == {(name, axis) for name, axis, _ in hidden}


def test_a_budget_that_is_too_small_is_kept_and_said(tmp_path: Path) -> None:
    done = improve(load_settings(configuration(tmp_path)), shipped_model(), tmp_path / "out", short=True, budget_s=1.0)
    assert done.ending is Ending.TIME_USED_UP
    assert not (tmp_path / "out").exists()
