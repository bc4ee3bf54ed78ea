"""The results page of a soak, in lockstep or across processes."""

from __future__ import annotations

from collections.abc import Sequence

from gimbal_hil.pages.report import Block, Callout, Heading, Text
from gimbal_hil.proof.bench.soak import WRONG


def soak_blocks(text: str, problems: Sequence[str]) -> list[Block]:
    """Whether all was right, and what was seen; `text` is what the terminal gets."""
    seen = [line for line in text.splitlines() if not line.startswith(WRONG)]
    wrong = "\n".join(f"{problem[:1].upper()}{problem[1:]}." for problem in problems)
    answer = wrong or f"Nothing was wrong in {seen[0]}."
    return [
        Callout(answer, "bad" if problems else "good"),
        Heading("What was seen"),
        *(Text(f"{line}.") for line in seen),
    ]
