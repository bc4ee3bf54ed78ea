"""The bench's results as one HTML page: figures beside targets, the reliability diagram, outcomes, what went wrong."""

from __future__ import annotations

from pathlib import Path

from gimbal_hil.pages.plots import figure
from gimbal_hil.pages.report import Block, Details, Heading, Page, Plot, Table
from tests.blind.figures import Bin, CaseResult, class_reliability, reliability
from tests.blind.tally import (
    TOLD_CLASSES,
    TOLD_NAMES,
    gone_wrong,
    outcome_groups,
    outcome_rows,
    reliability_rows,
    targets,
    told_of,
)


def _diagram(named: list[Bin], classes: list[Bin]) -> Plot:
    picture = figure("Reliability of what is told", "told probability", "share that is right")
    picture.add_scatter(x=[0, 1], y=[0, 1], mode="lines", line={"dash": "dot"}, name="as told")
    for name, bins in (("names", named), ("classes", classes)):
        above, below = (
            [b.right.interval[1] - b.right.value for b in bins],
            [b.right.value - b.right.interval[0] for b in bins],
        )
        picture.add_scatter(
            x=[b.told for b in bins], y=[b.right.value for b in bins], mode="lines+markers", name=name,
            text=[f"{b.right.part} of {b.right.whole}" for b in bins],
            error_y={"type": "data", "symmetric": False, "array": above, "arrayminus": below},
        )  # fmt: skip
    return Plot(
        picture,
        "Told probability of each name (and of each class) against the share that is right, with 95 % intervals.",
    )


def write_page(cases: list[CaseResult], seed: int, sealed: str | None, path: Path) -> Path:
    """Write the page; answers its path."""
    blocks: list[Block] = [
        Heading("Figures"),
        Table(("figure", "target", "reached"), targets(cases)),
        Heading("Reliability"),
    ]
    named, classes = reliability(cases), class_reliability(cases)
    blocks.append(_diagram(named, classes))
    for title, bins in ((TOLD_NAMES, named), (TOLD_CLASSES, classes)):
        if bins:
            blocks.append(Table((title, "mean told", "right", "95 % interval"), reliability_rows(bins)))
    blocks.append(Heading("Outcomes"))
    for title, groups in outcome_groups(cases):
        if any(found for _, found in groups):
            header, rows = outcome_rows(groups)
            blocks.append(Details(title, [Table((title, *header), rows)]))
    blocks += [Heading("Gone wrong"), Table(("case", "hidden (floors)", "said", "gap in floors"), gone_wrong(cases))]
    return Page("Blind bench", told_of(cases, seed, sealed), blocks).write(path)
