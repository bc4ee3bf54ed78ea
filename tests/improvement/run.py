"""Improve antennas with hidden effects: `python -m tests.improvement.run --antennas 10 --out DIR [--off 0.08] [--first
SEED]`.

Each antenna has two effects drawn from a seed; the improvement is a process of its own that is given the configuration
and the shipped model alone. Afterwards the model that it leaves is judged on a motion that it has never run. An antenna
whose folder holds a result is not run again.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

from sim_backend.model import AntennaModel, load_model, shipped_model
from tests.improvement.antennas import configuration, draw, judged

#: the floor counts as reached below this
REACHED_FLOORS = 1.5
HEADER = ("antenna", "hidden (floors alone)", "start", "end", "ending", "named", "rounds, runs, antenna time", "wall")


def improved(folder: Path, antenna: AntennaModel, words: list[str]) -> dict[str, Any]:
    """Run `gimbal-hil improve` on an antenna as a user would; answers its improve.json with the wall time."""
    config = configuration(folder, antenna)
    command = [
        sys.executable,
        "-c",
        "from gimbal_hil.surface.cli import main; main()",
        "improve",
        "--config",
        str(config),
    ]
    began = time.monotonic()
    with (folder / "log.txt").open("w") as log:
        subprocess.run([*command, "--out", str(folder / "out"), "--force", *words], stdout=log, stderr=log, check=False)
    if not (folder / "out" / "improve.json").exists():
        raise RuntimeError((folder / "log.txt").read_text()[-2000:])
    record: dict[str, Any] = json.loads((folder / "out" / "improve.json").read_text())
    return record | {"wall_s": time.monotonic() - began}


def one(folder: Path, seed: int, off: float, words: list[str]) -> dict[str, Any]:
    """Draw, improve, judge one antenna; what was there already is taken as it is."""
    result = folder / "result.json"
    if result.exists():
        known: dict[str, Any] = json.loads(result.read_text())
        return known
    antenna = draw(seed, off=off)
    record = improved(folder, antenna.model, words)
    start_gap = judged(antenna.model, shipped_model())
    end_gap = judged(antenna.model, load_model(folder / "out" / "model.yaml"))
    effects = [e for one in record["rounds"] if one["model"] for e in one["effects"]]
    found = {
        "seed": seed,
        "hidden": [
            {"name": h.name, "axis": h.axis, "floors": h.floors, "parameters": h.parameters} for h in antenna.hidden
        ],
        "start_floors": start_gap,
        "end_floors": end_gap,
        "ending": record["ending"],
        "text": record["text"],
        "named": [{"name": e["name"], "axis": e["axis"], "status": e["status"]} for e in effects],
        "rounds": len(record["rounds"]),
        "runs": sum(
            1 for line in (folder / "out" / "journal.jsonl").read_text().splitlines() if '"kind": "measured"' in line
        ),
        "antenna_s": record["antenna_s"],
        "wall_s": record["wall_s"],
    }
    result.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    return found


def row(found: dict[str, Any]) -> str:
    """One line of the table."""
    hidden = ", ".join(f"{h['name']} {h['axis']} ({h['floors']:.0f})" for h in found["hidden"])
    named = ", ".join(dict.fromkeys(f"{e['name']} {e['axis']}" for e in found["named"])) or "nothing"
    used = f"{found['rounds']}, {found['runs']}, {found['antenna_s']:.0f} s"
    cells = (
        str(found["seed"]), hidden, f"{found['start_floors']:.1f}", f"{found['end_floors']:.2f}",
        found["ending"].replace("_", " "), named,
        used, f"{found['wall_s']:.0f} s",
    )  # fmt: skip
    return "| " + " | ".join(cells) + " |"


def main() -> None:
    """Improve the antennas one after the other and print the table as it grows."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--antennas", type=int, default=10)
    parser.add_argument("--first", type=int, default=1, help="seed of the first antenna")
    parser.add_argument("--off", type=float, default=0.0, help="known numbers are off by up to this share")
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--workers", type=int, default=2)
    chosen = parser.parse_args()
    words = ["--short", "--workers", str(chosen.workers)]
    print("| " + " | ".join(HEADER) + " |\n|" + "---|" * len(HEADER), flush=True)
    results = []
    for seed in range(chosen.first, chosen.first + chosen.antennas):
        results.append(one(chosen.out / f"antenna_{seed}", seed, chosen.off, words))
        print(row(results[-1]), flush=True)
    reached = [r for r in results if r["end_floors"] <= REACHED_FLOORS]
    ended = sum(r["ending"] == "at_the_floor" for r in reached)
    print(f"\nat the noise floor: {len(reached)} of {len(results)} ({ended} of them say so)")


if __name__ == "__main__":
    main()
