"""The results page of a soak, in lockstep or across processes."""

from __future__ import annotations

from collections.abc import Sequence

from gimbal_hil.pages.report import Block, Callout, Heading, Text
from gimbal_hil.proof.bench.soak import WRONG


def soak_blocks(text: str, problems: Sequence[str]) -> list[Block]:
    """Whether all was right, and what was seen; `text` is what the terminal gets."""
    first, *seen = [line.replace("_", " ") for line in text.splitlines() if not line.startswith(WRONG)]
    wrong = [f"{problem[:1].upper()}{problem[1:]}." for problem in problems]
    answer = (
        Callout("\n".join(wrong), "bad", f"{first}.") if wrong else Callout(f"Nothing was wrong in {first}.", "good")
    )
    return [answer, Heading("What was seen"), *(Text(f"{line[:1].upper()}{line[1:]}.") for line in seen)]
