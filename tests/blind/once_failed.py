"""The cases that confident false names once came out of, or a traceback, asked again: what is hidden, what is said.

    python -m tests.blind.once_failed FOLDER --seed N --rows 'null*'

Each row is drawn from the seed and its name as the bench draws, and the shipped command is told the written files
alone. Rows whose logs are spoiled (degrees, mirrored and swapped axes) are to be refused by name. A lag is drawn once
and asked twice, with a model that is right and with one whose other axis has its centre of gravity one standard
deviation off: the answer is to be the same. What has been asked stays in FOLDER; `--table` only prints what is there.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from fnmatch import fnmatch
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import yaml

from tests.blind.answer import VERDICT_FILE, answer_of
from tests.blind.draw import Wrong
from tests.blind.files import write_case, write_log
from tests.blind.kinds import Job, Stated
from tests.blind.run import TRUTH_FILE
from tests.blind.score import outcome

Columns = dict[str, np.ndarray]
LIMIT_S = 900
#: what the shipped model says of its inner centre of gravity: 0.1 % of its distance from the axis
ONE_SIGMA_M = 2.2e-5


@dataclass(frozen=True)
class Row:
    """One case: how it is drawn, how its logs are spoiled (None: not at all), a word that a refusal must have, and how
    far the model's inner centre of gravity is off, m.
    """

    job: Job
    spoil: Callable[[Columns], Columns] | None = None
    said: str = ""
    off_m: float = 0.0

    @property
    def name(self) -> str:
        """The case's, and whether its model is off: both are the same draw."""
        return f"{self.job.name}.other_axis_off" if self.off_m else self.job.name


def _in_degrees(columns: Columns) -> Columns:
    moved = (".position", ".rate", ".position_ref")
    return {
        name: np.rad2deg(x) if name.endswith(moved) and not name.startswith("base.") else x
        for name, x in columns.items()
    }


def _base_in_degrees(columns: Columns) -> Columns:
    return {name: np.rad2deg(x) if name.startswith("base.") else x for name, x in columns.items()}


def _mirrored(columns: Columns) -> Columns:
    turned = ("inner.position", "inner.rate", "inner.position_ref")
    return {name: -x if name in turned else x for name, x in columns.items()}


def _swapped(columns: Columns) -> Columns:
    other = {"outer": "inner", "inner": "outer"}
    names = (name.partition(".") for name in columns)
    return {
        f"{other.get(axis, axis)}{dot}{signal}": x
        for (axis, dot, signal), x in zip(names, columns.values(), strict=True)
    }


def rows() -> Iterator[Row]:
    """Every row."""
    for axis in ("outer", "inner"):
        for k in range(2):
            outside = {"names": ["hardening_stop"], "axis": axis, "outside_cause": True}
            yield Row(Job(f"hardening_stop.{axis}.{k}", outside))
            both = {"names": ["position_dependent_friction", "cogging"], "axis": axis}
            yield Row(Job(f"friction_and_ripple_over_position.{axis}.{k}", both))
            yield Row(Job(f"temperature_viscosity.{axis}.{k}", {"names": ["temperature_viscosity"], "axis": axis}))
            yield Row(Job(f"viscous_45_floors.{axis}.{k}", {"names": ["viscous"], "axis": axis, "magnitude": 45.0}))
    for k in range(6):
        yield Row(Job(f"null_that_wanders.{k}", {"names": [], "wander": True}))
    for k in range(5):
        far = {"names": [], "rig": "plain", "wrong": Wrong(5, 0.20, 0.33)}
        yield Row(Job(f"five_numbers_off.{k}", far, Stated.CAD if k % 2 else Stated.NOTHING))
    for k in range(9):
        yield Row(Job(f"three_at_once.{k}", {"apart": True, "count": 3}))
    for k in range(4):
        lag = Job(f"lag.{k}", {"names": ["actuator_lag"], "axis": "outer", "magnitude": 5.0})
        yield Row(lag)
        yield Row(lag, off_m=ONE_SIGMA_M)
        telegraph = {"names": ["friction_switching"], "axis": "outer", "outside_cause": True}
        yield Row(Job(f"friction_that_jumps.{k}", telegraph))
        three = {"names": ["static_unbalance", "gyro_misalignment", "saturation"], "axis": "inner"}
        yield Row(Job(f"unbalance_gyro_and_limit.{k}", three))
    # dynamic unbalance shows on a moving base only, so that one is drawn
    still: dict[str, Any] = {"names": []}
    moving: dict[str, Any] = {"names": ["dynamic_unbalance"], "axis": "inner", "magnitude": 1.5}
    for k in range(2):
        yield Row(Job(f"degrees_for_radians.{k}", still), _in_degrees, "degrees")
        yield Row(Job(f"axes_swapped.{k}", still), _swapped, "swapped")
        yield Row(Job(f"axis_mirrored.{k}", still), _mirrored, "mirrored")
        yield Row(Job(f"base_in_degrees.{k}", moving), _base_in_degrees, "degrees")


def _moved(file: Path, by_m: float) -> None:
    """A model file with its inner centre of gravity elsewhere, along and across the axis."""
    document = yaml.safe_load(file.read_text(encoding="utf-8"))
    cog = document["axes"]["inner"]["body"]["cog"]
    for along in "xz":
        cog[along]["value"] += by_m
    file.write_text(yaml.safe_dump(document), encoding="utf-8")


def ask(row: Row, seed: int, folder: Path) -> dict[str, Any]:
    """What the command says of a row's files."""
    if not (folder / TRUTH_FILE).exists():
        write_case(row.job, seed, folder)
        for path in sorted((folder / "data").glob("*.parquet")):
            if row.spoil is not None:
                table = pq.read_table(path)
                write_log(row.spoil({name: table[name].to_numpy() for name in table.column_names}), path)
        if row.off_m:
            _moved(folder / "data" / "model.yaml", row.off_m)
    verdict, seconds = answer_of(folder / "data", folder / "out", LIMIT_S, None)
    verdict["seconds"] = seconds["cpu"]
    (folder / VERDICT_FILE).write_text(json.dumps(verdict, indent=1), encoding="utf-8")
    return verdict


def line_of(row: Row, folder: Path) -> str:
    """One line of the table: row, what is hidden, what was said, whether that is right, processor time."""
    truth = json.loads((folder / TRUTH_FILE).read_text(encoding="utf-8"))
    verdict = json.loads((folder / VERDICT_FILE).read_text(encoding="utf-8"))
    hidden = ", ".join(f"{c['name']}@{c['axis']}" for c in truth["causes"]) or "nothing"
    if row.spoil is not None:
        refused = verdict["verdict"] == "unusable_data" and row.said in verdict["text"]
        said = verdict["text"].replace(f"{folder / 'data'}/", "").replace("\n", " ")
        right = "refused" if refused else "NOT REFUSED"
    else:
        marks = ((one, "" if one["status"] == "named" else "?") for one in verdict["effects"])
        told = ", ".join(f"{one['name']}@{one['axis']}{mark}" for one, mark in marks)
        said = f"`{verdict['verdict']}` {told}".rstrip()
        right = outcome(truth, verdict).value
    return f"| {row.name} | {hidden} | {said} | {right} | {verdict['seconds']:.0f} |"


def main() -> None:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--rows", default="*", help="pattern of names")
    parser.add_argument("--table", action="store_true", help="only print what has been asked")
    chosen = parser.parse_args()
    print("| row | hidden | said | that is | processor, s |\n|---|---|---|---|---|")
    for row in rows():
        folder = chosen.folder / row.name
        if not fnmatch(row.name, chosen.rows):
            continue
        if not chosen.table and not (folder / VERDICT_FILE).exists():
            ask(row, chosen.seed, folder)
        if (folder / VERDICT_FILE).exists():
            print(line_of(row, folder), flush=True)


if __name__ == "__main__":
    main()
