"""One place where a log and what it should be part ways."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Difference:
    """`tick` is -1 where it belongs to no tick."""

    tick: int
    signal: str
    recorded: str
    expected: str
    reason: str

    def in_words(self) -> str:
        """One line for people."""
        place = f"at tick {self.tick}: " if self.tick >= 0 else ""
        return f"{place}{self.signal} is {self.recorded}, not {self.expected}: {self.reason}"
