"""From an antenna to a verdict on each requirement, with a run folder as its evidence."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path
from types import ModuleType

from firmware_protocol.schema import RECORD_SIZE
from gimbal_hil.data.runs import EventKind, RunHeader, RunWriter, tick_rows
from gimbal_hil.loop.host import AXIS_NAMES
from gimbal_hil.proof.conformance import deadman_checks, state_checks, torque_checks, wire_checks
from gimbal_hil.proof.conformance.carriers import Carrier
from gimbal_hil.proof.conformance.requirements import Requirement
from gimbal_hil.proof.conformance.stand import NotShownError, Stand, UnmetError

#: a check that fails while the tester itself was late is made again, so often at most
_TRIES = 3
_MODULES: tuple[ModuleType, ...] = (wire_checks, state_checks, deadman_checks, torque_checks)
#: what is flushed to the evidence at once
_ROWS = 256

Check = Callable[[Stand, object], str]
#: name -> function; one that is about a table takes the whole requirement in place of its limits
CHECKS: Mapping[str, Check] = {
    name: function
    for module in _MODULES
    for name, function in vars(module).items()
    if callable(function) and not name.startswith("_") and getattr(function, "__module__", "") == module.__name__
}


class RequirementVerdict(Enum):
    """What came of one requirement."""

    PASSED = "passed"
    FAILED = "failed"
    #: the antenna leaves out what an optional requirement is about
    NOT_SHOWN = "not shown"
    #: it moves the antenna, and that was not wanted
    SKIPPED = "skipped"


@dataclass(frozen=True)
class RequirementFinding:
    """The verdict on one requirement, what was seen, how long it took, and where its frames are kept."""

    requirement: Requirement
    verdict: RequirementVerdict
    text: str
    took_s: float
    ticks: int
    tries: int = 1
    evidence: Path | None = None
    steps: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, object]:
        """For JSON."""
        return {
            "id": self.requirement.id,
            "check": self.requirement.check,
            "title": self.requirement.title,
            "verdict": self.verdict.value,
            "text": self.text,
            "took_s": round(self.took_s, 3),
            "ticks": self.ticks,
            "tries": self.tries,
            "evidence": None if self.evidence is None else str(self.evidence),
            "steps": list(self.steps),
        }


@dataclass
class Bench:
    """An antenna under test and what its axes are called; `configuration` and `out` are for the evidence, without `out`
    there is none.
    """

    carrier: Carrier
    configuration: Mapping[str, object] = field(default_factory=dict)
    out: Path | None = None
    force: bool = False
    axes: tuple[str, str] = AXIS_NAMES
    _counters: dict[str, int] = field(default_factory=dict)

    def check(self, requirement: Requirement) -> RequirementFinding:
        """Check one requirement. One that fails while the tester was late is made again."""
        began = time.monotonic()
        for tries in range(1, _TRIES + 1):
            stalls = self.carrier.stalls
            with self._stand(requirement, tries > 1 or self.force) as (stand, folder):
                verdict, text = _verdict(stand, requirement)
            if verdict is not RequirementVerdict.FAILED or self.carrier.stalls == stalls:
                break
        else:
            text += f" (the tester was late in each of {_TRIES} tries)"
        took = time.monotonic() - began
        return RequirementFinding(requirement, verdict, text, took, stand.ticks, tries, folder, tuple(stand.steps))

    @contextmanager
    def _stand(self, requirement: Requirement, force: bool) -> Iterator[tuple[Stand, Path | None]]:
        if self.out is None:
            yield Stand(self.carrier, None, self._counters, self.axes), None
            return
        folder = self.out / "evidence" / requirement.id
        period_ns = round(1e9 / self.carrier.rate_hz)
        header = RunHeader(
            configuration=self.configuration,
            model={},
            seed=0,
            period_ns=period_ns,
            lockstep=self.carrier.in_step,
            title=f"conformance {requirement.id}: {requirement.check}",
        )
        with RunWriter(folder, header, force=force) as writer:
            stand = Stand(self.carrier, _Recording(writer, period_ns), self._counters, self.axes)
            yield stand, folder
            for text in stand.steps:
                writer.event(stand.ticks, stand.ticks * period_ns, EventKind.NOTE, text, {})


class _Recording:
    """Keeps both blocks of every exchange, with a tick row each. What came after a block was sent is the feedback that
    the next tick finds, as in every run.
    """

    def __init__(self, writer: RunWriter, period_ns: int) -> None:
        self._writer, self._period_ns, self._rows = writer, period_ns, tick_rows(1)
        self._found = b""

    def __call__(self, tick: int, received: bytes, sent: bytes) -> None:
        self._writer.append_exchange(tick, self._found, sent)
        self._found = received[: len(received) - len(received) % RECORD_SIZE]
        row = self._rows.copy()
        row["tick"], row["time_ns"] = tick, tick * self._period_ns
        self._writer.append_ticks(row)


def _verdict(stand: Stand, requirement: Requirement) -> tuple[RequirementVerdict, str]:
    check = CHECKS[requirement.check]
    try:
        stand.settle()
        stand.step(requirement.check)
        return RequirementVerdict.PASSED, check(stand, requirement if requirement.transitions else requirement.limits)
    except NotShownError as left_out:
        return (RequirementVerdict.NOT_SHOWN if requirement.optional else RequirementVerdict.FAILED), str(left_out)
    except UnmetError as unmet:
        return RequirementVerdict.FAILED, str(unmet)


def check_all(
    bench: Bench, requirements: Sequence[Requirement], *, may_move: bool, told: Callable[[RequirementFinding], None]
) -> list[RequirementFinding]:
    """Check requirements one after the other; those that move the antenna are left out unless it may."""
    findings = []
    for requirement in requirements:
        if requirement.moves and not may_move:
            text = "applies torque for some ticks, which was not wanted"
            finding = RequirementFinding(requirement, RequirementVerdict.SKIPPED, text, 0.0, 0)
        else:
            finding = bench.check(requirement)
        findings.append(finding)
        told(finding)
    return findings
