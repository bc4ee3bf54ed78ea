"""The error tree of the whole project: every error a person may see is one of these."""

from __future__ import annotations

EXIT_DONE, EXIT_NO, EXIT_BAD_INPUT, EXIT_SAFETY_STOP, EXIT_INTERRUPTED = 0, 1, 2, 3, 130


class GimbalHilError(Exception):
    """Base of every error that ends in one clear line; `exit_code` is what the command answers."""

    exit_code = EXIT_BAD_INPUT


class BadInputError(GimbalHilError):
    """Input was refused: `where` names file and key, `expected` says what would have been accepted."""

    def __init__(self, where: str, problem: str, expected: str = "") -> None:
        self.where, self.problem, self.expected = where, problem, expected
        super().__init__(f"{where}: {problem}" + (f"; expected {expected}" if expected else ""))


class LinkError(GimbalHilError):
    """A port or bus could not be opened or has gone: missing device, busy port, unknown interface."""


class SafetyStopError(GimbalHilError):
    """A guard or the antenna itself ended the run; torque is off."""

    exit_code = EXIT_SAFETY_STOP
