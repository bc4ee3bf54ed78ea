"""One number of a measured rig's model planted wrong: is it told, honestly not judged, or passed over in silence?

    GIMBAL_HIL_DATA=... python -m tests.rigs.planted FOLDER --factors 0.5,2 --rows 'emps*'

A torque constant is planted in the log: every torque of it times the factor. What has been asked stays in FOLDER.
"""

from __future__ import annotations

import argparse
import csv
import json
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from fnmatch import fnmatch
from pathlib import Path
from typing import Any

from tests.rigs.bam import write_bam
from tests.rigs.dd2dof import write_dd2dof
from tests.rigs.emps import write_emps
from tests.rigs.odrive import write_odrive
from tests.rigs.rig import Rig
from tests.rigs.told import Row, ask, in_words

DRY = ("friction.coulomb", "friction.breakaway")
#: what is planted -> numbers of the model; the torque constant is in the logs
NUMBERS: dict[str, tuple[str, ...]] = {
    "inertia": ("body.inertia.zz",),
    "coulomb": DRY,
    "viscous": ("friction.viscous",),
    "static_unbalance": ("body.cog.y",),
    "torque_gain": (),
}
#: errors of this size matter to whoever closes a loop with the model
PLAIN = ("inertia", "coulomb", "torque_gain")


@dataclass(frozen=True)
class Measured:
    """A rig: who writes it, the logs that are fitted and held out, which numbers its model has."""

    write: Any
    fitted: tuple[str, ...]
    holdout: tuple[str, ...]
    numbers: tuple[str, ...]


RIGS: dict[str, Measured] = {
    "emps": Measured(
        write_emps, ("DATA_EMPS",), ("DATA_EMPS_PULSES",), ("inertia", "coulomb", "viscous", "torque_gain")
    ),
    "odrive": Measured(
        write_odrive, ("slow2/nocomp_0",), ("slow2/nocomp_1",), ("inertia", "coulomb", "viscous", "torque_gain")
    ),
    "bam": Measured(
        write_bam,
        ("kp400_sin_sin", "kp400_sin_time_square"),
        ("kp400_up_and_down",),
        ("inertia", "coulomb", "viscous", "torque_gain"),
    ),
    "dd2dof": Measured(
        write_dd2dof,
        ("cin_05_exp", "cin_n10_exp", "cin_60_exp", "cin_n90_exp"),
        ("cin_10_exp", "cin_n60_exp"),
        ("coulomb", "viscous", "static_unbalance", "torque_gain"),
    ),
}


def rows(folder: Path, factors: tuple[float, ...]) -> Iterator[tuple[Row, str]]:
    """Every row with the effect that is planted in it."""
    for name, rig in RIGS.items():
        for what in rig.numbers:
            paths = ("body.mass",) if (name, what) == ("emps", "inertia") else NUMBERS[what]
            for factor in factors:
                place = folder / f"{name}_{what}_{factor:g}"
                written = rig.write(place, dict.fromkeys(paths, factor))
                if what == "torque_gain":
                    written = _scaled_torque(written, rig.fitted + rig.holdout, factor)
                fitted, holdout = (
                    tuple(one for one in names if one in written.logs) for names in (rig.fitted, rig.holdout)
                )
                yield Row(f"{name} {what} x {factor:g}", written, fitted, holdout, what), what


def _scaled_torque(rig: Rig, names: tuple[str, ...], factor: float) -> Rig:
    for name in names:
        path = rig.logs.get(name)
        if path is None:
            continue
        with path.open(newline="") as file:
            head, *body = list(csv.reader(file))
        column = next(k for k, word in enumerate(head) if word.endswith(".torque"))
        for row in body:
            row[column] = repr(factor * float(row[column]))
        with path.open("w", newline="") as file:
            csv.writer(file).writerows([head, *body])
    return replace(rig)


def judged(said: Mapping[str, Any], what: str) -> str:
    """How an answer stands to what was planted."""
    if "error" in said:
        return "refused or error"
    verdict = said["verdict"]
    named = [one["name"] for one in verdict["effects"] if one["status"] == "named"]
    guessed = [one["name"] for one in verdict["effects"]]
    either = guessed + [one["name"] for one in verdict["alternatives"]]
    # commanded torque never tells a gain from all other numbers
    same = {"viscous": {"viscous", "back_emf", "viscous_asymmetry"}}.get(what, {what})
    kind = verdict["verdict"]
    if kind == "no_discrepancy":
        return "FALSE ALL-CLEAR"
    if kind in ("cannot_judge", "unexplained"):
        return f"honest: {kind}"
    if same & set(named):
        return "right"
    if same & set(either):
        return "class"
    return "named another" if named else "guessed another"


def main() -> None:
    """The command line."""
    reader = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    reader.add_argument("folder", type=Path)
    reader.add_argument("--factors", default="0.5,0.7,1.4,2")
    reader.add_argument("--rows", default="*")
    chosen = reader.parse_args()
    tally: Counter[str] = Counter()
    for row, what in rows(chosen.folder / "files", tuple(float(one) for one in chosen.factors.split(","))):
        if not fnmatch(row.name, chosen.rows):
            continue
        kept = chosen.folder / f"{row.name}.json"
        if not kept.exists():
            kept.write_text(json.dumps(ask(row, chosen.folder / "out" / row.name.replace(" ", "_"))))
        said = json.loads(kept.read_text())
        how = judged(said, what)
        tally[how] += 1
        print(f"{row.name:32} {how:28} {in_words(said)[:140]} ({said.get('cpu_s', 0.0):.0f} s)", flush=True)
    print(dict(tally))


if __name__ == "__main__":
    main()
