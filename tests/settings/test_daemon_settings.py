"""The daemon's configuration file: the shipped one, what is refused in which words, and what it becomes."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml

from firmware_protocol.errors import BadInputError
from gimbal_hil.loop.control.layout import PREFILTER_DECAY, TORQUE_LIMIT
from gimbal_hil.loop.host import layout
from gimbal_hil.loop.settings import (
    EmbeddedAntenna,
    host_configuration,
    load_settings,
    settings_from_document,
    shipped_settings,
    shipped_settings_path,
)

Change = Callable[[dict[str, Any]], object]
CAN = {"kind": "can", "interface": "virtual", "channel": "a"}


def document() -> dict[str, Any]:
    """The shipped file as a mapping."""
    return copy.deepcopy(yaml.safe_load(shipped_settings_path().read_text()))


def test_the_shipped_configuration_is_the_virtual_antenna_at_1_khz() -> None:
    settings = shipped_settings()
    assert settings.rate_hz == 1000.0
    assert isinstance(settings.link, EmbeddedAntenna) and settings.link.embedded.model == "thesis"


def test_a_configuration_survives_json() -> None:
    settings = shipped_settings()
    again = settings_from_document(settings.model_dump(mode="json", by_alias=True), "run.yaml")
    assert again == settings
    assert host_configuration(again).tobytes() == host_configuration(settings).tobytes()


@pytest.mark.parametrize(
    ("change", "key", "says"),
    [
        (lambda d: d.update(rate=1000), "rate", "rate_hz?"),
        (lambda d: d.update(rate_hz="fast"), "rate_hz", "valid number"),
        (lambda d: d.update(rate_hz=0), "rate_hz", "greater than or equal to 10"),
        (lambda d: d.update(link=CAN | {"bitrate": 250_000}), "rate_hz", "at most"),
        (lambda d: d.update(link={"kind": "carrier pigeon"}), "link", "no link that there is"),
        (lambda d: d.update(link={"embedded": {"modle": "thesis"}}), "link.embedded.modle", "model?"),
        (lambda d: d.update(link={"kind": "can", "interface": "virtual", "chanel": "a"}), "link.chanel", "channel?"),
        (lambda d: d["axes"].pop("inner"), "axes", "1 axes, not two"),
        (
            lambda d: d["axes"]["outer"]["limits"].update(rate_rad_s=-1.0),
            "axes.outer.limits.rate_rad_s",
            "greater than 0",
        ),
        (
            lambda d: d["axes"]["inner"]["limits"].update(position_low_rad=3.0),
            "axes.inner.limits",
            "not below position_high_rad",
        ),
        (
            lambda d: d["axes"]["inner"]["limits"].update(position_low_rad=math.nan),
            "axes.inner.limits.position_low_rad",
            "finite",
        ),
        (
            lambda d: d["axes"]["outer"]["rate_loop"].update(anti_windup="yes"),
            "axes.outer.rate_loop.anti_windup",
            "'none'",
        ),
        (lambda d: d["axes"]["outer"]["prefilter"].update(den=[1.0]), "axes.outer.prefilter.den", "is missing"),
        (lambda d: d["supervisor"]["deadman"].update(window_ticks=300), "supervisor.deadman.window_ticks", "255"),
    ],
)
def test_a_wrong_key_or_value_is_named_in_one_line(change: Change, key: str, says: str) -> None:
    changed = document()
    change(changed)
    with pytest.raises(BadInputError) as refused:
        settings_from_document(changed, "antenna.yaml")
    assert refused.value.where.startswith(f"antenna.yaml: {key}")
    assert says in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("text", "says"), [("a: [1,\nb: 2", "is not YAML at line"), ("- 1", "holds no mapping"), ("", "holds no mapping")]
)
def test_a_file_that_is_no_configuration_is_refused(tmp_path: Path, text: str, says: str) -> None:
    path = tmp_path / "daemon.yaml"
    path.write_text(text)
    with pytest.raises(BadInputError, match=says):
        load_settings(path)


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BadInputError, match="no such file"):
        load_settings(tmp_path / "none.yaml")


def test_a_models_path_counts_from_the_configuration_file(tmp_path: Path) -> None:
    changed = document()
    changed["link"] = {"embedded": {"model": "models/mine.yaml"}}
    (tmp_path / "daemon.yaml").write_text(yaml.safe_dump(changed))
    link = load_settings(tmp_path / "daemon.yaml").link
    assert isinstance(link, EmbeddedAntenna) and Path(link.embedded.model) == tmp_path / "models" / "mine.yaml"


def test_torque_limits_become_whole_steps_of_the_wire() -> None:
    changed = document()
    changed["axes"]["outer"]["limits"]["torque_nm"] = 1.00019
    C = host_configuration(settings_from_document(changed, "test"))
    assert C[layout.axis_c(0) + TORQUE_LIMIT] == pytest.approx(1.000125, abs=1e-12)


def test_the_prefilter_of_table_5_11_becomes_its_discrete_form() -> None:
    changed = document()
    changed["axes"]["outer"]["prefilter"] = {"num": 4.72, "den": [1.3, 4.72]}
    C = host_configuration(settings_from_document(changed, "test"))
    assert C[layout.axis_c(0) + PREFILTER_DECAY] == pytest.approx(math.exp(-4.72 / 1.3 * 1e-3))
