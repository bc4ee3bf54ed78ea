"""Options of every command that reads logs of other people, and of those that search in them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from gimbal_hil.data.signals import LogReading
    from gimbal_hil.surface.library import SearchScope

COLUMN_PAIR = "NAME=COLUMN[@TIME][:UNIT]"
COLUMN_HELP = (
    "A column of your own files and its unit, as in azimuth.position=theta:deg; -deg mirrors it; may be repeated."
)


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

    @property
    def repairs(self) -> dict[str, object]:
        """The options other than columns, for a command that reads the same logs."""
        rate = None if self.rate is None else f"{self.rate:g}"
        return {"resample": self.resample, "rate": rate, "drop_invalid": self.drop_invalid, "repair": self.repair}

    def reading(self) -> LogReading:
        """The same for whoever reads logs; BadInputError for words that name no column."""
        from gimbal_hil.data.signals import ColumnMap, LogReading

        return LogReading(ColumnMap.of_words(self.column), self.resample, self.rate, self.drop_invalid, self.repair)


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

    @property
    def limited(self) -> bool:
        """Whether some effects alone are searched."""
        return bool(self.only or self.without)

    @property
    def of_all(self) -> dict[str, object]:
        """The other options, for a command that searches all."""
        return {"band": None if self.band is None else f"{self.band:g}"}

    def scope(self) -> SearchScope:
        """The same for the search."""
        from gimbal_hil.surface.library import SearchScope

        return SearchScope(tuple(self.only or ()), tuple(self.without or ()), self.band)
