"""What a bench hands to `gimbal-hil bench`, which prints and keeps it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from gimbal_hil.pages.report import Block


class BenchFindings(NamedTuple):
    """Words of the command line, text for the terminal, figures for JSON, blocks of the page; and by name what is
    kept in the history: costs, larger where something is slower.
    """

    words: str
    text: str
    figures: Any
    blocks: list[Block]
    costs: Mapping[str, float] = {}
    #: configuration that is looked at next; None without one
    config: Path | None = None
    #: command that looks closer where a target was missed; empty where that is the machine's doing
    closer: str = ""
