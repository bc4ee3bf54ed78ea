"""`check` says what it sees in somebody else's table, and prints the `--column` that reads it."""

from __future__ import annotations

import shlex
from pathlib import Path

import numpy as np
import pytest

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.containers import contents_of
from gimbal_hil.data.signals import ColumnMap, read_signals
from gimbal_hil.surface.checking import FileKind, check_files
from gimbal_hil.surface.cli.app import run
from tests.cases.joint import BENCH, MODEL, table_text
from tests.tables.joint import Q, T, U, lines


@pytest.mark.parametrize("ending", [".csv", ".tsv", ".txt", ".log", ".t", ".dat"])
def test_the_words_that_check_prints_read_the_table(tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"run{ending}"
    rows = [f"{1e3 * t:.1f}\t{np.degrees(q):.6f}\t{1e3 * u:.4f}\t24.0" for t, q, u in zip(T, Q, U, strict=True)]
    path.write_text("\n".join(["time_ms\tangle [deg]\ttorque_mNm\tsupply [V]", *rows]) + "\n")
    (seen,) = check_files([path], ("joint",))
    assert seen.kind is FileKind.SIGNALS and not seen.faults and not seen.is_strange
    for said in ("500 Hz", "angle [deg]: ", "to read it: --column time_s=time_ms:ms"):
        assert said in seen.text
    table = read_signals(path, ("joint",), columns=ColumnMap.of_words(seen.reads_as))
    assert np.allclose(table.position("joint"), Q, atol=1e-6) and np.allclose(table.torque("joint"), U, atol=1e-6)


def test_a_table_without_a_header_is_listed_by_number_and_no_command_is_proposed_where_nothing_moves_so(
    tmp_path: Path,
) -> None:
    path = tmp_path / "foc.txt"
    path.write_text("\n".join(f"{k}\t{np.sin(0.1 * k):.4f}\t{np.cos(0.3 * k):.4f}" for k in range(400)) + "\n")
    (seen,) = check_files([path], ("joint",))
    assert seen.is_strange and not seen.reads_as
    assert "its columns are called 1 to 3" in seen.text and "--rate HZ" in seen.text
    assert "column 1 rises evenly, as a time does; if so: --column time_s=1:UNIT AXIS.position" in seen.text


def test_a_table_without_a_header_is_read_by_how_its_columns_move_in_units_that_fit_the_model(tmp_path: Path) -> None:
    path, model = tmp_path / "numbers.csv", tmp_path / "model.yaml"
    model.write_text(MODEL)
    log = BENCH.log("a", 8.0)
    columns = {"q": np.degrees(log.position), "t": 1e3 * log.time, "u": log.torque, "v": log.rate}
    path.write_text(table_text(columns).partition("\n")[2])
    seen = check_files([path, model])[0]
    assert not seen.is_strange and seen.reads_as == ("time_s=2:ms", "joint.position=1:deg", "joint.torque=3")
    assert check_files([path], ("joint",))[0].reads_as[1] == "joint.position=1" and "is to be said" not in seen.text


def test_a_log_without_times_is_checked_at_the_rate_that_is_stated_and_the_next_command_has_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    log = BENCH.log("a", 8.0)
    monkeypatch.chdir(tmp_path)
    Path("model.yaml").write_text(MODEL)
    Path("log.csv").write_text(table_text({"q": log.position, "u": log.torque}))
    words = ["log.csv", "model.yaml", "--column", "joint.position=q", "joint.torque=u"]
    assert run("check", words) == 1
    assert "--rate HZ" in capsys.readouterr().out
    assert run("check", [*words, "--rate", "500"]) == 0
    told = capsys.readouterr().out
    assert "500 a second, as --rate says" in told and shlex.split(told)[-2:] == ["--rate", "500"]


def test_a_table_with_the_names_of_a_signals_table_is_checked_as_one(tmp_path: Path) -> None:
    path = tmp_path / "own.csv"
    path.write_text("\n".join(lines()[:300] + lines()[200:]) + "\n")
    (seen,) = check_files([path], ("joint",))
    assert [str(fault) for fault in seen.faults if "line 301" in str(fault) and "not later" in str(fault)]


def test_a_folder_of_ros_2_that_is_called_as_a_bag_of_ros_1_is_refused_with_what_to_do(tmp_path: Path) -> None:
    pytest.importorskip("rosbags", reason="the extra bags has it")
    folder = tmp_path / "run.bag"
    folder.mkdir()
    (folder / "metadata.yaml").write_text("rosbag2_bagfile_information: {}\n")
    with pytest.raises(BadInputError, match=r"mv run\.bag run_bag"):
        contents_of(folder)


def test_a_current_without_a_torque_constant_is_told_with_what_to_add(tmp_path: Path) -> None:
    (tmp_path / "model.yaml").write_text(MODEL.replace(", torque_constant: 1.8", ""))
    rows = [f"{t:.4f},{q / 6.283185307:.7f},{u / 0.062:.6f}" for t, q, u in zip(T, Q, U, strict=True)]
    path = tmp_path / "a.csv"
    path.write_text("\n".join(["timestamp,axis0.pos_estimate,axis0.Iq_setpoint", *rows]) + "\n")
    seen = check_files([path, tmp_path / "model.yaml"], ("joint",))[0]
    assert seen.reads_as[2] == "joint.torque=axis0.Iq_setpoint:KT*N m" and "N m of one ampere for KT" in seen.text
    with pytest.raises(BadInputError, match=r"KT is to be filled in; expected .* as 0\.062\*N m: 8\.27 / KV"):
        read_signals(path, ("joint",), columns=ColumnMap.of_words(seen.reads_as))
