"""Speed of commits beside each other: `python -m tests.benchmarks.compare_commits --folder DIR COMMIT COMMIT ...`.

A process for each commit, in turn in random order, stretches of about 2 ms of processor time, so that all of them see
the same machine. Told is the median of the ratios to the first commit and to the one before, with quartiles and the
95 % interval of the median (bootstrap). Give the first commit twice to see what no change looks like. The first run
compiles each commit.
"""

from __future__ import annotations

import argparse
import io
import os
import random
import subprocess
import sys
import tarfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("config", "firmware_protocol", "gimbal_hil", "sim_backend")
#: run in the commit's own tree: says "ready" and its works, then for each work asked for by name what it took
WORKER = """
import gc, os, sys, time
tree = sys.argv[1]; sys.path.insert(0, tree)
import gimbal_hil; assert gimbal_hil.__file__.startswith(tree), gimbal_hil.__file__
if os.path.exists(os.path.join(tree, "gimbal_hil", "proof")):
    from gimbal_hil.proof.bench import speed
    from gimbal_hil.loop.settings import shipped_settings
else:  # a commit from before the districts
    from gimbal_hil.bench import speed
    from gimbal_hil.settings import shipped_settings
from sim_backend.model import shipped_model
settings, model = shipped_settings(), shipped_model()
def compiled_path(keep, every):
    engine = speed.CompiledPath(settings, model, 1, keep_frames=keep)
    engine.connect(); engine.host.command(speed.work_program(settings))
    return lambda: engine.advance(2000, every=every)
plant = speed.moving_plant(model)
works = {
    "compiled": compiled_path(False, 100), "kept": compiled_path(True, 1), "plant": lambda: (plant(), plant()),
}
gc.collect(); gc.freeze()
for work in works.values():
    for _ in range(10): work()
print("ready", *works, flush=True)
for line in sys.stdin:
    start = time.thread_time(); works[line.strip()](); print(time.thread_time() - start, flush=True)
"""


class Worker:
    """One commit in a process of its own."""

    def __init__(self, commit: str, folder: Path) -> None:
        self.commit, tree = commit, folder.resolve() / commit
        if not tree.exists():
            packed = subprocess.run(
                ["git", "-C", str(ROOT), "archive", commit, *PACKAGES], check=True, capture_output=True
            )
            with tarfile.open(fileobj=io.BytesIO(packed.stdout)) as archive:
                archive.extractall(tree, filter="data")
        words = [sys.executable, "-c", WORKER, str(tree)]
        pipe = subprocess.PIPE
        self._process = subprocess.Popen(words, stdin=pipe, stdout=pipe, text=True, cwd=folder, env=dict(os.environ))
        ready, *self.works = self._line().split()
        assert ready == "ready"

    def _line(self) -> str:
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        if not line:
            raise RuntimeError(f"{self.commit} ended with {self._process.wait()}")
        return line

    def seconds(self, work: str) -> float:
        """Processor time of one stretch of a work, s."""
        assert self._process.stdin is not None
        self._process.stdin.write(work + "\n")
        self._process.stdin.flush()
        return float(self._line())


def told(ratios: NDArray[np.float64], rng: np.random.Generator) -> str:
    """Median, quartiles, and the 95 % interval of the median."""
    low, middle, high = np.quantile(ratios, (0.25, 0.5, 0.75))
    medians = np.median(rng.choice(ratios, (400, len(ratios))), axis=1)
    least, most = np.quantile(medians, (0.025, 0.975))
    return f"{middle:.3f} ({low:.2f} to {high:.2f}; median {least:.3f} to {most:.3f})"


def main(arguments: list[str]) -> int:
    """Compare the commits in the order given."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("commits", nargs="+")
    parser.add_argument("--folder", type=Path, required=True, help="where the commits are laid out, and stay")
    parser.add_argument("--rounds", type=int, default=600)
    chosen = parser.parse_args(arguments)
    chosen.folder.mkdir(parents=True, exist_ok=True)
    workers = [Worker(commit, chosen.folder) for commit in chosen.commits]
    rng = np.random.default_rng(1)
    for work in workers[0].works:
        times = np.zeros((len(workers), chosen.rounds))
        for number in range(chosen.rounds):
            for place in random.sample(range(len(workers)), len(workers)):
                times[place, number] = workers[place].seconds(work)
        for place, worker in enumerate(workers[1:], 1):
            first, before = times[place] / times[0], times[place] / times[place - 1]
            print(f"{work} {worker.commit}: to the first {told(first, rng)}, to the one before {told(before, rng)}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
