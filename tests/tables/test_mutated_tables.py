"""A table that was spoilt anywhere is refused in one line, repaired with a note, or is still the joint's motion."""

from __future__ import annotations

from random import Random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.preflight import impossible_rows, questioned
from gimbal_hil.data.signals import SignalsTable, read_signals
from tests.tables.joint import Q, T, joint, lines

MODEL = joint()
#: what the questions of a log let pass: five times the way that the largest torque makes in a row, in either of two
PASSES = 2.0 * 5.0 * 3.0 / 0.02 * 2e-3**2
CELLS = ("", "nan", "inf", "-", "1e308", "-9999", "0", "1.", "0x1F", "1_000", "1,5", "1.234.567", "#REF!", "2024-01-01",
         "\u2212", "9" * 400, "1e", ".", ",", '"', "\0", "%", "true", "12:30:00")  # fmt: skip
PIECES = (
    "\n",
    "\r",
    "\r\n",
    ",",
    ";",
    "\t",
    " ",
    '"',
    "\0",
    "\x1b[2J",
    "\ufeff",
    "# x\n",
    "time_s",
    "-",
    "e",
    ".",
    "é",
    "\ud7ff",
)


def spoilt(random: Random, form: str) -> str:
    """The log with one to three things wrong in it: cells, rows, lines, marks, its end."""
    rows = lines(";", comma=True) if form == "de" else lines("\t") if form == "tabs" else lines()
    between = {"de": ";", "tabs": "\t"}.get(form, ",")
    for _ in range(random.choice((1, 1, 2, 3))):
        at = random.randrange(len(rows))
        cells = rows[at].split(between)
        place = random.randrange(len(cells))
        kind = random.randrange(9)
        if kind == 0:
            cells[place] = random.choice(CELLS)
        elif kind == 1:
            cells[place] = cells[place][: random.randrange(len(cells[place]) + 1)]
        elif kind == 2:
            cells[place] = cells[place].replace("." if form != "de" else ",", "")
        elif kind == 3:
            cells = cells[:place] if random.random() < 0.5 else [*cells, random.choice(CELLS)]
        elif kind == 4:
            cells = list(reversed(cells))
        rows[at] = between.join(cells)
        if kind == 5:
            rows[at : at + random.randrange(1, 40)] = []
        elif kind == 6:
            rows[at:at] = rows[max(0, at - random.randrange(1, 300)) : at]
        elif kind == 7:
            rows.insert(at, random.choice(("[WARN] late", "", "-----", "max,1,2", "{}", "\x07")))
        elif kind == 8:
            rows = rows[: at + 1]
        if not rows:
            rows = [""]
    text = "\n".join(rows) + random.choice(("\n", "\n", "", "\n\n\0\0"))
    if random.random() < 0.3:
        at = random.randrange(len(text) + 1)
        text = text[:at] + random.choice(PIECES) + text[at + random.randrange(3) :]
    return text[: random.randrange(len(text) + 1)] if random.random() < 0.1 else text


@settings(max_examples=120, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    form=st.sampled_from(("plain", "de", "tabs")),
    repair=st.sampled_from(
        ({}, {}, {"resample": True}, {"drop_invalid": True}, {"resample": True, "drop_invalid": True})
    ),
)
def test_a_spoilt_table_is_refused_or_still_tells_the_motion(
    tmp_path_factory: pytest.TempPathFactory, seed: int, form: str, repair: dict[str, bool]
) -> None:
    path = tmp_path_factory.mktemp("spoilt") / "log.csv"
    path.write_bytes(spoilt(Random(seed), form).encode("utf-8", "replace"))
    try:
        (table,) = questioned(MODEL, [read_signals(path, MODEL, **repair)])
    except BadInputError as refused:
        assert "\n" not in str(refused) and "log.csv" in str(refused)
        return
    if not repair:
        assert off(table) < PASSES, table.notes
    assert impossible_rows(MODEL, table) == []


def off(table: SignalsTable) -> float:
    """By how much the position is off the joint's motion at the same times, rad; rows alone may be missing, never
    wrong.
    """
    return float(np.max(np.abs(np.interp(table.time_s, T, Q) - table.position("joint"))))


#: how files begin that a library reads: what follows here is nothing that it can read
BEGINNINGS = (
    b"",
    b"ULog\x01\x12\x35",
    b"MDF     4.10    ",
    b"\x89MCAP0\r\n",
    b"#ROSBAG V2.0\n",
    b"SQLite format 3\x00",
    b"MATLAB 5.0 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x01IM",
    b"PAR1",
    b"PK\x03\x04",
    b"[{",
    b"LOGG",
    b"(0.0) can0 123#00\n",
)
ENDINGS = (".csv", ".txt", ".log", ".npz", ".npy", ".csv.gz", ".db3", ".mat", ".xlsx", ".mf4", "")


@pytest.mark.heavy
@settings(max_examples=25, deadline=None)
@given(beginning=st.sampled_from(BEGINNINGS), content=st.binary(max_size=400), ending=st.sampled_from(ENDINGS))
def test_any_bytes_are_refused_in_one_line(
    tmp_path_factory: pytest.TempPathFactory, beginning: bytes, content: bytes, ending: str
) -> None:
    path = tmp_path_factory.mktemp("any") / f"log{ending}"
    path.write_bytes(beginning + content)
    with pytest.raises(BadInputError) as refused:
        read_signals(path, MODEL)
    assert "\n" not in str(refused.value)
