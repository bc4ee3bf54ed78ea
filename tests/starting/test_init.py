"""`gimbal-hil init`: a stranger's antenna runs from the files that it writes, and nothing impossible is written."""

from __future__ import annotations

import json
import math
import shlex
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from firmware_protocol.documents import read_yaml
from gimbal_hil.data.runs import open_run
from gimbal_hil.knowledge.experiments import conduct, embedded_model_of
from gimbal_hil.knowledge.experiments.sequences import SequenceOptions, build_experiment
from gimbal_hil.loop.settings import load_settings
from gimbal_hil.surface.checking import check_files
from gimbal_hil.surface.cli import main
from gimbal_hil.surface.cli.init import AntennaOptions, _described
from gimbal_hil.surface.starting import parse_link, write_antenna
from sim_backend.model import load_model


def begin(capsys: pytest.CaptureFixture[str], folder: Path, *words: str) -> tuple[int, str, str]:
    with pytest.raises(SystemExit) as end:
        main(["init", str(folder), *words])
    said = capsys.readouterr()
    assert isinstance(end.value.code, int)
    return end.value.code, said.out, said.err


@pytest.mark.heavy
def test_without_a_single_number_the_antenna_steps_and_settles(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    code, out, _ = begin(capsys, tmp_path / "mine", "--yes", "--json")
    assert code == 0
    assert json.loads(out)["next"].startswith("gimbal-hil experiment step --config ")
    settings = load_settings(tmp_path / "mine" / "antenna.yaml")
    model, seed = embedded_model_of(settings)
    assert settings.axis_names == model.axes == ("azimuth", "elevation")
    experiment = build_experiment("step", SequenceOptions(settings.rate_hz, names=settings.axis_names))
    rows = conduct(experiment, settings, model, seed, tmp_path / "run").rows
    assert len(rows) == 8
    for row in rows:
        assert row["overshoot_percent"] < 5.0 and row["settling_s"] < 1.5, row["step"]


def test_its_plan_runs_on_its_antenna(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "mine"
    assert begin(capsys, folder, "--yes", "--axes", "pan,tilt", "--breakaway", "pan=0.4")[0] == 0
    with pytest.raises(SystemExit) as end:
        main(["experiment", str(folder / "plan.yaml"), "--config", str(folder / "antenna.yaml"),
              "--out", str(tmp_path / "run"), "--json"])  # fmt: skip
    assert end.value.code == 0
    assert [row["axis"] for row in json.loads(capsys.readouterr().out)["rows"]] == ["pan", "pan", "tilt", "tilt"]


@pytest.mark.parametrize(
    ("words", "boresight"),
    [
        ((), "x"),
        (("--travel", "elevation=0..1.57"), "-x"),
        (("--travel", "elevation=-1.57..0"), "x"),
        (("--travel", "elevation=0..1.57", "--up", "negative"), "x"),
        (("--up", "positive"), "-x"),
    ],
)
def test_an_antenna_looks_up_where_its_travel_or_the_user_says(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], words: tuple[str, ...], boresight: str
) -> None:
    assert begin(capsys, tmp_path, "--yes", *words)[0] == 0
    assert load_model(tmp_path / "model.yaml").file.boresight.value == boresight
    assert load_settings(tmp_path / "antenna.yaml").with_model().pointing.boresight == boresight


def test_an_antenna_that_only_looks_up_points_there(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "mine"
    assert begin(capsys, folder, "--yes", "--travel", "elevation=0..1.57")[0] == 0
    words = [
        "point",
        "--config",
        str(folder / "antenna.yaml"),
        "--duration",
        "3",
        "--json",
        "--out",
        str(tmp_path / "out"),
    ]
    with pytest.raises(SystemExit) as end:
        main([*words, "--target", "azel:90,30"])
    found = json.loads(capsys.readouterr().out)
    assert end.value.code == 0 and found["boresight"] == "-x" and found["reference_off_urad"] < 1.0
    highest = float(np.nanmax(open_run(tmp_path / "out").ticks["position_ref_inner"]))
    assert math.degrees(highest) == pytest.approx(30.0, abs=0.01)


def test_told_numbers_stand_in_the_model_as_told_and_the_others_as_assumed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = shlex.split(
        "--torque azimuth=40 --inertia elevation=0.3 --travel elevation=-0.3..1.6 --encoder azimuth=65536 "
        "--cog elevation=0.02 --coulomb azimuth=0.5 --rate-limit azimuth=2"
    )
    assert begin(capsys, tmp_path, "--yes", *words)[0] == 0
    model = load_model(tmp_path / "model.yaml")
    told = {
        ("azimuth", "actuator.limit"): 40.0,
        ("elevation", "body.inertia.yy"): 0.3,
        ("elevation", "body.cog.x"): 0.02,
        ("azimuth", "friction.coulomb"): 0.5,
    }
    for (axis, path), value in told.items():
        assert model.number(axis, path) == value
        assert model.numbers[axis, path].source == "stated at init"
    assert model.numbers["elevation", "actuator.limit"].source == "assumed"
    assert model.uncertainty("azimuth", "actuator.limit") == pytest.approx(0.02 * 40.0)
    assert model.uncertainty("azimuth", "body.mass") == pytest.approx(0.5 * model.number("azimuth", "body.mass"))
    assert model.number("azimuth", "encoder.step") == pytest.approx(6.283185307 / 65536)
    limits = load_settings(tmp_path / "antenna.yaml").axes
    assert (limits["elevation"].limits.position_low_rad, limits["elevation"].limits.position_high_rad) == (-0.3, 1.6)
    assert limits["azimuth"].limits.rate_rad_s == 2.0


@pytest.mark.parametrize(
    ("words", "sine"), [("rotary", 1.0), ("rotary --tilt 0", 0.0), ("linear", 0.0), ("linear --tilt -30", -0.5)]
)
def test_one_axis_alone_lies_as_it_is_said_and_a_rotary_one_level_while_nobody_says_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], words: str, sine: float
) -> None:
    assert begin(capsys, tmp_path, "--yes", "--kind", *words.split())[0] == 0
    assert load_model(tmp_path / "model.yaml").document["incline_sine"] == sine


@pytest.mark.parametrize(("kind", "has"), [("gimbal", True), ("rotary", False), ("linear", False)])
def test_only_what_moves_in_a_simulation_has_bristles_that_nobody_told_of(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], kind: str, has: bool
) -> None:
    assert begin(capsys, tmp_path, "--yes", "--kind", kind)[0] == 0
    model = load_model(tmp_path / "model.yaml")
    assert {model.number(axis, "friction.sigma0") > 0.0 for axis in model.axes} == {has}


@pytest.mark.parametrize(
    ("link", "section"),
    [
        ("unix:/tmp/a.sock", {"kind": "unix", "path": "/tmp/a.sock"}),
        ("serial:/dev/ttyUSB0", {"kind": "serial", "port": "/dev/ttyUSB0"}),
        ("socketcan:can0", {"kind": "can", "interface": "socketcan", "channel": "can0", "bitrate": 1000000}),
        ("slcan:/dev/ttyACM0", {"kind": "can", "interface": "slcan", "channel": "/dev/ttyACM0", "bitrate": 1000000}),
    ],
)
def test_an_antenna_behind_a_link_comes_with_a_rehearsal_on_the_virtual_one(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], link: str, section: dict[str, Any]
) -> None:
    assert begin(capsys, tmp_path, "--yes", "--link", link)[0] == 0
    real, rehearsal = (read_yaml(tmp_path / f"{name}.yaml", "") for name in ("antenna", "rehearsal"))
    assert real.pop("link") == section
    assert rehearsal.pop("link") == {"embedded": {"model": "model.yaml", "seed": 1}}
    waiting, rehearsed = real.pop("supervisor"), rehearsal.pop("supervisor")
    assert (rehearsed["lost_ticks"], rehearsed["deadman"]["window_ticks"]) == (5, 20)
    # a process at the other end stalls with this machine; hardware keeps its time
    simulated = link.startswith("unix")
    assert (waiting["lost_ticks"], waiting["deadman"]["window_ticks"]) == ((100, 250) if simulated else (5, 20))
    assert ("without feedback" in (tmp_path / "README.md").read_text()) == simulated
    assert real == rehearsal
    assert "## Then, on the link" in (tmp_path / "README.md").read_text()


@pytest.mark.parametrize("kind", ["gimbal", "rotary", "linear"])
def test_every_file_is_good_and_every_command_of_its_page_is_understood(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], kind: str
) -> None:
    assert begin(capsys, tmp_path / "mine", "--yes", "--kind", kind)[0] == 0
    files = sorted((tmp_path / "mine").glob("*.yaml"))
    assert all(not one.faults for one in check_files(files))
    assert all(path.read_text().startswith("# yaml-language-server: $schema=.schemas/") for path in files)
    page = (tmp_path / "mine" / "README.md").read_text()
    commands = [shlex.split(line) for line in page.splitlines() if line.startswith("gimbal-hil ")]
    assert len(commands) >= 3
    for words in commands:
        options = {word for word in words if word.startswith("--")}
        with pytest.raises(SystemExit) as end:
            main([words[1], "--help"])
        assert end.value.code == 0
        explained = capsys.readouterr().out
        assert not {option for option in options if option not in explained}


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--kind", "tripod"), "--kind: no kind 'tripod'; expected gimbal, rotary, linear"),
        (("--axes", "azimuth"), "--axes: 'azimuth'; expected 2 names"),
        (("--axes", "base,tilt"), "cannot be the name of an axis"),
        (("--torque", "roll=3"), "--torque: no axis 'roll'"),
        (("--torque", "azimuth=-3"), "--torque azimuth: '-3' is not a number that fits"),
        (("--travel", "elevation=0.3..1"), "does not hold zero"),
        (
            ("--kind", "linear", "--axes", "x", "--inertia", "x=3"),
            "--inertia: is nothing that a linear axis has; expected --mass x=KG",
        ),
        (("--up", "left"), "--up: is 'left'; expected positive or negative"),
        (("--tilt", "90"), "--tilt: is nothing that a gimbal has; expected base: of its model file"),
        (("--link", "can0"), "--link: 'can0' is no link"),
        (("--link", "firewire:1"), "no link 'firewire'"),
        (("--rate", "20000", "--link", "socketcan:can0"), "rate_hz"),
    ],
)
def test_what_is_impossible_is_refused_before_anything_is_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], words: tuple[str, ...], said: str
) -> None:
    code, _, err = begin(capsys, tmp_path / "mine", "--yes", *words)
    assert code == 2 and said in err and len(err.splitlines()) == 1
    assert not (tmp_path / "mine").exists()


def test_nothing_is_overwritten_without_force(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "plan.yaml").write_text("mine\n")
    code, _, err = begin(capsys, tmp_path, "--yes")
    assert code == 2 and "plan.yaml: already exists" in err
    assert [path.name for path in tmp_path.iterdir()] == ["plan.yaml"]
    assert begin(capsys, tmp_path, "--yes", "--force")[0] == 0
    assert (tmp_path / "plan.yaml").read_text() != "mine\n"


def test_without_a_terminal_and_without_yes_nobody_is_asked(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, _, err = begin(capsys, tmp_path / "mine")
    assert code == 2 and "--yes" in err


def test_answers_to_the_questions_count_as_told_and_a_return_as_assumed(tmp_path: Path) -> None:
    asked = []

    def answer(question: str, usual: str) -> str:
        asked.append(question)
        return {"link": "unix:a.sock", "elevation: largest torque, N m": "9"}.get(question, usual)

    antenna = _described(tmp_path, AntennaOptions(axes="azimuth,elevation"), answer)
    assert asked[:2] == ["kind (gimbal, rotary, linear)", "link"] and len(asked) == 2 + 2 * 6
    assert antenna.link.word == "unix" and antenna.axes[1].torque_nm == 9.0
    assert antenna.axes[1].told == {"torque_nm"} and antenna.axes[0].told == frozenset()


def test_a_link_in_the_description_is_the_section_of_the_configuration(tmp_path: Path) -> None:
    told = AntennaOptions("gimbal", link="serial:/dev/x", rate=500.0, gyro=False)
    antenna = _described(tmp_path, told, lambda _, usual: usual)
    assert antenna.link == parse_link("serial:/dev/x") and antenna.rate_hz == 500.0
    files = write_antenna(antenna, tmp_path / "mine", False)
    assert files[-1].name == "README.md"
    limits = load_settings(tmp_path / "mine" / "antenna.yaml").axes["azimuth"].limits
    assert limits.gyro_encoder_rad is None and limits.stuck_gyro_ticks is None


def test_an_air_bearing_has_no_friction(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, _, err = begin(capsys, tmp_path / "mine", "--yes", "--coulomb", "azimuth=0", "--viscous", "azimuth=0")
    assert code == 0, err
    model = load_model(tmp_path / "mine" / "model.yaml")
    friction = [model.number("azimuth", f"friction.{name}") for name in ("coulomb", "breakaway", "viscous", "sigma0")]
    assert friction == [0.0] * 4
    assert model.number("elevation", "friction.coulomb") > 0.0
    code, _, err = begin(capsys, tmp_path / "other", "--yes", "--mass", "azimuth=0")
    assert code == 2 and "a positive number" in err
