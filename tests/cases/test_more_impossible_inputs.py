"""Faults beside those of positions and torques: rates of a gyro, cells that are written otherwise, files that are none.

`check` with the model of the antenna says of a log what the commands say that use it.
"""

from __future__ import annotations

import io
import json
import tarfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.preflight import impossible_rows, questioned
from gimbal_hil.data.signals import ColumnMap, SignalsTable, read_signals
from gimbal_hil.surface.cli.app import run
from sim_backend.model import load_model
from tests.cases.joint import MODEL, Floats, swinging, table_text

LOG = swinging(seconds=8.0, seed=77)
ROWS = len(LOG.time)
SOME = np.sort(np.random.default_rng(31).choice(np.arange(300, ROWS - 300), 20, replace=False))
LATER = np.arange(ROWS) > ROWS // 2
RATE = LOG.rate + np.random.default_rng(5).normal(0.0, 1e-3, ROWS)
DEGREE = np.radians(1.0)


def with_rate(rate: Floats) -> str:
    columns = {"time_s": LOG.time, "joint.torque": LOG.torque, "joint.position": LOG.position, "joint.rate": rate}
    return table_text(columns)


def spiky() -> Floats:
    return np.where(np.isin(np.arange(ROWS), SOME), 40.0, RATE)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    found = tmp_path_factory.mktemp("cases")
    (found / "model.yaml").write_text(MODEL)
    return found


def asked(folder: Path, content: str | bytes, *words: str, **repair: object) -> SignalsTable:
    """The log as a command takes it in."""
    path, model = folder / "log.csv", load_model(folder / "model.yaml")
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    read = {"repair": repair.pop("repair", False)}
    table = read_signals(path, model, columns=ColumnMap.of_words(words), **repair)  # type: ignore[arg-type]
    return questioned(model, [table], **read)[0]  # type: ignore[arg-type]


RATES: dict[str, tuple[Callable[[], Floats], str]] = {
    "20 reads of 40 rad/s": (spiky, r"joint.rate, row \d+ at .* reads 40, .* \(20 rows in all\).*--repair"),
    "stuck to the end": (
        lambda: np.where(LATER, RATE[ROWS // 2], RATE),
        "is the same as in the rows around it, .* while the joint goes on",
    ),
    "at its rails": (lambda: np.clip(RATE, -0.6, 0.6), r"reads -?0.6 and is the same as in the rows around it"),
}


@pytest.mark.parametrize("fault", RATES)
def test_a_rate_that_no_joint_has_is_refused_with_its_rows(folder: Path, fault: str) -> None:
    rate, said = RATES[fault]
    with pytest.raises(BadInputError, match=said) as refused:
        asked(folder, with_rate(rate()))
    assert len(str(refused.value)) < 700


def test_rates_that_are_off_are_made_up_where_that_is_asked_for(folder: Path) -> None:
    table = asked(folder, with_rate(spiky()), repair=True)
    rate = table.signal("joint", "rate")
    assert rate is not None and np.max(np.abs(rate - LOG.rate)) < 0.1
    assert "20 of 4000 rows where the joint cannot have had such a rate" in " ".join(table.notes)


@pytest.mark.parametrize(
    "rate",
    [RATE, np.round(RATE / 0.1) * 0.1, RATE[np.arange(ROWS) // 5 * 5], RATE + 0.3, np.zeros(ROWS)],
    ids=["fine", "coarse", "at 100 Hz", "with a bias", "not logged"],
)
def test_a_rate_that_is_only_coarse_slow_or_biased_is_no_fault(folder: Path, rate: Floats) -> None:
    model = load_model(folder / "model.yaml")
    assert impossible_rows(model, asked(folder, with_rate(rate))) == []


def test_an_encoder_that_is_coarser_than_its_model_is_no_fault(folder: Path) -> None:
    coarse = np.round(LOG.position / DEGREE) * DEGREE
    asked(folder, LOG.but(position=coarse).text())
    with pytest.raises(BadInputError, match=r"row \d+ .* where the joint cannot have been \(20 rows in all\)"):
        asked(folder, LOG.but(position=coarse + 0.2 * np.isin(np.arange(ROWS), SOME)).text())


def brackets(value: float) -> str:
    return f"({-value:.5f})" if value < 0.0 else f"{value:.5f}"


def test_cells_that_hold_values_in_another_way_are_not_bridged_whatever_is_asked_for(folder: Path) -> None:
    text = LOG.text(forms={"joint.torque": brackets})
    for repair in ({}, {"resample": True}, {"drop_invalid": True}, {"resample": True, "drop_invalid": True}):
        with pytest.raises(BadInputError, match=r"line \d+, column joint.torque: holds '\(0.0\d+\)'") as refused:
            asked(folder, text, **repair)
        assert "--resample" not in str(refused.value)


def tar() -> bytes:
    packed = io.BytesIO()
    with tarfile.open(fileobj=packed, mode="w:gz") as archive:
        member, content = tarfile.TarInfo("log.csv"), LOG.text().encode()
        member.size = len(content)
        archive.addfile(member, io.BytesIO(content))
    return packed.getvalue()


FILES: dict[str, tuple[Callable[[], str | bytes], str]] = {
    "a row a signal": (
        lambda: "\n".join(
            ",".join([name, *(f"{value:.9g}" for value in values)])
            for name, values in {"time_s": LOG.time, "joint.torque": LOG.torque, "joint.position": LOG.position}.items()
        ),
        "and .* more",
    ),
    "tar": (tar, "is a tar archive"),
    "names in GB18030": (lambda: LOG.text().replace("time_s", "时间").encode("gb18030"), "iconv -f ENCODING"),
    "names in Shift JIS": (lambda: LOG.text().replace("time_s", "時間モ").encode("shift_jis"), "iconv -f ENCODING"),
}


@pytest.mark.parametrize("kind", FILES)
def test_a_file_that_is_no_table_of_rows_is_refused_shortly_with_what_to_do(folder: Path, kind: str) -> None:
    content, said = FILES[kind]
    with pytest.raises(BadInputError, match=said) as refused:
        asked(folder, content())
    assert len(str(refused.value)) < 900


def test_marks_that_nobody_sees_are_no_part_of_a_name(folder: Path) -> None:
    text = LOG.text().replace("joint.position", "\u200bjoint.position")
    assert len(asked(folder, ("\ufeff\ufeff" + text).encode())) == ROWS


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (
            lambda: LOG.but(position=np.where(np.isin(np.arange(ROWS), SOME), 1.9, LOG.position)).text(),
            "cannot have been",
        ),
        (lambda: LOG.but(position=np.degrees(LOG.position)).text(), "in degrees"),
        (lambda: with_rate(spiky()), "such a rate"),
    ],
    ids=["rows that are off", "another unit", "rates that are off"],
)
def test_check_with_a_model_says_what_the_commands_say(
    folder: Path, content: Callable[[], str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "log.csv").write_text(content())
    assert run("check", [str(folder / "log.csv"), str(folder / "model.yaml"), "--json"]) == 1
    log = json.loads(capsys.readouterr().out)["files"][0]
    assert not log["good"] and said in log["faults"][0]["problem"]


def test_check_of_several_logs_lets_one_of_them_coast(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "coasts.csv").write_text(LOG.but(torque=np.zeros(ROWS)).text())
    (folder / "driven.csv").write_text(LOG.text())
    files = [str(folder / name) for name in ("driven.csv", "coasts.csv", "model.yaml")]
    assert run("check", files) == 0
    assert run("check", files[1:]) == 1
    assert "never changes" in capsys.readouterr().out
