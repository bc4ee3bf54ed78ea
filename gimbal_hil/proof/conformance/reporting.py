"""The report of one run of the requirements."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from gimbal_hil.pages.report import Block, Callout, Heading, Page, Table
from gimbal_hil.proof.conformance.requirements import GROUPS
from gimbal_hil.proof.conformance.running import RequirementFinding, RequirementVerdict

#: failed requirements that the headline names; the tables have all
_MOST_TOLD = 3


def in_one_line(findings: Sequence[RequirementFinding]) -> str:
    """How many of each verdict."""
    counts = Counter(finding.verdict for finding in findings)
    return ", ".join(f"{counts[verdict]} {verdict.value}" for verdict in RequirementVerdict if counts[verdict])


def answer_of(findings: Sequence[RequirementFinding], antenna: str) -> str:
    """Whether the firmware of an antenna does what is required, and what it does not."""
    failed = [finding.requirement for finding in findings if finding.verdict is RequirementVerdict.FAILED]
    if failed:
        which = "; ".join(f"{one.id}, {one.title}" for one in failed[:_MOST_TOLD])
        more = f"; and {len(failed) - _MOST_TOLD} more" if len(failed) > _MOST_TOLD else ""
        return f"{len(failed)} of {len(findings)} requirements failed on {antenna}: {which}{more}."
    passed = sum(finding.verdict is RequirementVerdict.PASSED for finding in findings)
    if passed == len(findings):
        return f"All {passed} requirements passed on {antenna}."
    return f"No requirement failed on {antenna}: {in_one_line(findings)}."


def write_report(findings: Sequence[RequirementFinding], antenna: str, path: Path) -> Path:
    """Write the page of one run."""
    failed = [finding for finding in findings if finding.verdict is RequirementVerdict.FAILED]
    blocks: list[Block] = [Callout(answer_of(findings, antenna), "warning" if failed else "good")]
    header = ("", "Requirement", "Verdict", "What was seen", "Ticks", "Time [s]")
    for letter, heading in GROUPS.items():
        rows = [_cells(finding) for finding in findings if finding.requirement.id.startswith(letter)]
        if rows:
            blocks += [Heading(heading), Table(header, rows)]
    return Page("Conformance of an antenna's firmware", antenna, blocks).write(path)


def _cells(finding: RequirementFinding) -> tuple[str, ...]:
    again = f" ({finding.tries} tries)" if finding.tries > 1 else ""
    return (
        finding.requirement.id,
        finding.requirement.title,
        finding.verdict.value + again,
        finding.text,
        str(finding.ticks),
        f"{finding.took_s:.2f}",
    )
