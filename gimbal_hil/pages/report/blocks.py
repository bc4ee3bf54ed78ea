"""The blocks of a report page: frozen records without any HTML."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from gimbal_hil.pages.plots import Drawing


@dataclass(frozen=True)
class Heading:
    """A section heading; it also becomes an entry of the page's table of contents."""

    text: str


@dataclass(frozen=True)
class Text:
    """A paragraph of plain words."""

    text: str


@dataclass(frozen=True)
class Callout:
    """What matters, set apart, a line for each thing; tone is 'good', 'warning', 'bad' or 'neutral'. `more` is read by
    who wants to know how it is known.
    """

    text: str
    tone: str = "neutral"
    more: str = ""


@dataclass(frozen=True)
class Tiles:
    """A row of key figures: (value with unit, what it is)."""

    items: Sequence[tuple[str, str]]


@dataclass(frozen=True)
class Table:
    """A table; the first column is text, numbers are set right. `caption` says what one sees."""

    header: Sequence[str]
    rows: Sequence[Sequence[str]]
    caption: str = ""


@dataclass(frozen=True)
class Plot:
    """A figure with a caption that says what one sees."""

    figure: Drawing
    caption: str = ""


@dataclass(frozen=True)
class ModelMotion:
    """How a model moved: its name in words, and positions of both axes, rad, each as long as the motion's times."""

    name: str
    position: Sequence[Sequence[float]]


@dataclass(frozen=True)
class MovingAntenna:
    """A recorded motion of the antenna in three dimensions, with the ghosts of one or more models beside it.

    `names` of both axes, the carrying one first; times in s; positions in rad, one column an axis. The page plays the
    first half with the ghost of the first model and then changes to the last one.
    """

    title: str
    names: tuple[str, str]
    time_s: Sequence[float]
    measured: Sequence[Sequence[float]]
    models: Sequence[ModelMotion]
    caption: str = ""


@dataclass(frozen=True)
class Listing:
    """Preformatted text: a file, a difference, a log."""

    text: str
    caption: str = ""


@dataclass(frozen=True)
class Details:
    """Blocks that are folded away until one asks for them."""

    summary: str
    blocks: Sequence[Block]


Block = Heading | Text | Callout | Tiles | Table | Plot | MovingAntenna | Listing | Details


def blocks_in(blocks: Sequence[Block]) -> Iterator[Block]:
    """Every block in the order of the page, those that are folded away too."""
    for block in blocks:
        yield block
        if isinstance(block, Details):
            yield from blocks_in(block.blocks)


def plots_in(blocks: Sequence[Block]) -> Iterator[Plot]:
    """Every plot in the order of the page, those that are folded away too."""
    return (block for block in blocks_in(blocks) if isinstance(block, Plot))
