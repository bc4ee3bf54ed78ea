"""Inputs of the kinds that people report, with a fault put into a log of a joint whose numbers are known.

Each is refused with the place and the value, or repaired and told, or its numbers hold the truth: never an all-clear,
and never a narrow wrong number.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import butter, filtfilt

from firmware_protocol.errors import BadInputError
from gimbal_hil.surface.cli.app import run
from gimbal_hil.surface.library import identify
from tests.cases.asking import asked
from tests.cases.joint import COUNTS, MODEL, TRUE, JointLog, swinging, table_text
from tests.parts import heavy_but

LOG = swinging()
ROWS = len(LOG.time)
COUNTED = np.round(LOG.position / (2.0 * np.pi / COUNTS)).astype(np.int64)
RAW = np.round(LOG.torque / 1.8 / 2.69e-3).astype(np.int64)
SOME = np.sort(np.random.default_rng(3).choice(np.arange(300, ROWS - 300), 20, replace=False))
LATER = np.arange(ROWS) > ROWS // 2
LINES = LOG.text().splitlines()
CURRENT = ("time_s=t", "joint.position=q", "joint.current=i:2.69*mA")
STAMPED = ("joint.position=q", "joint.torque=tau")


def spoilt(column: str, rows: np.ndarray, to: float | None = None, by: float = 0.0) -> str:
    values = getattr(LOG, column).copy()
    values[rows] = values[rows] + by if to is None else to
    return LOG.but(**{column: values}).text()


def counter(per_turn: float, wrap: int, start: int = 0) -> str:
    """A counter of a motor behind a gear, `per_turn` counts a turn of the joint, that begins again."""
    counts = np.round(LOG.position * per_turn / (2.0 * np.pi)).astype(np.int64) + start
    columns = {"time_s": LOG.time, "tau": LOG.torque, "enc": counts % wrap}
    return table_text(columns, forms={"enc": "d"})


def current(counts: np.ndarray) -> str:
    return table_text({"t": LOG.time, "q": LOG.position, "i": counts}, forms={"t": ".3f", "i": "d"})


def at_times(times: np.ndarray, form: str = ".6f") -> str:
    return LOG.but(time=times).text(forms={"time_s": form})


def in_parts(seconds: str, rest: str, size: float) -> str:
    whole = np.floor(LOG.time + 0.9)
    columns = {seconds: whole + 1732340000, rest: np.round((LOG.time + 0.9 - whole) / size)}
    return table_text(columns | {"q": LOG.position, "tau": LOG.torque}, forms={seconds: ".0f", rest: ".0f"})


def gear(per_turn: int) -> tuple[str, ...]:
    return ("joint.torque=tau", f"joint.position=enc:turn/{per_turn}")


#: a log as text, words for --column, and what is said of it
Case = Callable[[], tuple[str, tuple[str, ...], str]]

#: faults, and what the refusal says
REFUSED: dict[str, Case] = {
    # counters
    "16 bits behind 5:1": lambda: (
        counter(20480, 65536, 100),
        gear(20480),
        r"joint.position, row \d+ at .* jumps by 20.1.*enc%65536:turn/20480 carries it on",
    ),
    "16 bits behind 50:1": lambda: (
        counter(204800, 65536, 60000),
        gear(204800),
        r"joint.position, row \d+ at .* jumps by -2.01",
    ),
    "12 bits of the motor behind 3:1": lambda: (counter(12288, 4096), gear(12288), "jumps by 2.094"),
    "restarts at zero": lambda: (
        LOG.but(position=np.where(LATER, LOG.position - LOG.position[4001], LOG.position)).text(),
        (),
        r"joint.position, row 4002 at 8.002 s: reads .* jumps by",
    ),
    "at its rails": lambda: (
        LOG.but(position=np.clip(LOG.position, -1.2, 0.8)).text(),
        (),
        "is the same in 49 rows and moves off",
    ),
    # single rows, stuck columns
    "last row is zero": lambda: (
        spoilt("position", np.array([ROWS - 1]), 0.0),
        (),
        "row 8000 at 15.998 s: reads 0, where",
    ),
    "first row is another place": lambda: (
        spoilt("position", np.array([0]), 0.7),
        (),
        "row 1 at 0 s: reads 0.7, where the joint cannot have been; .*--repair",
    ),
    "a burst of eight reads": lambda: (spoilt("position", np.arange(3000, 3008), by=0.3), (), "row 3001 at 6 s"),
    "0.2 degrees in 20 rows": lambda: (
        spoilt("position", SOME, by=np.radians(0.2)),
        (),
        r"row \d+ .* where the joint cannot",
    ),
    "position stuck for 60 rows": lambda: (
        spoilt("position", np.arange(3000, 3060), LOG.position[3000]),
        (),
        "row 3002 at 6.002 s: reads .* the same in 60 rows and stops within one row",
    ),
    "position stuck to the end": lambda: (
        spoilt("position", np.arange(5000, ROWS), LOG.position[5000]),
        (),
        "is the same in 3000 rows",
    ),
    "position is one number": lambda: (
        LOG.but(position=np.full(ROWS, 0.3)).text(),
        (),
        "log.csv: position: never changes",
    ),
    "20 torques at the limit": lambda: (
        spoilt("torque", SOME, 3.0),
        (),
        r"row \d+ .* reads 3, which did nothing .*20 rows",
    ),
    "20 torques lost to zero": lambda: (
        spoilt("torque", SOME, 0.0),
        (),
        r"joint.torque, row 542 .* reads 0, which did nothing to the motion.*20 rows in all.*--repair",
    ),
    "torque stuck for a second": lambda: (
        spoilt("torque", np.arange(3000, 3500), LOG.torque[3000]),
        (),
        r"joint.torque, row 30\d\d at 6.*the motion asks for another torque",
    ),
    "torque stuck to the end": lambda: (
        spoilt("torque", np.arange(5000, ROWS), LOG.torque[5000]),
        (),
        "asks for another torque",
    ),
    "torque zero in one half": lambda: (
        spoilt("torque", np.arange(4000, ROWS), 0.0),
        (),
        r"row 40\d\d .* asks for another torque",
    ),
    "torque clipped in most rows": lambda: (
        LOG.but(torque=np.clip(swinging(cogging=0.05).torque, -0.2, 0.2)).text(),
        (),
        "the end of the column's range, .* asks for more torque",
    ),
    "torque clipped by the logger": lambda: (
        # beside cogging that no model knows, which one fit of all rows takes the rails for
        LOG.but(torque=np.clip(swinging(cogging=0.05).torque, -0.4, 0.4)).text(),
        (),
        "the end of the column's range, .* asks for more torque",
    ),
    "torque is zero": lambda: (LOG.but(torque=np.zeros(ROWS)).text(), (), "log.csv: torque: never changes"),
    # currents and signs
    "half of the rows unsigned": lambda: (
        current(np.where(np.arange(ROWS) % 2, RAW, RAW % 65536)),
        CURRENT,
        r"reads 317.*read without its sign \(\d+ rows in all\).*joint.current=i%65536",
    ),
    "unsigned from the middle on": lambda: (
        current(np.where(LATER, RAW % 65536, RAW)),
        CURRENT,
        "read without its sign",
    ),
    "ten bits unsigned": lambda: (current(RAW % 1024), CURRENT, "read without its sign"),
    "eight bits that begin again": lambda: (
        current((RAW + 128) % 256 - 128),
        CURRENT,
        "joint.torque: seems to be of a number that begins again at the other end of its range.*%WRAP",
    ),
    "negative currents are none": lambda: (
        LOG.but(torque=np.clip(LOG.torque, 0.0, None)).text(),
        (),
        "asks for another torque",
    ),
    "only the size of the torque": lambda: (
        LOG.but(torque=np.abs(LOG.torque)).text(),
        (),
        "log.csv: joint.torque: seems to be without its sign",
    ),
    "torque mirrored": lambda: (LOG.but(torque=-LOG.torque).text(), (), "mirrored"),
    # clocks
    "restarts in the middle": lambda: (
        at_times(np.where(LATER, LOG.time - LOG.time[4001], LOG.time)),
        (),
        "line 4003, column time_s",
    ),
    "16 bits of milliseconds": lambda: (
        at_times((np.round(LOG.time * 1e3) + 60000) % 65536, ".0f"),
        ("time_s=time_s:ms",),
        "line 2770",
    ),
    "a gap of half a second": lambda: (at_times(LOG.time + 0.5 * LATER), (), "line 4003, .* a gap"),
    "20 stamps come twice": lambda: (
        at_times(np.where(np.isin(np.arange(ROWS), SOME), LOG.time - 2e-3, LOG.time)),
        (),
        "line 543, column time_s: is the same",
    ),
    "milliseconds for seconds": lambda: (at_times(1e3 * LOG.time, ".0f"), (), "usual for milliseconds"),
    "nanoseconds for seconds": lambda: (at_times(1e9 * LOG.time, ".0f"), (), "usual for nanoseconds"),
    "minutes for seconds": lambda: (at_times(LOG.time / 60.0, ".9f"), (), "seems to be in minutes: up to row"),
    "numbers of rows for seconds": lambda: (at_times(np.arange(ROWS), ".0f"), (), "numbers of rows"),
    "backwards": lambda: (
        "\n".join([LINES[0], *LINES[:0:-1]]) + "\n",
        (),
        r"line 3, .* --resample \(keeps 8000 of 8000",
    ),
    "two blocks exchanged": lambda: (
        "\n".join(LINES[:2001] + LINES[4001:4101] + LINES[2101:4001] + LINES[2001:2101] + LINES[4101:]) + "\n",
        (),
        "line 2102",
    ),
    "nanoseconds for microseconds": lambda: (
        in_parts("sec", "nsec", 1e-9),
        ("time_s=sec+nsec:us", *STAMPED),
        "line 52",
    ),
    "seconds alone": lambda: (in_parts("sec", "nsec", 1e-9), ("time_s=sec:s", *STAMPED), "17 stamps"),
    # text
    "a cell cut in the middle": lambda: (
        "\n".join([*LINES[:4000], LINES[4000][:-6], *LINES[4001:]]) + "\n",
        (),
        "row 4000 at 7.998",
    ),
    "an empty cell": lambda: (
        "\n".join([*LINES[:4000], LINES[4000].rpartition(",")[0] + ",", *LINES[4001:]]) + "\n",
        (),
        "line 4001, column joint.position",
    ),
    "two lines run together": lambda: (
        "\n".join([*LINES[:4000], LINES[4000] + LINES[4001], *LINES[4002:]]) + "\n",
        (),
        "line 4001",
    ),
    "a block of zero bytes": lambda: (
        LOG.text()[:60000] + "\0" * 4096 + LOG.text()[64096:],
        (),
        r"line \d+, column joint.torque",
    ),
    "one row": lambda: ("\n".join(LINES[:2]) + "\n", (), "has 1 usable rows"),
    "no row": lambda: (LINES[0] + "\n", (), "has 0 usable rows"),
    "nothing": lambda: ("", (), "is empty"),
    "decimal commas from the middle on": lambda: (
        "\n".join(
            [
                LINES[0].replace(",", ";"),
                *(line.replace(",", ";") for line in LINES[1:4000]),
                *(line.replace(",", ";").replace(".", ",") for line in LINES[4000:]),
            ]
        )
        + "\n",
        (),
        "may be",
    ),
    "decimal commas parted by commas": lambda: (
        LOG.text(forms={name: lambda x: f"{x:.6f}".replace(".", ",") for name in LINES[0].split(",")}),
        (),
        "decimal commas",
    ),
    # units
    "degrees": lambda: (LOG.but(position=np.degrees(LOG.position)).text(), (), "in degrees"),
    "turns": lambda: (LOG.but(position=LOG.position / (2.0 * np.pi)).text(), (), "seem"),
    "mN m": lambda: (LOG.but(torque=1e3 * LOG.torque).text(), (), "another unit than torque's"),
    "a millionth": lambda: (
        LOG.but(torque=1e6 * LOG.torque).text(),
        (),
        "the model's actuator gives 3: .* another unit",
    ),
    "per cent of the limit": lambda: (
        LOG.but(torque=LOG.torque / 3.0 * 100.0).text(),
        (),
        "another unit than torque's",
    ),
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    found = tmp_path_factory.mktemp("cases")
    (found / "model.yaml").write_text(MODEL)
    return found


@pytest.mark.parametrize("fault", REFUSED)
def test_a_log_that_cannot_be_is_refused_with_the_place_and_the_value(folder: Path, fault: str) -> None:
    text, words, said = REFUSED[fault]()
    with pytest.raises(BadInputError, match=said) as refused:
        asked(folder, text, words)
    assert "\n" not in str(refused.value) and "log.csv" in str(refused.value) and len(str(refused.value)) < 700


#: what is read as it was meant, and a note of it where something was done
RIGHT: dict[str, Case] = {
    "degrees from 0 to 360": lambda: (
        table_text({"time_s": LOG.time, "tau": LOG.torque, "q": np.degrees(LOG.position) % 360.0}),
        ("joint.torque=tau", "joint.position=q:deg"),
        "whole turns were added",
    ),
    "a wrap that is stated": lambda: (
        counter(204800, 65536, 60000),
        ("joint.torque=tau", "joint.position=enc%65536:turn/204800"),
        "",
    ),
    "positions at 100 Hz": lambda: (
        LOG.but(position=LOG.position[np.arange(ROWS) // 5 * 5]).text(),
        (),
        "refreshed every 5 rows",
    ),
    "unsigned with its wrap": lambda: (
        current(RAW % 65536),
        ("time_s=t", "joint.position=q", "joint.current=i%65536:2.69*mA"),
        "",
    ),
    "seconds and microseconds": lambda: (in_parts("sec", "usec", 1e-6), ("time_s=sec+usec", *STAMPED), ""),
    "cut in its last cell": lambda: (
        LOG.text(forms={"joint.position": ".9e"})[:-3],
        (),
        "no line end and was left out",
    ),
    "a remark among the rows": lambda: (
        "\n".join([*LINES[:3000], "# event: start", *LINES[3000:]]) + "\n",
        (),
        "remarks",
    ),
    "units in a second row": lambda: (
        "\n".join([LINES[0], "[s],[N m],[rad]", *LINES[1:]]) + "\n",
        (),
        "in rad, as the file says",
    ),
    "a decimal comma in one column": lambda: (
        LOG.text(between=";", forms={"joint.torque": lambda x: f"{x:.6f}".replace(".", ",")}),
        (),
        "",
    ),
}


@pytest.mark.parametrize("form", RIGHT)
def test_a_log_that_is_only_written_otherwise_gives_the_numbers(folder: Path, form: str) -> None:
    text, words, note = RIGHT[form]()
    numbers, notes = identified(folder, text, *words)
    assert note in notes
    assert {"inertia", "coulomb", "viscous"} <= numbers.keys()
    hold_the_truth(numbers)


#: what no single log can contradict, or what only costs width
WITHIN: dict[str, Callable[[], JointLog]] = {
    "stale reads, one in twenty": lambda: LOG.but(position=_stale(LOG.position)),
    "torque of two rows before": lambda: LOG.but(torque=np.roll(LOG.torque, 2)),
    "torque of a clock that drifts": lambda: LOG.but(torque=np.interp(1.002 * LOG.time, LOG.time, LOG.torque)),
    "torque filtered both ways": lambda: LOG.but(torque=filtfilt(*butter(2, 5.0 / 250.0), LOG.torque)),
    "both columns filtered both ways": lambda: LOG.but(
        torque=filtfilt(*butter(2, 10.0 / 250.0), LOG.torque), position=filtfilt(*butter(2, 10.0 / 250.0), LOG.position)
    ),
    "its sign turns in the middle": lambda: LOG.but(torque=np.where(LATER, -LOG.torque, LOG.torque)),
}


@pytest.mark.parametrize("fault", heavy_but(("torque of a clock that drifts", "torque filtered both ways"), WITHIN))
def test_what_is_identified_all_the_same_holds_the_truth(folder: Path, fault: str) -> None:
    numbers, _ = identified(folder, WITHIN[fault]().text())
    hold_the_truth(numbers)


def test_a_torque_of_another_log_is_said_to_explain_nothing(folder: Path) -> None:
    numbers, _ = identified(folder, LOG.but(torque=swinging("b").torque).text())
    assert numbers == {}
    (axis,) = json.loads((folder / "out" / "identification.json").read_text())["axes"]
    assert any("may not belong together" in one["text"] for one in axis["findings"])


def _stale(position: np.ndarray) -> np.ndarray:
    stale = np.random.default_rng(4).random(len(position)) < 0.05
    stale[0] = False
    rows = np.arange(len(position))
    return position[np.maximum.accumulate(np.where(stale, 0, rows))]


def identified(folder: Path, text: str, *words: str) -> tuple[dict[str, dict[str, float]], str]:
    """Numbers that `identify` calls identified, and its notes."""
    (folder / "log.csv").write_text(text)
    options = ["--column", *words] if words else []
    out = ["--out", str(folder / "out"), "--force", "--workers", "1", "--json"]
    run("identify", [str(folder / "log.csv"), "--model", str(folder / "model.yaml"), *options, *out])
    answer = json.loads((folder / "out" / "identification.json").read_text())
    (axis,) = answer["axes"].values() if isinstance(answer["axes"], dict) else answer["axes"]
    found = {one["name"]: one for one in axis["estimates"] if one["verdict"] == "identified"}
    return found, " ".join(answer["notes"])


def hold_the_truth(numbers: dict[str, dict[str, float]]) -> None:
    for name, true in TRUE.items():
        if name in numbers:
            one, room = numbers[name], 0.01 * max(abs(true), TRUE["coulomb"])
            assert one["low"] - room <= true <= one["high"] + room, (name, one["low"], one["high"])


def test_a_frame_that_cannot_be_is_told_by_its_place_in_the_call(folder: Path) -> None:
    pandas = pytest.importorskip("pandas")
    columns = {"time_s": LOG.time, "joint.torque": LOG.torque, "joint.position": np.clip(LOG.position, -1.2, 0.8)}
    with pytest.raises(BadInputError, match=r"^log 0 \(a DataFrame\): joint.position, row \d+"):
        identify(pandas.DataFrame(columns), folder / "model.yaml")
