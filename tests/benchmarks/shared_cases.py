"""`check`, `identify` and `discrepancy` on every input of a folder of cases, held against what was put into each.

The folder has `logs/` with a joint of its own (`rig.py`), the model that a stranger writes for it, and cases that a
`make.py` of theirs writes (`make_text_08_to_12.py` those of 08 to 12). Tables of pandas and recordings of a bus with
floats (case 16 of `dbc/`) are written here.

    python -m tests.benchmarks.shared_cases FOLDER --out answers.jsonl [--only '02-*'] [--commands identify]

A line of JSON an input and command: exit code, verdict, headline, seconds, and what of it is wrong: a traceback, a name
that is not the cause, an all-clear beside a cause, a number that is called known beside the truth, a refusal of what
can be read. Finished lines stay in the file and are not made again; what was wrong is printed at the end.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import os
import shutil
import struct
import subprocess
import sys
import time
import traceback
from collections.abc import Iterator
from dataclasses import dataclass
from fnmatch import fnmatch
from pathlib import Path
from typing import Any

import numpy as np

from gimbal_hil.surface.cli.app import run

#: what rig.py moves by; its model says a Coulomb level of 0.04
TRUE = {"inertia": 0.02, "coulomb": 0.05, "viscous": 0.02, "offset": 0.0, "order": 7.0}
#: amplitude of the cogging that its model lacks, by input
COGGING = (("01-*_cog_*", 0.1), ("02-*_cog_*", 0.01), ("02-*_big_*", 0.05), ("03-*", 0.05), ("12-*_cog*", 0.05))
#: words for --column, and other options
_OURS = "time_s={} joint.position={} joint.torque={}"
READ = (
    ("01-*whole.csv", _OURS.format("time", "enc:turn/8192", "tau"), ""),
    ("01-*", _OURS.format("time", "enc:turn/20480", "tau"), ""),
    ("03-*", _OURS.format("t", "present_position:turn/4096", "present_current:0.004842*N m"), ""),
    ("04-*run6.csv", "", "--rate 500"),
    ("04-*run7.csv", "", "--rate 500"),
    ("04-*two_decimals_1k.csv", "", "--rate 500"),
    ("06-*ros1.csv", _OURS.format("%time:ns", "field.position0", "field.effort0"), ""),
    ("06-*noheader.csv", _OURS.format("1:s+2:ns", "3", "4"), ""),
    ("06-*", _OURS.format("header.stamp.sec+header.stamp.nanosec", "position[0]", "effort[0]"), ""),
    ("08-*dup.csv", _OURS.format("time", "q_d[3]#2", "tau"), ""),
    ("08-*", _OURS.format("time", "q", "tau"), ""),
    ("09-*", _OURS.format("Zeit [s]:s", "Winkel [°]:°", "Moment [N·m]:N·m"), ""),
    ("10-*us_thousands.tsv", _OURS.format("time_us:us", "counts:turn/65536", "torque_mNm:mNm"), ""),
    ("10-*start_1000.tsv", _OURS.format("time_us:us", "counts:turn/65536", "torque_mNm:mNm"), ""),
    ("10-*quoted_thousands.csv", _OURS.format("time_us:us", "counts:turn/65536", "torque_mNm:mNm"), ""),
    ("10-*de_thousands.csv", _OURS.format("time_ms:ms", "counts:turn/65536", "torque_mNm:mNm"), ""),
    ("10-*de_first_int.csv", _OURS.format("time_ms:ms", "deg:deg", "torque_mNm:mNm"), ""),
    ("10-*comma_in_header.csv", _OURS.format("Zeit, ms:ms", "Winkel, deg:deg", "Moment, mNm:mNm"), ""),
    ("10-*comma_comma.csv", _OURS.format("time_s", "deg:deg", "mNm:mNm"), ""),
    ("18-*.json", "joint.position=entries.position joint.torque=entries.torque", ""),
    ("18-*.jsonl", _OURS.format("t", "q", "u"), ""),
    ("18-*flat.mat", _OURS.format("t", "y", "u"), ""),
    ("18-*noheader.csv", _OURS.format("1", "2", "3"), ""),
    ("18-*simplefoc.txt", "joint.position=4 joint.torque=2", "--rate 500"),
    ("16-*", "joint.position=Status.Angle joint.torque=Status.Torque", ""),
)
#: inputs that have to be read, without a repair, whatever else holds for them
SOUND = (
    "01-*truth.csv", "01-*whole.csv", "01-*/big2_cog_int16.csv", "02-*_0_far.csv", "02-*_0_near.csv",
    "02-*b_cog_clean.csv", "03-*_signed.csv", "06-*", "08-*dup_unused.csv", "08-*two_blank.csv", "09-*utf8.csv",
    "09-*cp1252.csv",
    "09-*utf16.csv", "09-*bom.csv", "09-*crlf.csv", "11-*base.csv", "11-*preamble.csv", "11-*units_row.csv",
    "12-*cog.csv", "12-*plain.csv", "16-*floats.log", "18-*.csv.gz", "18-*a.json", "20-*timedelta*", "20-*datetime*",
    "20-*rec.np?",
)  # fmt: skip
#: inputs that no person can read as they are, with or without a repair
UNSOUND = (
    "01-*/int16.csv", "01-*/big_cog_int16.csv", "01-*uint32.csv", "01-*reset.csv", "01-*motor*",
    "03-*a_unsigned.csv", "03-*b_unsigned.csv", "16-*far.log",
    "18-*a.xlsx", "18-*empty.csv",
)  # fmt: skip
#: a hold-out, by input
HOLDOUTS = (
    ("01-*/big_cog_*", "big2_cog_{rest}"),
    ("02-*/a_cog_*", "b_cog_clean.csv"),
    ("02-*/a_big_*", "b_big_0_far.csv"),
    ("02-*/b_big_*", "a_big_0_far.csv"),
    ("03-*/a_*", "b_{rest}"),
    ("12-*/a_cog*", "b_cog.csv"),
    ("12-*/a_plain*", "b_plain.csv"),
)
#: names that are the cause or say no more than what is assumed of bristles, which this rig has not
FITTING = {"coulomb", "presliding", "stribeck"}
COMMANDS = ("check", "identify", "discrepancy")
_DBC = """VERSION ""
NS_ :
BS_:
BU_: X
BO_ 272 Status: 8 X
 SG_ Angle : 0|32@1- (1,0) [0|0] "rad" X
 SG_ Torque : 32|32@1- (1,0) [0|0] "N m" X
SIG_VALTYPE_ 272 Angle : 1;
SIG_VALTYPE_ 272 Torque : 1;
"""
_NO_ANGLES = {"far": 1e30, "nan": np.nan}
Answer = dict[str, Any]


@dataclass(frozen=True)
class Case:
    """One input: where it lies, and its name as `folder/file`."""

    path: Path

    @property
    def name(self) -> str:
        return f"{self.path.parent.name}/{self.path.name}"

    @property
    def cogging(self) -> float:
        return next((size for pattern, size in COGGING if fnmatch(self.name, pattern)), 0.0)

    def is_any_of(self, patterns: tuple[str, ...]) -> bool:
        return any(fnmatch(self.name, pattern) for pattern in patterns)

    def words(self) -> tuple[list[str], list[str]]:
        """What follows --column, and other options of reading."""
        for pattern, columns, options in READ:
            if fnmatch(self.name, pattern):
                found = columns.replace(" joint.", "\0joint.").split("\0")
                return (["--column", *found] if columns else []), options.split()
        return [], []

    def holdout(self) -> list[str]:
        for pattern, other in HOLDOUTS:
            if fnmatch(self.name, pattern):
                rest = self.path.name.split("_")[-1]
                return ["--holdout", str(self.path.with_name(other.format(rest=rest)))]
        return []


def written(folder: Path, into: Path) -> list[Case]:
    """All inputs, written where they are not yet."""
    logs = into / "logs"
    if not logs.exists():
        shutil.copytree(folder / "logs", logs)
        environment = {**os.environ, "PYTHONPATH": str(logs)}
        for script in sorted(logs.glob("*/make*.py")):
            subprocess.run([sys.executable, script.name], cwd=script.parent, env=environment, check=True)
        texts = "make_text_08_to_12.py"
        (logs / "10-thousands-and-commas").mkdir(exist_ok=True)
        # its script goes to a folder of cases beside its own
        (into / "cases").symlink_to(logs.resolve())
        subprocess.run([sys.executable, texts], cwd=logs, env=environment, check=True)
        _of_pandas(logs)
        _of_a_bus(logs)
    inputs = sorted(path for path in logs.glob("[0-9][0-9]-*/*") if _is_input(path))
    return [Case(path) for path in inputs]


def _is_input(path: Path) -> bool:
    return path.suffix not in (".py", ".md", ".dbc", ".yaml") and path.is_file()


def _rig(logs: Path) -> dict[str, np.ndarray]:
    """A log of the cases' own joint."""
    script = "import numpy, rig, sys; numpy.savez(sys.argv[1], **rig.log('a', seed=1, cog=False))"
    subprocess.run([sys.executable, "-c", script, "rig.npz"], cwd=logs, check=True)
    with np.load(logs / "rig.npz") as log:
        return dict(log)


def _of_pandas(logs: Path) -> None:
    """Tables as people who use pandas leave them."""
    import pandas as pd

    folder, log = logs / "20-pandas-habits", _rig(logs)
    base = pd.DataFrame({"time_s": log["t"], "joint.torque": log["tau"], "joint.position": log["q"]})
    since = pd.to_timedelta(log["t"], unit="s")
    for name, stamps in (("timedelta", since), ("datetime", pd.Timestamp("2024-01-01") + since)):
        table = base.assign(time_s=stamps)
        table.to_parquet(folder / f"{name}.parquet")
        table.to_csv(folder / f"{name}.csv", index=False)
        rest = {key: np.asarray(base[key]) for key in ("joint.torque", "joint.position")}
        np.savez(folder / f"{name}.npz", **{"time_s": np.asarray(stamps)}, **rest)
    base.set_index("time_s").to_parquet(folder / "index.parquet")
    base.astype("float32").to_parquet(folder / "float32.parquet")
    record = np.rec.fromarrays([log["t"], log["tau"], log["q"]], names="time_s,joint.torque,joint.position")
    np.savez(folder / "rec.npz", record)
    np.save(folder / "rec.npy", record)


def _of_a_bus(logs: Path) -> None:
    """Candumps of floats: sound, not finite, far beyond any place, and decoded as whole numbers."""
    log = _rig(logs)
    for kind, dbc in (("floats", _DBC), ("far", _DBC), ("nan", _DBC), ("whole", _DBC.partition("SIG_VALTYPE_")[0])):
        folder = logs / f"16-dbc-float-nan-{kind}"
        folder.mkdir()
        (folder / f"{kind}.dbc").write_text(dbc)
        angle = log["q"].copy()
        if kind in _NO_ANGLES:
            angle[1000:1003] = _NO_ANGLES[kind]
        rows = (
            f"({1_700_000_000 + t:.6f}) can0 110#{struct.pack('<ff', q, u).hex().upper()}"
            for t, q, u in zip(log["t"], angle, log["tau"], strict=True)
        )
        (folder / f"{kind}.log").write_text("\n".join(rows) + "\n")


def asked(case: Case, command: str, repair: bool = False) -> Answer:
    """One command on one input."""
    columns, options = case.words()
    model, out = str(case.path.parent.parent / "model.yaml"), case.path.parent / f"{case.path.name}.{command}"
    options = [*options, *(["--repair"] if repair else [])]
    words = {
        "check": [str(case.path), model, *columns, *options],
        "identify": [str(case.path), "--model", model, "--out", str(out), "--force", "--workers", "1", *options],
        "discrepancy": ["--model", model, "--measured", str(case.path), *case.holdout(), "--out", str(out), "--force",
                        "--workers", "1", *options],
    }[command]  # fmt: skip
    said, begun = io.StringIO(), time.monotonic()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
        try:
            code = run(command, [*words, *(columns if command != "check" else [])])
        except SystemExit as ended:
            code = int(ended.code or 0)
        except BaseException as error:
            if isinstance(error, KeyboardInterrupt):
                raise
            traceback.print_exc()
            code = -1
    lines = [line for line in said.getvalue().splitlines() if line.strip()]
    verdict, numbers = _verdict(command, code, out)
    return {
        "case": case.name, "command": command, "repair": repair, "exit": code, "verdict": verdict,
        "headline": lines[-1 if code == -1 else 0][:400] if lines else "", "numbers": numbers,
        "wrong": list(_wrong(case, command, code, verdict, numbers)), "seconds": round(time.monotonic() - begun, 2),
    }  # fmt: skip


def _verdict(command: str, code: int, out: Path) -> tuple[str, dict[str, list[float]]]:
    """A word for the answer, and the numbers that it states with their intervals."""
    if code not in (0, 1) or command == "check":
        return {0: "good", 1: "wrong", 2: "refused", -1: "traceback"}.get(code, "?"), {}
    if command == "identify":
        (axis,) = json.loads((out / "identification.json").read_text())["axes"]
        known = [one for one in axis["estimates"] if one["verdict"] == "identified"]
        return "identified" if known else "nothing", {
            one["name"]: [one["value"], one["low"], one["high"]] for one in known
        }
    document = json.loads((out / "verdict.json").read_text())
    return document["verdict"], {
        f"{effect['name']}.{name}": [number["value"], number["low"], number["high"]]
        for effect in document["effects"]
        for name, number in effect["parameters"].items()
        if effect["status"] == "named"
    }


def _wrong(case: Case, command: str, code: int, verdict: str, numbers: dict[str, list[float]]) -> Iterator[str]:
    if code not in (0, 1, 2):
        yield "traceback"
    is_read = verdict not in ("refused", "wrong")
    if case.is_any_of(SOUND) and not is_read:
        yield "refused, and can be read"
    if case.is_any_of(UNSOUND) and is_read:
        yield "read, and cannot be"
    if command == "discrepancy" and verdict == "no_discrepancy":
        yield "all-clear beside a Coulomb level that is 25 % off"
    true = TRUE | {"amplitude": case.cogging}
    for name, (value, low, high) in numbers.items():
        effect, _, parameter = name.rpartition(".")
        if effect and effect not in FITTING | ({"cogging"} if case.cogging else set()):
            yield f"names {effect}"
        truth = true.get(parameter)
        if truth is not None and not (_at_least(truth, low) and _at_least(high, truth)):
            yield f"{name} {value:.5g} ({low:.5g} to {high:.5g}) where {truth:g} is true"


def _at_least(number: float | None, other: float | None) -> bool:
    return number is None or other is None or number >= other


def main() -> None:
    """Asks what is not in the file yet, then prints what was wrong."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--out", type=Path, default=Path("shared_cases.jsonl"))
    parser.add_argument("--inputs", type=Path, help="where inputs are written; else beside --out")
    parser.add_argument("--only", default="*", help="of `folder/file`")
    parser.add_argument("--commands", nargs="*", default=list(COMMANDS), choices=COMMANDS)
    asking = parser.parse_args()
    cases = written(asking.folder, asking.inputs or asking.out.with_suffix(".inputs"))
    done = [json.loads(line) for line in asking.out.read_text().splitlines()] if asking.out.exists() else []
    have = {(one["case"], one["command"], one["repair"]) for one in done}
    for case in cases:
        for command in asking.commands:
            repair = False
            while fnmatch(case.name, asking.only) and (case.name, command, repair) not in have:
                done.append(asked(case, command, repair))
                have.add((case.name, command, repair))
                with asking.out.open("a") as file:
                    file.write(json.dumps(done[-1]) + "\n")
                # what a refusal offers is tried too
                repair = "--repair makes them up" in done[-1]["headline"] and command != "check"
    wrong = [one for one in done if one["wrong"]]
    for one in wrong:
        print(one["case"], one["command"], "--repair" if one["repair"] else "", one["verdict"], "; ".join(one["wrong"]))
    print(f"{len(cases)} inputs, {len(done)} answers, {len(wrong)} wrong")


if __name__ == "__main__":
    main()
