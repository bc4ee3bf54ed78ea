"""What drives say on a bus, by name, and what is told of one that does not say it: for whoever has to find out why
nothing moves.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol, runtime_checkable

from firmware_protocol.adapters.bus import Bus
from firmware_protocol.adapters.drive import ForeignDrive
from firmware_protocol.links import CanFrame, DriveSection, PythonCanBus

#: a message that comes at less than this share of the rate that it should have is too seldom
_LEAST_SHARE = 0.7


@dataclass(frozen=True)
class Spoken:
    """A message of a drive; `remedy` says what makes it come, `rate_hz` how often it must, None for: at all."""

    name: str
    remedy: str
    rate_hz: float | None = None


@runtime_checkable
class NamesItsWords(Protocol):
    """A drive that can say which messages it should send, and which frame is which."""

    #: those without which it cannot be used
    spoken: tuple[Spoken, ...]

    def sender_of(self, frame: CanFrame) -> int | None:
        """The id of the drive of this make that sent a frame; None where none did."""

    def word_of(self, frame: CanFrame) -> str:
        """What a frame of this drive is called; empty where it is no word of its own."""

    def question_to(self, number: int) -> CanFrame | None:
        """What a drive of this id answers and does nothing else; None where it speaks without being asked."""


@dataclass
class DriveReport:
    """One drive as it was heard."""

    number: int
    #: messages by name, 1/s
    heard_hz: dict[str, float]
    power: str
    reasons: list[str] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)

    def as_dict(self) -> dict[str, object]:
        """For JSON."""
        return {
            "id": self.number,
            "messages_hz": self.heard_hz,
            "power": self.power,
            "reasons": self.reasons,
            "remarks": self.remarks,
        }

    @property
    def line(self) -> str:
        """For people."""
        said = ", ".join(f"{name} {rate:.0f}/s" for name, rate in self.heard_hz.items())
        return f"drive {self.number}: {f'{said}; {self.power}' if said else 'heard nothing of it'}"


class ListenedBus:
    """A bus that counts who says what, while somebody else reads and writes it."""

    def __init__(self, bus: Bus) -> None:
        self.bus = bus
        self.heard: Counter[CanFrame] = Counter()
        self.dropped = 0

    def send(self, frame: CanFrame) -> bool:
        sent = self.bus.send(frame)
        self.dropped += not sent
        return sent

    def receive(self) -> list[CanFrame]:
        frames = self.bus.receive()
        self.heard.update(CanFrame(frame.identifier, b"", frame.extended, frame.fd) for frame in frames)
        return frames

    @property
    def refused(self) -> int:
        """How often an slcan adapter said no."""
        slcan = self.bus.slcan if isinstance(self.bus, PythonCanBus) else None
        return 0 if slcan is None else slcan.refused

    @property
    def errors(self) -> Counter[str]:
        """What error frames told, how often."""
        return self.bus.errors if isinstance(self.bus, PythonCanBus) else Counter()

    def take_malformed(self) -> int:
        return self.bus.take_malformed()

    def fileno(self) -> int:
        return self.bus.fileno()

    def close(self) -> None:
        self.bus.close()


def drive_reports(
    drives: Sequence[ForeignDrive], sections: Sequence[DriveSection], heard: Counter[CanFrame], seconds: float
) -> list[DriveReport]:
    """What each drive was heard saying, and which of its messages miss or come too seldom."""
    found = []
    for drive, section in zip(drives, sections, strict=True):
        words: Counter[str] = Counter()
        if isinstance(drive, NamesItsWords):
            for frame, count in heard.items():
                if name := drive.word_of(frame):
                    words[name] += count
        report = DriveReport(
            section.id, {name: count / seconds for name, count in sorted(words.items())}, drive.sample.power.value
        )
        if drive.sample.fault:
            report.reasons.append(f"drive {section.id}: {drive.sample.fault}")
        if drive.sample.caution:
            report.remarks.append(f"drive {section.id} {drive.sample.caution}")
        if isinstance(drive, NamesItsWords):
            report.reasons += _missing(drive, section.id, report.heard_hz)
        elif not drive.sample.updates:
            report.reasons.append(f"drive {section.id}: no position of it was heard")
        found.append(report)
    return found


def _missing(drive: NamesItsWords, number: int, heard_hz: dict[str, float]) -> list[str]:
    if not heard_hz:
        return [f"drive {number} says nothing: {drive.spoken[0].remedy}"]
    found = []
    for one in drive.spoken:
        rate = heard_hz.get(one.name, 0.0)
        if not rate:
            found.append(f"drive {number} sends no {one.name}: {one.remedy}")
        elif one.rate_hz is not None and rate < _LEAST_SHARE * one.rate_hz:
            found.append(f"drive {number} sends {one.name} {rate:.0f}/s, {one.rate_hz:.0f}/s are needed: {one.remedy}")
    return found


def probes(drives: Sequence[ForeignDrive]) -> list[CanFrame]:
    """A question to each id that a drive of this make may have."""
    drive = drives[0]
    if not isinstance(drive, NamesItsWords):
        return []
    asked = [drive.question_to(number) for number in range(1, 128)]
    return [frame for frame in asked if frame is not None]


def strangers(drives: Sequence[ForeignDrive], sections: Sequence[DriveSection], heard: Counter[CanFrame]) -> list[int]:
    """Ids of drives of this make that speak on the bus and stand in no section."""
    known = {section.id for section in sections}
    drive = drives[0]
    if not isinstance(drive, NamesItsWords):
        return []
    senders = {drive.sender_of(frame) for frame in heard}
    return sorted(number for number in senders if number is not None and number not in known)
