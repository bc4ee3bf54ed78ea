"""The virtual antenna as an FMU says, frame by frame, what it says in Python."""

from __future__ import annotations

import platform
import re
import shutil
import struct
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

fmpy = pytest.importorskip("fmpy", reason="needs FMPy (pip install gimbal-hil[test])")

from fmpy.validation import validate_fmu  # noqa: E402

from firmware_protocol.errors import BadInputError  # noqa: E402
from sim_backend.device import Device  # noqa: E402
from sim_backend.fmu import fmu_of  # noqa: E402
from sim_backend.model import AntennaModel, load_model, shipped_model, shipped_model_path  # noqa: E402
from tests.fmu.importer import FmuAntenna, compared, operations, running  # noqa: E402

ROOT = Path(__file__).resolve().parents[2]
pytestmark = pytest.mark.skipif(
    platform.system() != "Linux" or not (shutil.which("cc") or shutil.which("gcc")), reason="needs Linux and gcc"
)


def rich() -> AntennaModel:
    """An antenna with effects of every hook on a base that moves."""
    swaying = {
        "motion": "sinusoid",
        "amplitude_rad": {"roll": 0.1, "pitch": 0.2, "yaw": 3.0},
        "frequency_hz": {"roll": 1.0, "pitch": 0.7, "yaw": 0.5},
    }
    model = shipped_model().with_base(swaying)
    model = model.with_effect("cogging", "outer", {"amplitude": 0.05, "order": 12.0, "phase": 0.3})
    model = model.with_effect("transport_delay", "inner", {"delay": 0.0023})
    model = model.with_effect("encoder_eccentricity", "outer", {"amplitude": 1e-3, "phase": 0.1})
    return model.with_effect("load_dependent_friction", "inner", {"coefficient": 0.05})


@pytest.fixture(autouse=True)
def back_here(monkeypatch: pytest.MonkeyPatch) -> None:
    """FMPy stays in the folder of a library that does not load; no other test must begin there."""
    monkeypatch.chdir(".")


@pytest.fixture(scope="module")
def archive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("fmu") / "antenna.fmu"
    path.write_bytes(fmu_of(shipped_model()))
    return path


@pytest.mark.parametrize("name", ["thesis", "realistic", "emps"])
def test_fmpy_finds_no_problem(name: str, tmp_path: Path) -> None:
    path = tmp_path / "antenna.fmu"
    path.write_bytes(fmu_of(load_model(shipped_model_path().with_name(f"{name}.yaml"))))
    assert validate_fmu(str(path)) == []


def test_an_archive_is_small_and_the_same_every_time(archive: Path) -> None:
    assert archive.stat().st_size < 2_000_000
    assert fmu_of(shipped_model()) == archive.read_bytes()


def test_an_fmu_needs_no_library_but_the_systems(archive: Path, tmp_path: Path) -> None:
    with zipfile.ZipFile(archive) as opened:
        (library,) = (name for name in opened.namelist() if name.endswith(".so"))
        code = opened.read(library)
    assert b"libpython" not in code and b"libllvm" not in code.lower() and b"NRT_" not in code


@pytest.mark.parametrize("model", [shipped_model(), rich()], ids=["thesis", "rich"])
def test_frames_are_those_of_the_antenna_in_python(model: AntennaModel) -> None:
    both = compared(model, 3000, seed=7)
    assert both.ticks == 3000 and both.frames > 9000


@pytest.mark.heavy
def test_frames_are_equal_for_a_million_ticks() -> None:
    assert compared(rich(), 1_000_000).ticks == 1_000_000


def test_fmpy_simulates_it_without_knowing_of_the_bus(archive: Path) -> None:
    rows = fmpy.simulate_fmu(
        str(archive), stop_time=1.0, output_interval=0.05, output=["outer.position", "drive.state"]
    )
    device = Device(shipped_model())
    for _ in range(1000):
        device.tick()
    assert rows["outer.position"][-1] == device.joint_positions[0]
    assert rows["drive.state"][-1] == device.state


@given(blocks=st.lists(st.binary(max_size=200), max_size=6))
@settings(max_examples=60, deadline=None)
def test_no_bytes_on_the_bus_stop_the_antenna(blocks: list[bytes]) -> None:
    antenna = shared()
    for block in blocks:
        antenna.put(block)
        antenna.fmu.updateDiscreteStates()
        antenna.fmu.enterStepMode()
        antenna.fmu.doStep(antenna.ticks * antenna.step_s, antenna.step_s)
        antenna.ticks += 1
        antenna.fmu.enterEventMode()


_SHARED: list[FmuAntenna] = []


def shared() -> FmuAntenna:
    """One antenna for all examples: making one takes longer than they do."""
    if not _SHARED:
        _SHARED.append(running(shipped_model()).__enter__())
    return _SHARED[0]


def test_an_operation_that_is_none_is_answered_with_a_format_error() -> None:
    with running(shipped_model()) as antenna:
        antenna.put(b"\x10\x00\x00\x00\xff\x00\x00\x00abc")
        antenna.fmu.updateDiscreteStates()
        antenna.fmu.enterStepMode()
        antenna.fmu.doStep(0.0, antenna.step_s)
        code, length, size = struct.unpack_from("<IIH", antenna.sent())
        assert (code, length, size) == (1, 10 + 11, 11)


def test_frames_that_are_not_for_the_antenna_pass_by() -> None:
    extended = struct.pack("<IIIBBH", 0x10, 24, 0x12345, 1, 0, 8) + bytes(8)
    confirm, short = struct.pack("<III", 0x20, 12, 0x101), struct.pack("<IIIBBH", 0x10, 18, 0x101, 0, 0, 2) + b"ab"
    with running(shipped_model()) as antenna:
        antenna.put(extended + confirm + short)
        assert antenna.tick() == Device(shipped_model()).tick()
        assert antenna.fmu.getInt64([antenna.references["drive.bad_frames"]]) == [0]


def test_a_damaged_frame_is_counted_as_in_python() -> None:
    with running(shipped_model()) as antenna:
        device, damaged = Device(shipped_model()), (0x101).to_bytes(2, "little") + bytes(8)
        device.tick(damaged)
        antenna.put(operations(damaged))
        antenna.tick()
        assert antenna.fmu.getInt64([antenna.references["drive.bad_frames"]]) == [device.bad_frames]


def test_a_state_that_was_kept_goes_on_as_before() -> None:
    with running(shipped_model(), seed=3) as antenna:
        for _ in range(50):
            antenna.tick()
        kept = antenna.fmu.serializeFMUState(antenna.fmu.getFMUState())
        first = [antenna.tick() for _ in range(20)]
        antenna.fmu.setFMUState(antenna.fmu.deserializeFMUState(kept))
        antenna.ticks -= 20
        assert [antenna.tick() for _ in range(20)] == first


def test_another_seed_is_other_noise() -> None:
    with running(shipped_model(), seed=1) as one, running(shipped_model(), seed=2) as other:
        assert [one.tick() for _ in range(9)] != [other.tick() for _ in range(9)]


def test_the_how_to_page_runs(tmp_path: Path) -> None:
    page = (ROOT / "docs" / "how-to" / "use-as-an-fmu.md").read_text()
    script = "\n".join(re.findall(r"^```python\n(.*?)^```$", page, re.MULTILINE | re.DOTALL))
    (tmp_path / "antenna.fmu").write_bytes(fmu_of(load_model(shipped_model_path().with_name("realistic.yaml"))))
    (tmp_path / "firmware_protocol").symlink_to(ROOT / "firmware_protocol")
    done = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    assert "'state': 'SWITCH_ON_DISABLED'" in done.stdout and "1 bad frame" in done.stdout


def test_without_a_compiler_it_is_refused_before_anything_is_translated(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("GIMBAL_HIL_CACHE", str(tmp_path / "cache"))
    monkeypatch.setenv("CC", "/nowhere/cc")
    with pytest.raises(BadInputError, match="CC=/nowhere/cc is none"):
        fmu_of(shipped_model())
    assert not list((tmp_path / "cache").rglob("*.o"))
