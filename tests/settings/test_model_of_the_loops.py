"""A model file of the loops is read once: neither a change of gains nor a replay sees what it says later."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from firmware_protocol.documents import yaml_text
from firmware_protocol.errors import BadInputError
from gimbal_hil.data.runs import open_run
from gimbal_hil.loop.settings import DaemonSettings, adjusted, host_configuration, load_settings, settings_from_document
from gimbal_hil.pointing.arena import controller_settings
from gimbal_hil.realtime.lockstep import host_of
from gimbal_hil.surface.testing.antennas import LockstepAntennaOfTest
from sim_backend.model import shipped_model


def document(model: Path, names: dict[str, str]) -> dict[str, Any]:
    found = controller_settings("all").model_dump(mode="json", by_alias=True)
    found["model_control"]["model"] = str(model)
    found["axes"] = {names[name]: axis for name, axis in found["axes"].items()}
    found["axes"][names["inner"]]["parent"] = names["outer"]
    return found


def written(folder: Path, **names: str) -> tuple[DaemonSettings, Path]:
    """Settings whose axes have these names, and their model file, whose axes are outer and inner."""
    model, file = folder / "own.yaml", folder / "antenna.yaml"
    model.write_text(shipped_model("realistic").to_yaml())
    file.write_text(yaml_text(document(Path(model.name), {"outer": "outer", "inner": "inner"} | names)))
    return load_settings(file).with_model(), model


def test_adjusting_a_gain_changes_that_gain_alone_whatever_the_model_file_says_by_then(tmp_path: Path) -> None:
    settings, model = written(tmp_path)
    gain = {"outer": {"rate_loop.kp_s_per_rad": 0.9 * settings.axes["outer"].rate_loop.kp_s_per_rad}}
    before, expected = host_configuration(settings), host_configuration(adjusted(settings, gain))
    assert np.any(before != expected)
    model.write_text(shipped_model("realistic").with_number("outer", "friction.coulomb", 0.1).to_yaml())
    np.testing.assert_array_equal(host_configuration(adjusted(settings, gain)), expected)


def test_a_run_keeps_the_model_of_its_loops(tmp_path: Path) -> None:
    settings, model = written(tmp_path)
    kept = json.loads(json.dumps(settings.model_dump(mode="json", by_alias=True)))
    model.unlink()
    np.testing.assert_array_equal(host_configuration(settings_from_document(kept, "run")), host_configuration(settings))


def test_whatever_records_keeps_it(tmp_path: Path) -> None:
    settings, model = written(tmp_path)
    settings = load_settings(model.with_name("antenna.yaml"))
    assert settings.model_control is not None and settings.model_control.document is None
    LockstepAntennaOfTest(settings, tmp_path / "run").close()
    expected = host_configuration(settings)
    model.unlink()
    np.testing.assert_array_equal(host_of(open_run(tmp_path / "run")).memory.C, expected)


def test_a_run_that_keeps_only_the_path_is_read_as_before(tmp_path: Path) -> None:
    settings, _ = written(tmp_path)
    kept = settings.model_dump(mode="json", by_alias=True)
    del kept["model_control"]["document"]
    np.testing.assert_array_equal(host_configuration(settings_from_document(kept, "run")), host_configuration(settings))


def test_a_model_of_another_antenna_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BadInputError, match="has the axes outer and inner") as refused:
        written(tmp_path, outer="azimuth", inner="elevation")
    assert refused.value.where == "model_control.model"
