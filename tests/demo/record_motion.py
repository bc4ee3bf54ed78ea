"""Makes the motion that `gimbal-hil demo` shows while it computes: `python -m tests.demo.record_motion REPORT`.

The report is that of an earlier run of it.
"""

from __future__ import annotations

import gzip
import json
import re
import sys
from pathlib import Path

from gimbal_hil.pages.report import EARLIER_DEMO

#: one row in so many: the player draws straight lines between them
_EVERY = 2


def recorded(report: Path) -> bytes:
    """The moving antenna of a report, thinned and packed; the same bytes for the same report."""
    (data,) = re.findall(r'<script type="application/json">(.*?)</script>', report.read_text(encoding="utf-8"))
    told = json.loads(data)
    told["time_s"] = told["time_s"][::_EVERY]
    told["measured"] = [column[::_EVERY] for column in told["measured"]]
    for model in told["models"]:
        model["position"] = [column[::_EVERY] for column in model["position"]]
    return gzip.compress(json.dumps(told, separators=(",", ":")).encode(), mtime=0)


if __name__ == "__main__":
    EARLIER_DEMO.write_bytes(recorded(Path(sys.argv[1])))
