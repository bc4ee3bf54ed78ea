"""Files of somebody else: names, units, signs and separators of their columns."""

from __future__ import annotations

import math
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.signals import ColumnMap, SignalsTable, read_signals, write_signals
from sim_backend.model import model_named
from tests.signals.bench import bench_log

WORDS = ["time_s=t [ms]:ms", "joint.position=theta [deg]:deg", "joint.torque=M [mNm]:mNm"]
HEADER = "t [ms];theta [deg];M [mNm];U [V]"


def stranger(path: Path, decimal: str = ",", between: str = ";", rows: int = 40) -> Path:
    """A table in milliseconds, degrees and mN m, and the supply that nobody asks for."""
    lines = [HEADER.replace(";", between)]
    for k in range(rows):
        cells = (f"{2.0 * k:.1f}", f"{0.1 * math.sin(0.3 * k):.8f}", f"{150.0 * math.cos(0.3 * k):.6f}", "24")
        lines.append(between.join(cells).replace(".", decimal))
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize(("decimal", "between"), [(".", ","), (",", ";"), (".", ";"), (",", "\t"), (".", "\t")])
def test_a_strangers_table_is_read_in_si_units(tmp_path: Path, decimal: str, between: str) -> None:
    path = stranger(tmp_path / "bench.csv", decimal, between)
    table = read_signals(path, ("joint",), columns=ColumnMap.of_words(WORDS))
    assert table.period_s == pytest.approx(2e-3, rel=1e-12)
    assert np.allclose(table.position("joint"), np.radians(0.1 * np.sin(0.3 * np.arange(40))), atol=1e-8)
    assert np.allclose(table.torque("joint"), 0.15 * np.cos(0.3 * np.arange(40)), atol=1e-7)
    assert any("'U [V]'" in note for note in table.notes)


@pytest.mark.parametrize(
    ("unit", "factor"),
    [
        ("", math.pi / 180.0),
        ("1*rad", 1.0),
        ("-deg", -math.pi / 180.0),
        # mirrored, in what the file says
        ("-", -math.pi / 180.0),
        ("°", math.pi / 180.0),
        ("turn/8192", math.tau / 8192.0),
        ("1*rev", math.tau),
        ("0.5*mrad", 0.5e-3),
        ("-2e1 arcsec", -20.0 * math.pi / 648_000.0),
        ("0.25", 0.25),
    ],
)
def test_a_unit_may_have_a_sign_and_a_factor(tmp_path: Path, unit: str, factor: float) -> None:
    path = stranger(tmp_path / "bench.csv")
    words = [WORDS[0], f"joint.position=theta [deg]:{unit}".rstrip(":"), WORDS[2]]
    position = read_signals(path, ("joint",), columns=ColumnMap.of_words(words)).position("joint")
    assert np.allclose(position, factor * 0.1 * np.sin(0.3 * np.arange(40)), rtol=1e-7, atol=1e-7)


@pytest.mark.parametrize(("unit", "at_300"), [("K", 26.85), ("degF", 148.888889), ("degC", 300.0)])
def test_temperatures_have_zeros_of_their_own(tmp_path: Path, unit: str, at_300: float) -> None:
    path = tmp_path / "warm.csv"
    path.write_text("time_s,j.position,j.torque,T\n" + "".join(f"{k * 0.01:.2f},0,0,300\n" for k in range(12)))
    table = read_signals(path, ("j",), columns=ColumnMap({"j.temperature": f"T:{unit}"}))
    assert table.columns["j.temperature"][0] == pytest.approx(at_300)


def test_units_are_those_of_the_models_kind(tmp_path: Path) -> None:
    model = model_named("emps")
    (axis,) = model.axes
    path = tmp_path / "slide.csv"
    path.write_text("t,x,F\n" + "".join(f"{k * 0.001:.3f},{k},2\n" for k in range(12)))
    words = ["time_s=t", f"{axis}.position=x:mm", f"{axis}.torque=F:kN"]
    table = read_signals(path, model, columns=ColumnMap.of_words(words))
    assert table.position(axis)[3] == pytest.approx(3e-3) and table.torque(axis)[0] == 2000.0
    with pytest.raises(BadInputError, match=r"'deg' is no unit for .*\.position; expected m, cm, mm"):
        read_signals(path, model, columns=ColumnMap.of_words([words[0], f"{axis}.position=x:deg", words[2]]))


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["time_s"], "--column time_s: is no pair; expected NAME=COLUMN"),
        ([WORDS[0], WORDS[0]], "is the second column for time_s"),
        (
            [WORDS[0], "joint.position=theta:deg", WORDS[2]],
            "has no column 'theta' for joint.position; expected 'theta [",
        ),
        (
            [WORDS[0], "joint.pos=theta [deg]:deg", WORDS[2]],
            "no column 'joint.pos'; expected 'joint.position', perhaps",
        ),
        ([WORDS[0], "joint.position=theta [deg]:rpm", WORDS[2]], "'rpm' is no unit for joint.position; expected rad,"),
        ([WORDS[0], "joint.position=theta [deg]:deg/0", WORDS[2]], "'deg/0' is no unit"),
        (WORDS[:2], "has no column 'joint.torque'; expected"),
    ],
)
def test_a_mistake_is_told_with_what_was_expected(tmp_path: Path, words: list[str], said: str) -> None:
    path = stranger(tmp_path / "bench.csv")
    with pytest.raises(BadInputError, match=re.escape(said)):
        read_signals(path, ("joint",), columns=ColumnMap.of_words(words))


def test_a_missing_column_is_told_with_the_option_and_the_files_own_names(tmp_path: Path) -> None:
    with pytest.raises(BadInputError, match=r"--column time_s=COLUMN:UNIT .*\(t \[ms\], theta \[deg\], M \[mNm\], U"):
        read_signals(stranger(tmp_path / "bench.csv"), ("joint",))


def test_a_bad_cell_is_told_by_the_name_that_the_file_has(tmp_path: Path) -> None:
    path = stranger(tmp_path / "bench.csv")
    lines = path.read_text(encoding="utf-8").splitlines()
    lines[7] = lines[7].replace(lines[7].split(";")[1], "broken")
    path.write_text("\n".join(lines), encoding="utf-8")
    with pytest.raises(BadInputError, match=r"line 8, column theta \[deg\]: holds 'broken'"):
        read_signals(path, ("joint",), columns=ColumnMap.of_words(WORDS))


def test_a_file_with_the_tables_own_names_needs_no_columns(tmp_path: Path) -> None:
    table = read_signals(stranger(tmp_path / "bench.csv"), ("joint",), columns=ColumnMap.of_words(WORDS))
    own = tmp_path / "own.csv"
    write_signals(SignalsTable.of(table.axes, table.time_s, table.columns), own)
    again = read_signals(own, ("joint",), columns=ColumnMap.of_words(WORDS))
    assert again.position("joint").tobytes() == table.position("joint").tobytes()


def command(*words: str, folder: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [str(Path(sys.executable).with_name("gimbal-hil")), *words],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.heavy
def test_a_strangers_files_lead_to_a_named_effect(tmp_path: Path) -> None:
    """The commands of docs/how-to/name-an-effect-in-your-csv.md."""
    bench_log(tmp_path / "a.csv", ((1.2, 0.11), (0.5, 0.37)))
    bench_log(tmp_path / "b.csv", ((1.0, 0.17), (0.7, 0.29)))
    numbers = ["inertia=0.02", "coulomb=0.04", "viscous=0.02", "torque=3", "encoder=65536"]
    options = [word for one in numbers for word in (f"--{one.split('=')[0]}", f"joint={one.split('=')[1]}")]
    made = command("init", "mine", "--yes", "--kind", "rotary", "--axes", "joint", *options, folder=tmp_path)
    assert made.returncode == 0, made.stderr
    logs = ["--measured", "a.csv", "--holdout", "b.csv", "--column", *WORDS]
    found = command("discrepancy", "--model", "mine/model.yaml", *logs, "--out", "found", folder=tmp_path)
    assert found.returncode == 0, found.stderr
    amplitude = re.search(r"cogging on joint \(named\): amplitude (\S+) N m, order (\S+)", found.stdout)
    assert amplitude is not None, found.stdout
    assert float(amplitude[1]) == pytest.approx(0.01, rel=0.05) and float(amplitude[2]) == pytest.approx(7.0, rel=0.01)
    # read as radians the same file is refused, not judged
    wrong = ["--column", WORDS[0], WORDS[1].removesuffix(":deg") + ":1*rad", WORDS[2]]
    refused = command("discrepancy", "--model", "mine/model.yaml", *logs[:4], *wrong, "--out", "no", folder=tmp_path)
    assert refused.returncode == 2 and "seems to be in degrees" in refused.stderr
