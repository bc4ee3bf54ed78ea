"""A Dask cluster of two worker processes on the loopback address, for tests."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

START = """
from distributed import LocalCluster
if __name__ == "__main__":
    cluster = LocalCluster(n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=None,
                           local_directory={folder!r})
    print(cluster.scheduler_address, flush=True)
    input()
"""


@contextmanager
def local_cluster(folder: Path) -> Iterator[str]:
    """Address of a scheduler in a process of its own, as a cluster is met in the field; gone when the block ends."""
    script = folder / "cluster.py"
    script.write_text(START.format(folder=str(folder)), encoding="utf-8")
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
    process = subprocess.Popen(
        [sys.executable, str(script)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment
    )
    try:
        assert process.stdout is not None and process.stdin is not None
        yield process.stdout.readline().strip()
    finally:
        process.communicate("\n", timeout=60.0)
