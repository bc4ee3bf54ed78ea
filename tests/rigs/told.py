"""What the command says on the measured rigs, beside what is known of them: the table of
docs/measurements/measured-rigs.md.

    GIMBAL_HIL_DATA=... python -m tests.rigs.told FOLDER --rows 'emps*' --table

Each row is one call of `gimbal-hil discrepancy` with a stranger's first model and logs. What has been asked stays in
FOLDER, and a run that was interrupted goes on; `--table` only prints what is there.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from fnmatch import fnmatch
from itertools import combinations
from pathlib import Path
from typing import Any

from gimbal_hil.knowledge.discrepancy import entries_of
from tests.rigs.bam import write_bam
from tests.rigs.dd2dof import write_dd2dof
from tests.rigs.emps import write_emps
from tests.rigs.odrive import FOLDERS, write_odrive
from tests.rigs.rig import Rig

#: seconds after which a call is stopped and the row says so
PATIENCE_S = 900.0


@dataclass(frozen=True)
class Row:
    """One call: its name, the rig on disk, the logs that are fitted and held out, and what is known to be true."""

    name: str
    rig: Rig
    fitted: tuple[str, ...]
    holdout: tuple[str, ...]
    true: str


def rows(folder: Path) -> Iterator[Row]:
    """Every row, its files written below a folder."""
    ripple = "ripple of order 7, 6.5 to 9 mN m, then 14, 28, 12, 36"
    odrive = write_odrive(folder / "odrive")
    for session in FOLDERS:
        # while the neighbouring motor moves the ripple is another
        runs = sorted(name for name in odrive.logs if name.startswith(session + "/") and "crosstalk" not in name)
        for one, other in combinations(runs, 2):
            yield Row(f"odrive {one} to {other.split('/')[1]}", odrive, (one,), (other,), ripple)
    bam = write_bam(folder / "bam")
    unbalance = "static unbalance, 0.44 to 0.59 N m"
    for gain in (100, 200, 400, 800):
        fitted = (f"kp{gain}_sin_sin", f"kp{gain}_sin_time_square")
        yield Row(f"pendulum kp {gain}", bam, fitted, (f"kp{gain}_up_and_down",), unbalance)
    story = "direction-dependent drag, dip towards standstill, ripple of 2.50 mm"
    planted = {
        "as shipped": ((), ""),
        "mass": (("body.mass",), "inertia 95.1 kg, "),
        "viscous": (("friction.viscous",), "viscous 203.5 N s/m, "),
        "coulomb": (("friction.coulomb", "friction.breakaway"), "coulomb 20.4 N, "),
        "offset": (("actuator.offset",), "offset 3.16 N, "),
    }
    for number, (paths, named) in planted.items():
        for factor in (1.0,) if not paths else (0.5, 2.0):
            name = f"emps {number}" + (f" x {factor:g}" if paths else "")
            rig = write_emps(folder / name.replace(" ", "_"), dict.fromkeys(paths, factor))
            yield Row(name, rig, ("DATA_EMPS",), ("DATA_EMPS_PULSES",), named + story)
    arm = write_dd2dof(folder / "dd2dof")
    # one of the second recordings is a copy of the first
    sliding = sorted(name for name in arm.logs if name.startswith("cin") and not name.endswith("exp2"))
    truth = "friction by direction; the published gravity"
    yield Row("arm at constant speeds", arm, tuple(sliding[::2]), tuple(sliding[1::2]), truth)
    ramps = sorted(name for name in arm.logs if name.startswith("est"))
    yield Row("arm in ramps", arm, tuple(ramps[:-1]), (ramps[-1],), truth)
    still = sorted(name for name in arm.logs if name.startswith("sig0"))
    yield Row("arm before it breaks away", arm, tuple(still[:-1]), (still[-1],), "stiffness of the bristle")


def ask(row: Row, out: Path) -> dict[str, Any]:
    """What the command says, with its exit code and seconds of processor time."""
    words = ["discrepancy", "--model", row.rig.model, "--out", out, "--force"]
    for option, names in (("--measured", row.fitted), ("--holdout", row.holdout)):
        for name in names:
            words += [option, row.rig.logs[name]]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    begin = [sys.executable, "-c", "from gimbal_hil.surface.cli import main; main()"]
    command = [*begin, *map(str, words), "--resample"]
    try:
        ended = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S, check=False)
    except subprocess.TimeoutExpired:
        return {"error": f"no answer in {PATIENCE_S:g} s"}
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    said = {"exit": ended.returncode, "cpu_s": after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime}
    if not (out / "verdict.json").exists():
        return said | {"error": ended.stderr.strip().splitlines()[-1] if ended.stderr.strip() else "no verdict"}
    return said | {"verdict": json.loads((out / "verdict.json").read_text(encoding="utf-8"))}


def in_words(said: dict[str, Any]) -> str:
    """One cell: the verdict and its effects with probability and first parameter."""
    if "error" in said:
        return said["error"]
    verdict = said["verdict"]
    effects = [_effect(one) for one in verdict["effects"]]
    rivals = sorted({one["name"] for one in verdict["alternatives"]})
    return (
        f"`{verdict['verdict']}`: "
        + ("; ".join(effects) or "nothing")
        + (f" (or {', '.join(rivals)})" if rivals else "")
    )


def _effect(one: dict[str, Any]) -> str:
    numbers = "; ".join(
        ", ".join(f"{key} {value['value']:.4g} {value['unit']}".rstrip() for key, value in entry.items())
        for entry in entries_of(one)
    )
    known = {"named": "", "ambiguous": "?", "suspected": "??"}[one["status"]]
    return f"{one['name']}{known} {one['probability']:.2f} ({numbers})"


def table(results: dict[str, dict[str, Any]]) -> str:
    """Markdown: data, what was said, what is true, processor time."""
    lines = ["| data | said | true | processor, s |", "|---|---|---|---|"]
    for name, said in results.items():
        lines.append(f"| {name} | {in_words(said)} | {said['true']} | {said.get('cpu_s', float('nan')):.0f} |")
    return "\n".join(lines)


def main() -> None:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--rows", default="*", help="pattern of names")
    parser.add_argument("--table", action="store_true", help="only print what has been asked")
    chosen = parser.parse_args()
    chosen.folder.mkdir(parents=True, exist_ok=True)
    kept = chosen.folder / "told.json"
    results = json.loads(kept.read_text(encoding="utf-8")) if kept.exists() else {}
    if not chosen.table:
        for row in rows(chosen.folder / "files"):
            if row.name in results or not fnmatch(row.name, chosen.rows):
                continue
            out = chosen.folder / "verdicts" / row.name.replace("/", "_").replace(" ", "_")
            results[row.name] = ask(row, out) | {"true": row.true}
            kept.write_text(json.dumps(results, indent=1), encoding="utf-8")
            print(row.name, "|", in_words(results[row.name]), flush=True)
    print(table(results))


if __name__ == "__main__":
    main()
