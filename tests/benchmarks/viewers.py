"""Does the loop feel who looks on? Stretches with and without viewers, turn by turn in one run of one daemon.

`python -m tests.benchmarks.viewers` prints, for each pair of neighbouring stretches, how wake-up latency and misses
compare, and the ratio with its spread: what the machine does otherwise in those minutes meets both alike.
"""

from __future__ import annotations

import argparse
import http.client
import json
import statistics
import tempfile
import threading
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tests.daemon.daemons import RunningDaemon
from tests.daemon.test_adjusting import free_port

Json = dict[str, Any]
#: what a browser asks: five times a second the status with the trace, and the scope
_PAUSE_S = 0.2
_OWN = ("own_computing", "garbage_collection", "bus_wait")


@dataclass(frozen=True)
class Stretch:
    """What one stretch of ticks was like: latency in microseconds."""

    viewers: int
    ticks: int
    p50_us: float
    p99_us: float
    missed_own: int
    missed_machine: int


def measured(pairs: int, stretch_s: float, viewers: int) -> list[tuple[Stretch, Stretch]]:
    """(nobody, viewers) for each pair; which comes first changes from pair to pair."""
    found = []
    with tempfile.TemporaryDirectory() as folder:
        run, port = Path(folder) / "run", free_port()
        words = ("--page", str(port), "--duration", str(60.0 + 3.0 * pairs * stretch_s))
        with RunningDaemon(run, *words) as daemon, daemon.client() as client:
            daemon.until_state(client, "idle")
            swing = {"mode": "position", "shape": "sine", "parameters": [0.0, 0.3, 0.2, 0.0]}
            client.when_ready("segments", segments=[{"outer": swing, "inner": swing}])
            time.sleep(2.0)
            for pair in range(pairs):
                order = (0, viewers) if pair % 2 == 0 else (viewers, 0)
                one, other = (_stretch(port, stretch_s, count) for count in order)
                found.append((one, other) if pair % 2 == 0 else (other, one))
            client.request("shut_down")
            daemon.wait()
    return found


def ratios(pairs: list[tuple[Stretch, Stretch]], figure: str) -> tuple[float, float, float]:
    """Median, least and largest ratio (viewers over nobody) of a figure."""
    found = [getattr(looked, figure) / max(getattr(alone, figure), 1e-3) for alone, looked in pairs]
    return statistics.median(found), min(found), max(found)


def _stretch(port: int, seconds: float, viewers: int) -> Stretch:
    stop = threading.Event()
    crowd = [threading.Thread(target=_look, args=(port, stop)) for _ in range(viewers)]
    for viewer in crowd:
        viewer.start()
    before = _live(port)
    time.sleep(seconds)
    after = _live(port)
    stop.set()
    for viewer in crowd:
        viewer.join()
    counts = dict(map(tuple, after["latency_bins_us"]))
    for bound, count in before["latency_bins_us"]:
        counts[bound] -= count
    missed, missed_before = (one["status"]["statistics"]["missed_by_cause"] for one in (after, before))
    gone = {cause: missed[cause] - missed_before[cause] for cause in missed}
    own = sum(gone[cause] for cause in _OWN)
    ticks = sum(counts.values())
    p50, p99 = (_quantile(counts, share) for share in (0.5, 0.99))
    return Stretch(viewers, ticks, p50, p99, own, sum(gone.values()) - own)


def _quantile(counts: dict[float, int], share: float) -> float:
    wanted, seen = share * sum(counts.values()), 0
    for bound in sorted(counts):
        seen += counts[bound]
        if seen >= wanted:
            return bound
    raise AssertionError("no ticks")


def _look(port: int, stop: threading.Event) -> None:
    since = -1.0
    while not stop.is_set():
        times = _live(port, since)["trace"]["time_s"]
        since = times[-1] if times else since
        _get(port, "/scope.json?have=0")
        stop.wait(_PAUSE_S)


def _live(port: int, since: float = 1e9) -> Json:
    found: Json = json.loads(_get(port, f"/live.json?since={since}"))
    return found


def _get(port: int, path: str) -> bytes:
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=30)
    connection.request("GET", path)
    content = connection.getresponse().read()
    connection.close()
    return content


def main() -> None:
    """Print the table and the ratios."""
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("--pairs", type=int, default=12)
    words.add_argument("--seconds", type=float, default=8.0)
    words.add_argument("--viewers", type=int, default=10)
    asked = words.parse_args()
    pairs = measured(asked.pairs, asked.seconds, asked.viewers)
    print("viewers    ticks  p50 us  p99 us  missed, own  missed, machine")
    for stretch in (one for pair in pairs for one in pair):
        print(
            f"{stretch.viewers:>7}  {stretch.ticks:>7}  {stretch.p50_us:>6.1f}  {stretch.p99_us:>6.1f}  "
            f"{stretch.missed_own:>11}  {stretch.missed_machine:>15}"
        )
    for figure in ("p50_us", "p99_us"):
        median, least, largest = ratios(pairs, figure)
        print(f"{figure}: {asked.viewers} viewers over none {median:.2f} ({least:.2f} to {largest:.2f})")


if __name__ == "__main__":
    main()
