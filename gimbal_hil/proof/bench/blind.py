"""The blind bench lives with the tests, because it must share no code with what it tests; this only starts it."""

from __future__ import annotations

import os
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn

from firmware_protocol.errors import BadInputError

_CHECKOUT = Path(__file__).resolve().parents[3]


@dataclass(frozen=True)
class BlindChoice:
    """Which cases of the blind bench are made, where, and what is left of them; None leaves the bench's own default."""

    folder: Path
    seed: int | None = None
    #: a release whose commit the seed belongs to, in place of `seed`
    sealed: str | None = None
    kinds: tuple[str, ...] = ()
    #: names like this pattern
    cases: str | None = None
    #: at most so many cases of a kind, so many in all
    most: int | None = None
    first: int | None = None
    workers: int = 2
    dask: str | None = None
    #: whose logs and reports stay on disk: wrong, all, none
    keep: str = "wrong"
    #: only print the tables of what has been judged, or only what differs from the results in this folder
    table: bool = False
    compare: Path | None = None

    def words(self) -> list[str]:
        """The choice as the bench's own command line."""
        options: dict[str, object] = {
            "--seed": self.seed,
            "--sealed": self.sealed,
            "--kinds": ",".join(self.kinds) or None,
            "--cases": self.cases,
            "--most": self.most,
            "--first": self.first,
            "--workers": self.workers,
            "--dask": self.dask,
            "--keep": self.keep,
            "--compare": None if self.compare is None else self.compare.resolve(),
        }
        given = [word for name, value in options.items() if value is not None for word in (name, str(value))]
        return [str(self.folder.resolve()), *given, *(["--table"] if self.table else [])]


def run_blind(choice: BlindChoice) -> NoReturn:
    """Draw, run the shipped command, and score.

    This process becomes the bench: its exit code is the bench's, and what ends the one ends the other. Raises
    BadInputError where the bench is not there.
    """
    if not (_CHECKOUT / "tests" / "blind" / "run.py").exists():
        raise BadInputError(
            "bench blind",
            "is not part of the installed package",
            "a source checkout (its generator lies in tests/blind)",
        )
    # paths are meant from where the command was given
    words = [sys.executable, "-m", "tests.blind.run", *choice.words()]
    sys.stdout.flush()
    os.chdir(_CHECKOUT)
    os.execv(sys.executable, words)
