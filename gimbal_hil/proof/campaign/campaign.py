"""One experiment on many virtual antennas: a row of the table for each, the same row wherever it is computed.

What an antenna is, its noise included, follows from the campaign and its number alone. Rows are appended in the order
of the numbers, so a table that was cut off anywhere says itself where to go on, and one that was computed by more
processes or in several runs is the same file.
"""

from __future__ import annotations

import csv
import hashlib
import io
import json
import os
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from firmware_protocol.errors import BadInputError, GimbalHilError
from firmware_protocol.places import require_new
from gimbal_hil.data.runs import one_writer
from gimbal_hil.knowledge.executor import WorkExecutor
from gimbal_hil.knowledge.experiments import Experiment, LockstepAntenna, Row, plan_hash
from gimbal_hil.loop.settings import DaemonSettings
from gimbal_hil.proof.campaign.spreads import NumberSpread, drawn
from sim_backend.model import AntennaModel

TABLE_FILE, ABOUT_FILE = "antennas.csv", "campaign.json"
#: antennas that are one piece of work
_PIECE = 10
#: of a line, as the csv module writes it
_END = b"\r\n"
#: no log is kept: as few rows as possible are made for one
_LOG_EVERY = 1 << 30


@dataclass(frozen=True)
class Campaign:
    """All that decides the row of an antenna but its number."""

    experiment: Experiment
    settings: DaemonSettings
    model: AntennaModel
    spreads: tuple[NumberSpread, ...]
    seed: int

    def digest(self) -> str:
        """Equal where every row is."""
        asked = [self.model.document, self.settings.model_dump(mode="json", by_alias=True), self.seed]
        asked += [[spread.name, spread.deviation] for spread in self.spreads]
        parts = [plan_hash(part) for part in self.experiment.parts or (self.experiment,)]
        return hashlib.sha256(json.dumps([asked, parts], sort_keys=True).encode()).hexdigest()

    def row(self, number: int) -> Row:
        """Of one antenna: its number, what was drawn, and what each measured step gave, or why it gave nothing.

        Antenna 0 is the model as it stands.
        """
        dice = np.random.default_rng((self.seed, number))
        seed = int(dice.integers(1 << 31))
        model = drawn(self.model, self.spreads, dice) if number else self.model
        row: Row = {"antenna": number, "problem": ""}
        row |= {spread.name: model.number(spread.axis, spread.path) for spread in self.spreads}
        for part in self.experiment.parts or (self.experiment,):
            try:
                row |= self._measured(part, model, seed)
            except GimbalHilError as error:
                row["problem"] = str(error)
        return row

    def _measured(self, part: Experiment, model: AntennaModel, seed: int) -> Row:
        row: Row = {}
        with closing(LockstepAntenna(self.settings, model, seed, _LOG_EVERY)) as antenna:
            antenna.connect()
            for step in part.steps:
                followed = antenna.follow(step, lambda ticks: None)
                found = part.measure(step, followed.signals) if step.measured else None
                row |= {f"{step.name}: {name}": _plain(value) for name, value in (found or {}).items()}
        return row


@dataclass(frozen=True)
class Done:
    """What a campaign left: the antennas in the table, and how many of them were measured now."""

    table: Path
    antennas: int
    now: int


def run_campaign(
    campaign: Campaign,
    antennas: int,
    folder: Path,
    executor: WorkExecutor,
    *,
    ahead: int,
    resume: bool = False,
    force: bool = False,
    tell: Callable[[int, int], None] = lambda done, now: None,
) -> Done:
    """Measure antennas 0 (the model itself) to `antennas`; with `resume` those that the table in `folder` lacks.

    `ahead` pieces of work are under way at once. `tell` hears how many antennas are done, and how many since it heard
    last. What the nominal antenna cannot do is refused; what another cannot do stands in its row.
    Two campaigns in one folder are refused.
    """
    table = folder / TABLE_FILE
    _require_free(folder, resume, force)
    if not (resume and table.exists()) and (problem := campaign.row(0)["problem"]):
        raise BadInputError("the model's own antenna", str(problem), "an experiment that it can do")
    folder.mkdir(parents=True, exist_ok=True)
    with one_writer(folder):
        first = done = _begun(campaign, folder, resume, force)
        tell(done, done)
        with table.open(encoding="utf-8", newline="") as begun:
            columns = next(csv.reader(begun))
        with table.open("a", encoding="utf-8", newline="") as file:
            for rows in _in_order(campaign, range(done, antennas + 1), executor, ahead):
                file.write(_lines([[row.get(name) for name in columns] for row in rows]))
                file.flush()
                done += len(rows)
                tell(done, len(rows))
            os.fsync(file.fileno())
    return Done(table, done, done - first)


def _in_order(campaign: Campaign, numbers: range, executor: WorkExecutor, ahead: int) -> Iterator[list[Row]]:
    """Rows of the antennas, piece by piece; no more pieces are handed out than `ahead`, so that memory stays flat."""
    shared = executor.share(campaign)
    waiting: deque[Future[list[Row]]] = deque()
    for start in range(numbers.start, numbers.stop, _PIECE):
        waiting.append(executor.submit(_piece, shared, start, min(start + _PIECE, numbers.stop)))
        if len(waiting) >= ahead:
            yield waiting.popleft().result()
    while waiting:
        yield waiting.popleft().result()


def _piece(campaign: Campaign, start: int, stop: int) -> list[Row]:
    return [campaign.row(number) for number in range(start, stop)]


def _require_free(folder: Path, resume: bool, force: bool) -> None:
    require_new(folder, resume or force, TABLE_FILE, instead="a new folder, --resume to go on")


def _begun(campaign: Campaign, folder: Path, resume: bool, force: bool) -> int:
    """How many antennas the table of this campaign has: on resume without what was cut off in writing, else the
    nominal one.
    """
    table, about = folder / TABLE_FILE, folder / ABOUT_FILE
    # again: somebody else may have had the folder until now
    _require_free(folder, resume, force)
    if resume and table.exists():
        if json.loads(about.read_text(encoding="utf-8"))["digest"] != campaign.digest():
            raise BadInputError(str(folder), "is another campaign", "the same options, but for the number of antennas")
        *whole, _ = table.read_bytes().split(_END)
        if len(whole) > 1:
            table.write_bytes(_END.join([*whole, b""]))
            return len(whole) - 1
    nominal = campaign.row(0)
    told = {"schema": 1, "experiment": campaign.experiment.name, "model": campaign.model.name, "seed": campaign.seed}
    told["spreads"] = {spread.name: spread.deviation for spread in campaign.spreads}
    about.write_text(json.dumps(told | {"digest": campaign.digest()}, indent=1), encoding="utf-8")
    table.write_bytes(_lines([list(nominal), list(nominal.values())]).encode())
    return 1


def _lines(rows: list[list[object]]) -> str:
    text = io.StringIO()
    csv.writer(text).writerows(rows)
    return text.getvalue()


def _plain(value: object) -> object:
    return float(value) if isinstance(value, float | np.floating) else value
