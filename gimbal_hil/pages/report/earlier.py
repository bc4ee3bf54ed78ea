"""What an earlier run of the demo left, as a page: something to look at while this one computes."""

from __future__ import annotations

import gzip
import json
from pathlib import Path

from gimbal_hil.pages.report.blocks import Callout, ModelMotion, MovingAntenna
from gimbal_hil.pages.report.page import Page

#: the moving antenna of that run (`tests/demo/record_motion.py` makes it)
EARLIER_DEMO = Path(__file__).with_name("static") / "earlier_demo.json.gz"


def earlier_demo(report: str) -> Page:
    """The page; `report` is where that of this run will be."""
    told = json.loads(gzip.decompress(EARLIER_DEMO.read_bytes()))
    outer, inner = told["names"]
    models = [ModelMotion(one["name"], one["position"]) for one in told["models"]]
    caption = (
        "The ghost (orange lines) is a model that is given the torque which the antenna got. It lacks the cogging of a "
        "motor and drifts away; with the cogging that was found it stays on the antenna."
    )
    said = f"Recorded by an earlier run of the demo. What this run does stands in {report} as soon as it is through."
    motion = MovingAntenna(told["title"], (outer, inner), told["time_s"], told["measured"], models, caption)
    return Page("While the demo computes", "recorded, not live", [Callout(said, "neutral"), motion])
