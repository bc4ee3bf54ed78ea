"""`gimbal-hil doctor`: can this machine hold the rate, and does the antenna answer?"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from firmware_protocol.places import require_new

if TYPE_CHECKING:
    from gimbal_hil.loop.settings import DaemonSettings
    from gimbal_hil.loop.timing import MachineReport

REPORT_FILE = "doctor.json"


def command(
    config: Annotated[
        Path | None, typer.Option(help="Configuration whose rate and link are checked; without it the shipped one.")
    ] = None,
    seconds: Annotated[float, typer.Option(help="How long each loop is measured.", min=0.1)] = 4.0,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help=f"Also write the answer to {REPORT_FILE} in this folder.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the answer as one JSON object.")] = False,
    force: Annotated[bool, typer.Option("--force", help="Overwrite an answer that is there.")] = False,
) -> int:
    """Measure clock, permissions, stalls and the tick loop beside the same loop in C; look whether the antenna answers
    on its link.

    Answers 0 when nothing speaks against holding the rate, 1 otherwise, with the reasons.
    """
    import json

    from firmware_protocol.errors import EXIT_DONE, EXIT_NO
    from firmware_protocol.links import AdapterLinkConfig
    from gimbal_hil.loop.settings import load_settings, shipped_settings
    from gimbal_hil.realtime.daemon import check_link
    from gimbal_hil.surface.cli.following import after_doctor
    from gimbal_hil.surface.cli.next_line import print_next

    if out is not None:
        require_new(out, force, REPORT_FILE)
    settings = load_settings(config) if config else shipped_settings()
    link = check_link(settings)
    machine = _measure(settings, seconds, as_json)
    holds = machine.holds and link.good
    answer: dict[str, object] = {"holds": holds, "machine": machine.as_dict(), "link": link.as_dict()}
    if out is not None:
        out.mkdir(parents=True, exist_ok=True)
        (out / REPORT_FILE).write_text(json.dumps(answer, indent=2) + "\n")
    if as_json:
        print(json.dumps(answer))
    else:
        print("\n".join([*_machine_lines(machine), *link.lines(), _verdict(machine.reasons, link.reasons)]))
        others = isinstance(settings.link, AdapterLinkConfig)
        print_next(after_doctor(config, machine.holds, link.good, others))
    return EXIT_DONE if holds else EXIT_NO


def _measure(settings: DaemonSettings, seconds: float, quiet: bool) -> MachineReport:
    """With a bar that moves between slices only: a thread of its own would disturb what is measured."""
    from rich.progress import Progress

    from gimbal_hil.loop.timing import Duration, check_machine
    from gimbal_hil.surface.cli.progress import error_console

    console = error_console()
    with Progress(console=console, transient=True, auto_refresh=False, disable=quiet or not console.is_terminal) as bar:
        task = bar.add_task("measuring wake-ups", total=1.0)

        def advance(share: float) -> None:
            bar.update(task, completed=share)
            bar.refresh()

        return check_machine(Duration.of_seconds(settings.step_s), seconds, advance)


def _machine_lines(report: MachineReport) -> list[str]:
    granted, statistics = report.granted, report.statistics
    priority = (
        "no real-time priority" if granted.real_time_priority is None else f"SCHED_FIFO {granted.real_time_priority}"
    )
    memory = "memory locked" if granted.memory_locked else "memory not locked"
    slack = "no timer slack control" if granted.timer_slack_ns is None else f"timer slack {granted.timer_slack_ns} ns"
    lines = [
        f"clock: resolution {report.clock_resolution_ns} ns, smallest step seen {report.clock_step_ns} ns",
        f"granted: {priority}, {memory}, {slack}, core {'any' if granted.core is None else granted.core}",
        f"machine stalls seen by the witness: {report.stalls}, longest {report.longest_stall_ns / 1e6:.1f} ms",
        f"tick loop: {statistics.ticks} ticks, {statistics.missed} missed; late by "
        f"{_quantiles(statistics.latency.summary_us())}",
    ]
    if report.reference is not None:
        lines.append(
            f"same in C: {report.reference.missed} missed; late by {_quantiles(report.reference.latency.summary_us())}"
        )
        lines.append(f"p99 of the tick loop is {report.p99_ratio:.2f} times that of the C loop")
    return lines + [f"remark: {remark}" for remark in report.remarks]


def _quantiles(summary: dict[str, float]) -> str:
    return f"p50 {summary['p50']:.0f} us, p99 {summary['p99']:.0f} us, at most {summary['max']:.0f} us"


def _verdict(machine: Sequence[str], link: Sequence[str]) -> str:
    """The answer on the machine and on what is at its link, with what speaks against them."""
    told = "this machine cannot be relied on" if machine else "this machine can hold the rate"
    if link:
        told += f", {'and' if machine else 'but'} the antenna does not answer as it should"
    return "\n".join([f"verdict: {told}", *(f"  - {reason}" for reason in (*machine, *link))])
