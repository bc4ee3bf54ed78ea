"""`gimbal-hil conformance`: numbered requirements on an antenna's firmware, each with verdict and evidence."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from firmware_protocol.places import require_new

if TYPE_CHECKING:
    from gimbal_hil.proof.conformance import Requirement, RequirementFinding

ANSWER_FILE, REPORT_FILE = "conformance.json", "report.html"


@dataclass(frozen=True)
class CheckedAntenna:
    """Which antenna is asked."""

    link: Annotated[
        str | None,
        typer.Option(
            help="virtual, c, cortex-m or qemu (the C device), unix:PATH, serial:PORT, socketcan:CHANNEL, ..."
        ),
    ] = None
    config: Annotated[
        Path | None, typer.Option(help="Configuration file; its rate and, without --link, its link are used.")
    ] = None
    lockstep: Annotated[
        bool, typer.Option("--lockstep", help="The antenna on the link waits for each tick, as plant --lockstep does.")
    ] = False


@dataclass(frozen=True)
class CheckOptions:
    """What it is asked, and how strongly."""

    only: Annotated[
        list[str] | None, typer.Option(metavar="ID", help="Only this requirement, or group by its letter.")
    ] = None
    without_motion: Annotated[
        bool, typer.Option("--without-motion", help="Leave out what applies torque to an axis.")
    ] = False
    torque_share: Annotated[
        float,
        typer.Option(help="Torque of the checks that move, as a share of what the wire carries.", min=0.001, max=1.0),
    ] = 0.2


def command(
    *,
    antenna: CheckedAntenna,
    checks: CheckOptions,
    out: Annotated[Path | None, typer.Option(metavar="DIR", help="Where the evidence goes; else below ./runs.")] = None,
    junit: Annotated[Path | None, typer.Option(metavar="FILE", help="The verdicts as JUnit XML too (CI).")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the findings as one JSON object.")] = False,
    force: Annotated[bool, typer.Option("--force", help="Overwrite what is in the folder.")] = False,
) -> int:
    """Check the firmware of whatever antenna answers on the link: docs/reference/conformance.md lists the requirements.

    Ends with 1 when one has failed. Some checks move the antenna by short torques, unless --without-motion.
    """
    import json

    from firmware_protocol.errors import EXIT_DONE, EXIT_NO
    from gimbal_hil.loop.timing import wall_clock_utc
    from gimbal_hil.pages.report import Case, write_junit
    from gimbal_hil.proof.conformance import (
        Bench,
        RequirementVerdict,
        check_all,
        in_one_line,
        open_antenna,
        write_report,
    )
    from gimbal_hil.surface.cli.following import after_conformance
    from gimbal_hil.surface.cli.next_line import print_next
    from gimbal_hil.surface.starting import settings_on_link

    wanted = _wanted(checks.only or [], checks.torque_share)
    settings = settings_on_link(antenna.config, antenna.link)
    folder = out or Path("runs") / f"conformance-{wall_clock_utc()[:19].replace(':', '').replace('-', '')}"
    require_new(folder, force, ANSWER_FILE)
    opened = open_antenna(settings, lockstep=antenna.lockstep)
    try:
        configuration = settings.model_dump(mode="json", by_alias=True)
        bench = Bench(opened, configuration, folder, force, settings.axis_names)
        findings = check_all(bench, wanted, may_move=not checks.without_motion, told=_say_nothing if as_json else _say)
    finally:
        opened.close()
    failed = [finding for finding in findings if finding.verdict is RequirementVerdict.FAILED]
    answer = {"antenna": opened.name, "rate_hz": opened.rate_hz, "conforms": not failed}
    document = {**answer, "findings": [finding.as_dict() for finding in findings]}
    folder.mkdir(parents=True, exist_ok=True)
    (folder / ANSWER_FILE).write_text(json.dumps(document, indent=2) + "\n", encoding="utf-8")
    write_report(findings, f"{opened.name} at {opened.rate_hz:g} Hz", folder / REPORT_FILE)
    if junit is not None:
        cases = [Case(f"{f.requirement.id} {f.requirement.title}", f.text, f in failed) for f in findings]
        write_junit(junit, "gimbal-hil conformance", cases)
    if as_json:
        print(json.dumps(document))
    else:
        print(f"{opened.name}: {in_one_line(findings)}\n  report  {folder / REPORT_FILE}")
        print_next(after_conformance(antenna.config, failed[0].evidence if failed else None))
    return EXIT_NO if failed else EXIT_DONE


def _wanted(only: list[str], torque_share: float) -> list[Requirement]:
    from firmware_protocol.errors import BadInputError
    from gimbal_hil.proof.conformance import shipped_requirements

    every = shipped_requirements()
    for name in only:
        if not any(one.id == name or one.id[0] == name for one in every):
            raise BadInputError("--only", f"no requirement {name!r}", f"{every[0].id} to {every[-1].id}, or a letter")
    found = [one for one in every if not only or one.id in only or one.id[0] in only]
    return [
        one.model_copy(update={"limits": one.limits | {"torque_share": torque_share}})
        if "torque_share" in one.limits
        else one
        for one in found
    ]


def _say_nothing(finding: RequirementFinding) -> None:
    """For --json, which prints one object at the end."""


def _say(finding: RequirementFinding) -> None:
    again = f" (try {finding.tries})" if finding.tries > 1 else ""
    print(f"{finding.verdict.value:<9} {finding.requirement.id}{again} {finding.requirement.title}")
    print(f"          {finding.text}", flush=True)
