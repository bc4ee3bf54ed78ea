"""An adapter link in a configuration: what follows from it, and which guards may not be pretended."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from firmware_protocol.documents import yaml_text
from firmware_protocol.errors import BadInputError
from firmware_protocol.links import AdapterLinkConfig
from gimbal_hil.loop.settings import load_settings
from gimbal_hil.surface.cli import main
from gimbal_hil.surface.cli.app import run
from tests.adapters.rig import link_section, settings_and_model
from tests.adapters.test_mapped import DBC, MAP


def without_rate(mapping: dict[str, Any]) -> dict[str, Any]:
    """The same map of a drive that tells its position alone."""
    return mapping | {"feedback": {"position": mapping["feedback"]["position"]}}


def test_rate_and_watchdog_follow_from_the_configuration_unless_stated() -> None:
    link = settings_and_model(link_section("moteus"))[0].link
    assert isinstance(link, AdapterLinkConfig)
    assert (link.rate_hz, link.watchdog_s) == (1000.0, pytest.approx(0.02))
    stated = settings_and_model(link_section("moteus") | {"watchdog_s": 0.1})[0].link
    assert isinstance(stated, AdapterLinkConfig) and stated.watchdog_s == 0.1


def test_a_guard_that_needs_two_numbers_is_refused_where_a_drive_tells_one(tmp_path: Path) -> None:
    for name, text in (("servo.dbc", DBC), ("map.yaml", yaml_text(without_rate(MAP)))):
        (tmp_path / name).write_text(text)
    link = link_section("dbc", map=str(tmp_path / "map.yaml"))
    document = settings_and_model(link)[0].model_dump(mode="json", by_alias=True, exclude_none=True)
    document["axes"]["tilt"]["limits"]["gyro_encoder_rad"] = 0.03
    with pytest.raises(BadInputError, match=r"axes.tilt.limits.gyro_encoder_rad: drive dbc tells no rate"):
        settings_and_model(link, axes=document["axes"])


@pytest.mark.parametrize("drive", ["moteus", "odrive", "cia402"])
def test_the_guards_that_hold_a_drives_rate_against_its_position_are_on(drive: str) -> None:
    limits = settings_and_model(link_section(drive))[0].axes["tilt"].limits
    assert limits.gyro_encoder_rad and limits.gyro_encoder_rad_s and limits.stuck_gyro_ticks


def test_a_torque_limit_beyond_the_drive_is_refused() -> None:
    link = link_section("moteus")
    link["drives"][1]["torque_nm"] = 2.0
    with pytest.raises(BadInputError, match=r"axes.tilt.limits.torque_nm: 6 N m; expected at most 2 N m"):
        settings_and_model(link)


@pytest.mark.parametrize("drive", ["moteus", "odrive", "cia402"])
def test_init_writes_a_configuration_for_it_that_is_good(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], drive: str
) -> None:
    with pytest.raises(SystemExit) as end:
        main(["init", str(tmp_path / "mine"), "--yes", "--link", f"{drive}:can0", "--torque", "azimuth=9"])
    assert end.value.code == 0, capsys.readouterr().err
    link = load_settings(tmp_path / "mine" / "antenna.yaml").link
    assert isinstance(link, AdapterLinkConfig)
    assert (link.drive, link.interface, link.channel) == (drive, "socketcan", "can0")
    assert [(one.id, one.torque_nm) for one in link.drives] == [(1, 9.0), (2, 6.0)]
    assert (link.data_bitrate is not None) == (drive == "moteus")


def test_a_map_is_looked_for_beside_the_configuration(tmp_path: Path) -> None:
    from firmware_protocol.documents import yaml_text

    link = link_section("dbc", map="nowhere.yaml")
    document = settings_and_model(link_section("moteus"))[0].model_dump(mode="json", by_alias=True, exclude_none=True)
    file = tmp_path / "antenna.yaml"
    file.write_text(yaml_text(document | {"link": link}))
    with pytest.raises(BadInputError) as refused:
        load_settings(file)
    assert refused.value.where == f"{file}: link.drives: map: {tmp_path / 'nowhere.yaml'}"


@pytest.mark.parametrize(
    ("right", "wrong", "said"),
    [
        ("drive: moteus", "drive: motus", "link.drive: no drive 'motus'; expected moteus, odrive"),
        ("model: model.yaml", "model: modl.yaml", "modl.yaml"),
        ("interface: socketcan", "interface: sockatcan", "antenna.yaml: link.interface: no interface 'sockatcan'"),
    ],
)
def test_check_names_the_file_of_what_is_wrong_beside_the_keys(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], right: str, wrong: str, said: str
) -> None:
    folder = tmp_path / "mine"
    assert run("init", [str(folder), "--yes", "--link", "moteus:can0"]) == 0
    file = folder / "antenna.yaml"
    assert run("check", [str(file)]) == 0
    assert " Hz, two moteus drives, axes azimuth and elevation" in capsys.readouterr().out
    file.write_text(file.read_text().replace(right, wrong))
    assert run("check", [str(file)]) == 1
    found = next(line for line in capsys.readouterr().out.splitlines() if line.startswith("wrong"))
    assert str(folder) in found and said in found
