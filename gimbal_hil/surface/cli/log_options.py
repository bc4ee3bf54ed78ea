"""Options of every command that reads logs of other people, and of those that search in them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, TypedDict

import typer

if TYPE_CHECKING:
    from gimbal_hil.data.signals import ColumnMap

COLUMN_PAIR = "NAME=COLUMN[@TIME][:UNIT]"
COLUMN_HELP = (
    "A column of your own files and its unit, as in azimuth.position=theta:deg; -deg mirrors it; may be repeated."
)


class LogReading(TypedDict):
    """How logs are read."""

    columns: ColumnMap
    resample: bool
    rate_hz: float | None
    drop_invalid: bool


class SearchScope(TypedDict):
    """What is searched."""

    only: Sequence[str]
    without: Sequence[str]
    band_hz: float | None


@dataclass(frozen=True)
class LogOptions:
    """What the columns of tables are, which rows count, and on which grid they are put."""

    column: Annotated[list[str] | None, typer.Option(metavar=COLUMN_PAIR, help=COLUMN_HELP)] = None
    resample: Annotated[
        bool,
        typer.Option("--resample", help="Accept tables of uneven time or different rates and put all on one grid."),
    ] = False
    rate: Annotated[
        float | None,
        typer.Option(metavar="HZ", help="Rate of that grid; without it that of the slowest log. Implies --resample."),
    ] = None
    drop_invalid: Annotated[
        bool, typer.Option("--drop-invalid", help="Accept tables with invalid rows and drop those.")
    ] = False
    repair: Annotated[
        bool,
        typer.Option(
            "--repair",
            help="Make up rows that no joint can make from their neighbours, 2 % of a log at most, and say which.",
        ),
    ] = False

    def reading(self) -> LogReading:
        """The same as keywords of whoever reads logs; BadInputError for words that name no column."""
        from gimbal_hil.data.signals import ColumnMap

        return LogReading(
            columns=ColumnMap.of_words(self.column),
            resample=self.resample,
            rate_hz=self.rate,
            drop_invalid=self.drop_invalid,
        )


@dataclass(frozen=True)
class SearchOptions:
    """What is searched, and up to which frequency it is scored."""

    band: Annotated[
        float | None,
        typer.Option(metavar="HZ", help="End of the scored band; without it 25 Hz at 1 kHz, less when slower."),
    ] = None
    only: Annotated[
        list[str] | None, typer.Option(metavar="EFFECT", help="Search these effects alone; may be repeated.")
    ] = None
    without: Annotated[list[str] | None, typer.Option(metavar="EFFECT", help="Leave these out; may be repeated.")] = (
        None
    )

    def scope(self) -> SearchScope:
        """The same as keywords of the search."""
        return SearchScope(only=self.only or (), without=self.without or (), band_hz=self.band)
