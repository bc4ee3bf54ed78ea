"""A refusal names the line and the column of the file, and prints the option that reads the log as it was meant."""

from __future__ import annotations

import shlex
from pathlib import Path

import numpy as np
import pytest

from firmware_protocol.errors import BadInputError
from tests.cases.asking import asked
from tests.cases.joint import BENCH, COUNTS, table_text

LOG = BENCH.log()
ROWS = len(LOG.time)
RAW = np.round(LOG.torque / 1.8 / 2.69e-3).astype(np.int64)
SOME = np.sort(np.random.default_rng(3).choice(np.arange(300, ROWS - 300), 40, replace=False))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "model.yaml").write_text(BENCH.model_text())
    return tmp_path


def counter(per_turn: int, low: int, wrap: int) -> tuple[str, tuple[str, ...]]:
    counts = np.round(LOG.position * per_turn / (2.0 * np.pi)).astype(np.int64)
    columns = {"t": LOG.time, "tau": LOG.torque, "enc": (counts - low) % wrap + low}
    words = ("time_s=t", "joint.torque=tau", f"joint.position=enc:turn/{per_turn}")
    return table_text(columns, forms={"t": ".3f", "enc": "d"}), words


def current(counts: np.ndarray) -> tuple[str, tuple[str, ...]]:
    columns = {"t": LOG.time, "q": LOG.position, "i": counts}
    words = ("time_s=t", "joint.position=q", "joint.current=i:2.69*mA")
    return table_text(columns, forms={"t": ".3f", "i": "d"}), words


MEANT = {
    "signed 16 bits behind a gear": (*counter(204800, -32768, 65536), "joint.position=enc%65536:turn/204800"),
    "12 bits of the motor": (*counter(20480, 0, 4096), "joint.position=enc%4096:turn/20480"),
    "a thousand": (*counter(20480, 0, 1000), "joint.position=enc%1000:turn/20480"),
    "32 bits below zero": (*counter(20480, 0, 2**32), "joint.position=enc%4294967296:turn/20480"),
    "a current without its sign": (*current(RAW % 65536), "joint.current=i%65536:2.69*mA"),
    "some currents without it": (
        *current(np.where(np.arange(ROWS) % 97 == 0, RAW % 4096, RAW)),
        "joint.current=i%4096:2.69*mA",
    ),
    "degrees": (LOG.but(position=np.degrees(LOG.position)).text(), (), "joint.position=joint.position:deg"),
    "a torque of the other sign": (LOG.but(torque=-LOG.torque).text(), (), "joint.position=joint.position:-rad"),
    "milliseconds": (LOG.but(time=1e3 * LOG.time).text(forms={"time_s": ".0f"}), (), "time_s=time_s:ms"),
}


@pytest.mark.parametrize("kind", MEANT)
def test_the_option_that_a_refusal_prints_reads_the_log(folder: Path, kind: str) -> None:
    text, words, option = MEANT[kind]
    with pytest.raises(BadInputError, match="--column") as refused:
        asked(folder, text, words)
    printed = str(refused.value).rpartition("--column ")[2].removesuffix(" carries it on")
    assert shlex.split(printed) == [option]
    stated = {word.partition("=")[0]: word for word in (*words, option)}
    table = asked(folder, text, tuple(stated.values()))
    way = table.position("joint") - table.position("joint")[0]
    mirror = -1.0 if option.endswith("-rad") else 1.0
    assert way == pytest.approx(mirror * (LOG.position - LOG.position[0]), abs=2.0 * np.pi / 20480)
    if option.startswith("joint.current"):
        # one of its counts is 4.84 mN m
        assert table.torque("joint") == pytest.approx(LOG.torque, abs=3e-3)


def test_a_counter_that_restarted_once_begins_again_nowhere(folder: Path) -> None:
    position = np.where(np.arange(ROWS) > 4000, LOG.position - LOG.position[4001], LOG.position)
    with pytest.raises(BadInputError, match=r"line 4003: joint.position, row 4002 .*COLUMN%WRAP"):
        asked(folder, LOG.but(position=position).text())


def test_a_row_that_cannot_be_is_named_by_its_line_and_by_the_file_s_own_column(folder: Path) -> None:
    position = LOG.position.copy()
    position[4000] += 0.4
    columns = {"t": LOG.time, "tau": LOG.torque, "q [deg]": np.degrees(position)}
    text = "made by a logger\n\n" + table_text(columns, forms={"t": ".3f"})
    words = ("time_s=t", "joint.torque=tau", "joint.position=q [deg]")
    with pytest.raises(BadInputError, match=r"log.csv: line 4004, column q \[deg\]: joint.position, row 4001 at 8 s"):
        asked(folder, text, words)
    lost = text.splitlines()
    del lost[2000]
    with pytest.raises(BadInputError, match=r"log.csv: line 4003, column q \[deg\]: joint.position, row 4001 at 8 s"):
        asked(folder, "\n".join(lost) + "\n", words, resample=True)


@pytest.mark.parametrize("many", [20, 100])
def test_torques_that_read_zero_and_are_each_lost_in_the_noise_are_found_together(folder: Path, many: int) -> None:
    torque = LOG.torque.copy()
    rows = np.sort(np.random.default_rng(many).choice(np.arange(300, ROWS - 300), many, replace=False))
    torque[rows] = 0.0
    said = r"reads 0, which did nothing to the motion, the same in many .*\(\d+ rows in all\)"
    with pytest.raises(BadInputError, match=said):
        asked(folder, LOG.but(torque=torque).text())


@pytest.mark.parametrize("rows", [2, 3, 5, 8])
def test_pulses_of_several_rows_that_did_nothing_are_found_whole(folder: Path, rows: int) -> None:
    first = 40 * np.sort(np.random.default_rng(rows).choice(np.arange(8, ROWS // 40 - 8), 40 // rows, replace=False))
    planted = (first[:, None] + np.arange(rows)).ravel()
    torque = LOG.torque.copy()
    torque[planted] += 0.9
    said = rf"row {planted[0] + 1} at .* did nothing .*\({len(planted)} rows in all\)"
    with pytest.raises(BadInputError, match=said):
        asked(folder, LOG.but(torque=torque).text())


@pytest.mark.parametrize("rows", [1, 3, 8])
def test_pulses_of_several_rows_that_moved_the_joint_stay(folder: Path, rows: int) -> None:
    added = np.where(np.isin(np.arange(ROWS) // rows, SOME // rows), 0.3 / rows, 0.0)
    faster = np.concatenate([[0.0], np.cumsum(added * 0.002 / BENCH.inertia)[:-1]])
    moved = LOG.position + 0.002 * np.cumsum(faster) + 0.5 * added * 0.002**2 / BENCH.inertia
    step = 2.0 * np.pi / COUNTS
    torque = LOG.torque + added + BENCH.viscous * faster
    asked(folder, LOG.but(torque=torque, position=np.round(moved / step) * step).text())


def test_torques_that_moved_the_joint_stay_whatever_they_stand_out_by(folder: Path) -> None:
    added = np.where(np.isin(np.arange(ROWS), SOME), 0.3, 0.0)
    faster = np.concatenate([[0.0], np.cumsum(added * 0.002 / BENCH.inertia)[:-1]])
    moved = LOG.position + 0.002 * np.cumsum(faster)
    # an encoder twice as coarse hides what a single one of them does
    step = 4.0 * np.pi / COUNTS
    torque = LOG.torque + added + BENCH.viscous * faster
    asked(folder, LOG.but(torque=torque, position=np.round(moved / step) * step).text())
