"""Rows that no joint can make are told by file, column, row and value, or made up where that was asked for."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.preflight import impossible_rows, questioned
from gimbal_hil.data.signals import SignalsTable, read_signals, write_signals
from gimbal_hil.surface.cli.app import run
from tests.tables.joint import joint

PERIOD_S, ROWS = 2e-3, 6000
T = PERIOD_S * np.arange(ROWS)


def table(position: np.ndarray | None = None, torque: np.ndarray | None = None) -> SignalsTable:
    """A joint that swings, by its own equation of motion."""
    q = np.zeros(ROWS)
    v = np.zeros(ROWS)
    a = np.zeros(ROWS)
    for size, w in ((0.9, 1.4), (0.4, 4.5), (0.1, 12.0)):
        q, v, a = q + size * np.sin(w * T), v + size * w * np.cos(w * T), a - size * w * w * np.sin(w * T)
    true = 0.02 * a + 0.05 * np.sign(v) + 0.02 * v
    columns = {
        "joint.torque": true if torque is None else torque,
        "joint.position": np.round(q / 1e-4) * 1e-4 if position is None else position,
    }
    return SignalsTable.of(("joint",), T, columns, source="log.csv")


def spoilt(rows: list[int], by: float) -> SignalsTable:
    position = table().position("joint").copy()
    position[rows] += by
    return table(position)


@given(
    rows=st.lists(st.integers(20, ROWS - 20), min_size=1, max_size=12, unique_by=lambda row: row // 12),
    by=st.sampled_from([0.05, -0.05, 0.41, -9999.0]),
)
@settings(max_examples=40, deadline=None)
def test_rows_that_are_off_are_found_and_only_those(rows: list[int], by: float) -> None:
    (found,) = impossible_rows(joint(), spoilt(rows, by))
    assert found.column == "joint.position" and found.rows == tuple(sorted(rows)) and found.can_be_made_up


def test_a_sound_log_has_none_and_stays_as_it_is() -> None:
    sound = table()
    assert impossible_rows(joint(), sound) == [] and questioned(joint(), [sound])[0] is sound


def test_they_are_refused_with_file_column_row_time_and_value() -> None:
    with pytest.raises(BadInputError, match=r"joint.position, row 1001 at 2 s: reads .* \(2 rows in all\).*--repair"):
        questioned(joint(), [spoilt([1000, 3000], 0.4)])


def test_a_repair_makes_them_up_and_a_note_says_which() -> None:
    (mended,) = questioned(joint(), [spoilt([1000, 3000], 0.4)], repair=True)
    np.testing.assert_allclose(mended.position("joint"), table().position("joint"), atol=2e-3)
    assert any("2 of 6000 rows" in note and "row 1001" in note for note in mended.notes)


def test_what_the_rows_of_one_column_hid_in_another_is_made_up_too() -> None:
    sound, rows = table(), np.arange(300, 5700, 120)
    position, torque = sound.position("joint").copy(), sound.torque("joint").copy()
    position[rows] = torque[rows] = 0.0
    (mended,) = questioned(joint(), [table(position, torque)], repair=True)
    left = np.abs(mended.torque("joint") - sound.torque("joint"))[rows]
    assert np.mean(left > 0.05) < 0.05 < np.mean(np.abs(sound.torque("joint")[rows]) > 0.05)
    assert [note.partition(":")[0] for note in mended.notes] == ["joint.position", "joint.torque"]


def test_more_than_a_few_are_refused_with_repair_too() -> None:
    with pytest.raises(BadInputError, match="at most 2%"):
        questioned(joint(), [spoilt(list(range(100, 5900, 20)), 0.4)], repair=True)


@pytest.mark.parametrize("jump", [3.2 * 2 * np.pi, -1.257, 65536 * 1e-4])
def test_a_counter_that_wraps_or_restarts_is_refused_where_it_does(jump: float) -> None:
    position = table().position("joint").copy()
    position[2500:] += jump
    with pytest.raises(BadInputError, match=r"joint.position, row 2501 at 5 s: reads .* jumps by"):
        questioned(joint(), [table(position)], repair=True)


def test_a_torque_that_the_actuator_cannot_give_is_found() -> None:
    torque = table().torque("joint").copy()
    torque[[700, 4000]] = 317.0
    (found,) = impossible_rows(joint(), table(torque=torque))
    assert (found.column, found.rows) == ("joint.torque", (700, 4000))


def saturated() -> np.ndarray:
    """A command that goes beyond the limit and comes back in small steps: the actuator gives what it can."""
    torque = table().torque("joint").copy()
    torque[700:800] += 5.0 * np.sin(np.pi * np.arange(100) / 100)
    assert np.count_nonzero(np.abs(torque) > 1.2 * 3.0) > 40
    return torque


def test_a_loop_that_asks_for_more_than_there_is_is_read() -> None:
    assert not list(impossible_rows(joint(), table(torque=saturated())))


@pytest.mark.parametrize(("rows", "to"), [((4000,), 317.0), ((4000,), 6.0), ((4000, 4001, 4002), -6.0)])
def test_a_saturated_loop_hides_no_torque_that_cannot_be(rows: tuple[int, ...], to: float) -> None:
    torque = saturated()
    torque[list(rows)] = to
    (found,) = impossible_rows(joint(), table(torque=torque))
    assert found.rows == rows


def test_a_saturated_loop_hides_no_torque_that_did_nothing() -> None:
    torque = saturated()
    torque[[2000, 4000]] += 2.5
    (found,) = impossible_rows(joint(), table(torque=torque))
    assert found.rows == (2000, 4000) and "did nothing" in found.what


def test_negative_numbers_that_were_read_without_their_sign_are_told_as_that() -> None:
    counts = np.round(table().torque("joint") / 5e-3).astype(int) % 65536
    with pytest.raises(BadInputError, match="read without its sign"):
        questioned(joint(), [table(torque=5e-3 * counts)])


def test_samples_that_came_twice_or_not_at_all_are_no_impossible_places() -> None:
    position = table().position("joint").copy()
    position[1000] = position[999]
    position[2000:2003] = position[1999]
    assert impossible_rows(joint(), table(position)) == []


def test_a_last_line_without_its_end_is_left_out_with_a_note(tmp_path: Path) -> None:
    path = tmp_path / "cut.csv"
    write_signals(table(), path)
    text = path.read_text()
    path.write_text(text[:-4])
    read = read_signals(path, joint())
    assert len(read) == ROWS - 1 and any("no line end" in note for note in read.notes)


def test_both_commands_refuse_repair_and_tell(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    model, log = tmp_path / "model.yaml", tmp_path / "log.csv"
    model.write_text(joint().to_yaml())
    write_signals(spoilt([1000], 0.4), log)
    out = ["--out", str(tmp_path / "out"), "--model", str(model)]
    with pytest.raises(SystemExit) as refused:
        run("identify", [str(log), *out])
    assert refused.value.code == 2 and "row 1001" in capsys.readouterr().err
    assert run("identify", [str(log), *out, "--repair"]) == 0
    assert "row 1001" in capsys.readouterr().out
    notes = json.loads((tmp_path / "out" / "identification.json").read_text()).get("notes")
    assert notes and "row 1001" in notes[0]
