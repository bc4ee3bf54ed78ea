"""The error tree of the whole project: every error a person may see is one of these."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

EXIT_DONE, EXIT_NO, EXIT_BAD_INPUT, EXIT_SAFETY_STOP, EXIT_INTERRUPTED = 0, 1, 2, 3, 130
#: characters of what was handed in that an error quotes
_LONGEST = 600


class GimbalHilError(Exception):
    """Base of every error that ends in one clear line; `exit_code` is what the command answers."""

    exit_code = EXIT_BAD_INPUT


class BadInputError(GimbalHilError):
    """Input was refused: `where` names file and key, `expected` says what would have been accepted.

    `others` are what else is wrong with the same document, as far as it was looked at.
    """

    def __init__(self, where: str, problem: str, expected: str = "", others: Sequence[BadInputError] = ()) -> None:
        self.where, self.problem, self.expected = _one_line(where), _one_line(problem), expected
        self.others = tuple(others)
        super().__init__(f"{self.where}: {self.problem}" + (f"; expected {expected}" if expected else ""))

    def __reduce__(self) -> tuple[type[BadInputError], tuple[str, str, str, tuple[BadInputError, ...]]]:
        # an exception is built anew from its text alone otherwise, which ends the pool that a worker belongs to
        return BadInputError, (self.where, self.problem, self.expected, self.others)

    def below(self, where: str) -> BadInputError:
        """The same refusal, and those beside it, as a part of `where`."""
        others = [other.below(where) for other in self.others]
        return BadInputError(f"{where}: {self.where}", self.problem, self.expected, others)


@contextmanager
def refused_below(where: str) -> Iterator[None]:
    """What is refused within is refused as a part of `where`: the file or key that led to it."""
    try:
        yield
    except BadInputError as refusal:
        raise refusal.below(where) from refusal


def shown(text: str) -> str:
    """What stands in a file, for a terminal: control characters (colours, bells, a cleared screen) as \\xNN."""
    if text.isprintable():
        return text
    return "".join(one if one.isprintable() or one == "\n" else f"\\x{ord(one):02x}" for one in text)


def _one_line(text: str) -> str:
    """What stands in the input may be quoted in an error: in one line, printable, and no longer than a person reads."""
    plain = shown(" ".join(text.encode(errors="replace").decode().split()))
    return plain if len(plain) <= _LONGEST else f"{plain[: _LONGEST // 2]} ... {plain[-_LONGEST // 2 :]}"


class DamagedRunError(GimbalHilError):
    """A recorded run is not what it was when it was recorded: rows are missing or changed, and a result of the rest
    would say less.
    """

    exit_code = EXIT_NO


class LinkError(GimbalHilError):
    """A port or bus could not be opened or has gone: missing device, busy port, unknown interface."""


class SafetyStopError(GimbalHilError):
    """A guard or the antenna itself ended the run; torque is off."""

    exit_code = EXIT_SAFETY_STOP
