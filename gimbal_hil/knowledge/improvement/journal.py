"""The log of an improvement: one JSON object a line, each of a known kind, on disk before the next step begins.

It is what `--resume` goes by: an experiment or a diagnosis that the journal calls done is not made again.
"""

from __future__ import annotations

import json
import os
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import TypeAlias

from firmware_protocol.documents import json_line
from firmware_protocol.errors import BadInputError
from firmware_protocol.json_object import Json
from gimbal_hil.loop.timing import wall_clock_utc

JOURNAL_FILE = "journal.jsonl"


@dataclass(frozen=True)
class Started:
    """The first line: what was asked for. `session` is compared on resume."""

    session: Json


@dataclass(frozen=True)
class Resumed:
    """Somebody went on with a stopped improvement."""

    lines_before: int


@dataclass(frozen=True)
class Chosen:
    """Which experiment comes next and why; `considered` says what each entry of the menu was expected to show, in
    squared floors.
    """

    round: int
    run: str
    sequence: str
    axes: list[str]
    why: str
    considered: list[Json] = field(default_factory=list)


@dataclass(frozen=True)
class Refused:
    """An experiment that was not run because it would have exceeded a budget."""

    round: int
    sequence: str
    reason: str


@dataclass(frozen=True)
class Measuring:
    """The antenna begins to move: rehearsed peaks by axis."""

    round: int
    run: str
    sequence: str
    duration_s: float
    torque_nm: Json
    travel_rad: Json


@dataclass(frozen=True)
class Measured:
    """A run is complete; `antenna_s` is all antenna time used so far."""

    round: int
    run: str
    sequence: str
    role: str
    antenna_s: float
    wall_s: float


@dataclass(frozen=True)
class Diagnosed:
    """What a diagnosis on all runs so far said, what the loop makes of it, and the model that it leaves (a file below
    the folder). `text` is the answer, `more` how it is known.
    """

    round: int
    verdict: str
    text: str
    gaps: list[Json]
    effects: list[Json]
    alternatives: list[Json]
    decision: str
    #: the run that was chosen to separate explanations: sequence, axes, why, considered
    choice: Json | None
    #: the menu as it was weighed, whether or not an entry was worth its time
    considered: list[Json]
    #: what stays open for good, and why; empty where nothing does
    remark: str
    model: str | None
    wall_s: float
    more: str = ""
    #: where the logs cannot judge the model: numbers that could be off by a factor of two, as in a verdict
    would_not_show: list[Json] = field(default_factory=list)


@dataclass(frozen=True)
class Stopped:
    """The improvement was stopped before its end: by whom or what."""

    reason: str
    antenna_s: float


@dataclass(frozen=True)
class Ended:
    """The last line of a complete improvement: `text` says the ending, `more` what is left and what could be done."""

    ending: str
    text: str
    antenna_s: float
    rounds: int
    more: str = ""


Entry: TypeAlias = Started | Resumed | Chosen | Refused | Measuring | Measured | Diagnosed | Stopped | Ended
_KINDS = {
    kind.__name__.lower(): kind
    for kind in (Started, Resumed, Chosen, Refused, Measuring, Measured, Diagnosed, Stopped, Ended)
}


class Journal:
    """Appends entries to a file; each is flushed and on disk when `write` comes back."""

    def __init__(self, path: Path, *, resume: bool = False) -> None:
        self.path = path
        self.entries: list[Entry] = read_journal(path) if resume else []
        path.parent.mkdir(parents=True, exist_ok=True)
        if resume:
            _drop_cut_line(path)
        self._file = path.open("a" if resume else "w", encoding="utf-8")

    def write(self, entry: Entry) -> None:
        """One more line."""
        document = {"kind": type(entry).__name__.lower(), "at": wall_clock_utc(), **asdict(entry)}
        self._file.write(json.dumps(document, allow_nan=False) + "\n")
        self._file.flush()
        os.fsync(self._file.fileno())
        self.entries.append(entry)

    def close(self) -> None:
        """No more lines."""
        self._file.close()


def read_journal(path: Path) -> list[Entry]:
    """All whole lines of a journal; a last line that was cut is left out. BadInputError where there is no journal."""
    try:
        lines = path.read_bytes().split(b"\n")
    except FileNotFoundError:
        raise BadInputError(str(path), "no such file", "the folder of an improvement that was stopped") from None
    entries: list[Entry] = []
    for number, line in enumerate(lines[:-1], start=1):
        document = json_line(line, f"{path} line {number}", "an unchanged journal")
        try:
            kind = _KINDS[document["kind"]]
            entries.append(kind(**{one.name: document[one.name] for one in fields(kind)}))
        except (KeyError, TypeError) as error:
            raise BadInputError(
                f"{path} line {number}", f"is no journal entry ({error})", "an unchanged journal"
            ) from None
    return entries


def _drop_cut_line(path: Path) -> None:
    data = path.read_bytes()
    whole = data.rfind(b"\n") + 1
    if whole < len(data):
        with path.open("r+b") as file:
            file.truncate(whole)
