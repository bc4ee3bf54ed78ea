"""What earlier benches found, kept beside the page: what became slower is seen without anybody's memory."""

from __future__ import annotations

import json
import statistics
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

from firmware_protocol.version import __version__
from gimbal_hil.knowledge.executor import code_fingerprint
from gimbal_hil.loop.timing import wall_clock_utc

HISTORY_FILE = "history.jsonl"
#: benches that a new one is compared with, and how few make no spread yet
_LAST, _FEWEST = 10, 3


def remember(file: Path, bench: str, costs: Mapping[str, float]) -> list[str]:
    """Append the costs of a bench to its history, and answer what became slower, in words.

    A cost is a number that does not depend on the machine's speed and is larger where something is slower. It has
    become slower when it is above the median of the last benches by more than these differ among themselves.
    """
    earlier = _earlier(file, bench)[-_LAST:]
    slower = []
    for name, cost in costs.items():
        before = [costs_then[name] for costs_then in earlier if name in costs_then]
        if len(before) >= _FEWEST:
            middle, spread = statistics.median(before), max(before) - min(before)
            if cost > middle + spread:
                slower.append(
                    f"{name}: {cost / middle:.2f} times the median of the last {len(before)} benches "
                    f"({min(before) / middle:.2f} to {max(before) / middle:.2f})"
                )
    line = {
        "time": wall_clock_utc()[:19] + "Z",
        "version": __version__,
        "code": code_fingerprint(),
        "bench": bench,
        "costs": dict(costs),
    }
    file.parent.mkdir(parents=True, exist_ok=True)
    with file.open("a", encoding="utf-8") as history:
        history.write(json.dumps(line) + "\n")
    return slower


def _earlier(file: Path, bench: str) -> list[dict[str, float]]:
    """Costs of the benches in the file; a line that was cut off in writing is none."""
    found = []
    for text in file.read_text(encoding="utf-8").splitlines() if file.exists() else ():
        with suppress(json.JSONDecodeError):
            line = json.loads(text)
            if line["bench"] == bench:
                found.append(line["costs"])
    return found
