"""`gimbal-hil replay`: is a recorded run what its log says it is, bit for bit?"""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from firmware_protocol.json_object import Json
from firmware_protocol.places import require_new

if TYPE_CHECKING:
    from collections.abc import Callable

    from gimbal_hil.data.runs import Again, Event, RecordedRun, ReplayResult
    from gimbal_hil.loop.host import Host
    from gimbal_hil.loop.settings import DaemonSettings

ANSWER_FILE = "replay.json"


def command(
    run: Annotated[Path, typer.Argument(help="Run folder.")],
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help=f"Also write the answer to {ANSWER_FILE} in this folder.")
    ] = None,
    junit: Annotated[Path | None, typer.Option(metavar="FILE", help="The answer as JUnit XML too (CI).")] = None,
    learned: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE", help="Write the tables that the loops had learned at its end (axes.NAME.learned)."
        ),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the answer as JSON.")] = False,
    force: Annotated[bool, typer.Option("--force", help="Overwrite an answer that is there.")] = False,
    update: Annotated[
        bool, typer.Option("--update", help="Where it differs: make what the host does now the reference in RUN.")
    ] = False,
    config: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE", help="What the host would have sent with these gains and limits on the same feedback."
        ),
    ] = None,
) -> int:
    """Run the recorded frames and commands through the host core again; the first tick and signal that differ, or
    identical. Where they differ, the changes are listed signal by signal. With --config the recorded feedback stays as
    it is, whatever the other host sends: it shows what changes first, not how the antenna would have gone on.
    """
    import time

    from firmware_protocol.errors import EXIT_DONE, EXIT_NO, BadInputError
    from gimbal_hil.data.runs import open_run
    from gimbal_hil.data.runs import update as make_reference
    from gimbal_hil.pages.report import Case, write_junit
    from gimbal_hil.surface.cli.following import after_replay
    from gimbal_hil.surface.cli.next_line import print_next

    if out is not None:
        require_new(out, force, ANSWER_FILE)
    if learned is not None:
        require_new(learned.parent, force, learned.name, instead="another file")
    if config is not None and (update or learned is not None):
        raise BadInputError("--config", "is an experiment in thought", "no --update and no --learned beside it")
    log, other = open_run(run), None
    if config is not None:
        from gimbal_hil.loop.settings import load_settings

        other = load_settings(config)
    began = time.perf_counter()
    result, host = _replay(log, other, quiet=as_json)
    again = None if result.identical else _again(log, other, must=update)
    answer = _answer(log, result, time.perf_counter() - began) | {"changes": _changes(log, again)}
    if learned is not None:
        answer |= {"learned": _write_learned(learned, result, host)}
    if update and again is not None:
        make_reference(log, again)
        answer |= {"updated": True}
    if out is not None:
        out.mkdir(parents=True, exist_ok=True)
        (out / ANSWER_FILE).write_text(json.dumps(answer, indent=2) + "\n", encoding="utf-8")
    print(json.dumps(answer, indent=2) if as_json else "\n".join(_lines(answer)))
    if junit is not None:
        failed = not result.identical and not update
        write_junit(junit, "gimbal-hil replay", [Case(str(run), "\n".join(_lines(answer)), failed)])
    if not as_json:
        print_next(after_replay(run, result.identical or update))
    return EXIT_DONE if result.identical or update else EXIT_NO


def _write_learned(path: Path, result: ReplayResult, host: Host) -> dict[str, int]:
    """Write the tables of a host at the end of its run; how many bins each axis has. BadInputError for a run that
    replays differently: then they are not its own.
    """
    from firmware_protocol.errors import BadInputError
    from gimbal_hil.loop.settings import learned_text

    if not result.identical:
        raise BadInputError("--learned", "the run does not replay as it is recorded", "a run that does")
    entries = {axis: host.learned(place) for place, axis in enumerate(host.axes)}
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(learned_text(entries), encoding="utf-8")
    return {axis: len(rows) for axis, rows in entries.items()}


def _replay(log: RecordedRun, other: DaemonSettings | None, *, quiet: bool) -> tuple[ReplayResult, Host]:
    from rich.progress import Progress

    from gimbal_hil.data.runs import replay
    from gimbal_hil.surface.cli.progress import error_console

    host, give = _host(log, other)
    console = error_console()
    with Progress(console=console, transient=True, disable=quiet or not console.is_terminal) as bar:
        task = bar.add_task("replaying ticks", total=log.replayable_ticks)
        found = replay(log, host, give, lambda done: bar.update(task, completed=done))
    return found, host


def _host(log: RecordedRun, other: DaemonSettings | None) -> tuple[Host, Callable[[Event], None]]:
    """The host of a run, or one of another configuration, and what hands it the recorded commands."""
    from gimbal_hil.realtime.lockstep import give_again, host_of

    host = host_of(log) if other is None else host_of(log, other)
    return host, lambda event: give_again(host, log, event, other)


def _again(log: RecordedRun, other: DaemonSettings | None, must: bool) -> Again | None:
    """What the host does now; None (an error where it must be) for a log that is damaged: then it is no reference."""
    from firmware_protocol.errors import BadInputError
    from gimbal_hil.data.runs import run_again

    try:
        return run_again(log, *_host(log, other))
    except BadInputError:
        if must:
            raise
        return None


def _changes(log: RecordedRun, again: Again | None) -> list[Json]:
    """What came out otherwise, signal by signal."""
    from dataclasses import asdict

    from gimbal_hil.data.runs import changes

    found = [] if again is None else changes(log, again)
    return [asdict(change) | {"text": change.in_words(len(log.ticks))} for change in found]


def _answer(log: RecordedRun, result: ReplayResult, took_s: float) -> Json:
    return {
        "identical": result.identical,
        "ticks": result.ticks,
        "frames": result.frames,
        "recorded_ticks": len(log.ticks),
        "recorded_s": result.ticks * log.record.header.period_ns * 1e-9,
        "took_s": round(took_s, 3),
        "difference": None if result.difference is None else dict(vars(result.difference)),
        "notes": list(log.notes),
    }


def _lines(answer: Json) -> list[str]:
    found = answer["difference"]
    if found is None:
        counts = f"{answer['ticks']} ticks, {answer['frames']} frames"
        return [
            f"identical: {counts}, {answer['recorded_s']:.1f} s of antenna time in {answer['took_s']:.1f} s",
            *(f"learned: {bins} of 720 bins of {axis}" for axis, bins in answer.get("learned", {}).items()),
            *answer["notes"],
        ]
    place = f" at tick {found['tick']}" if found["tick"] >= 0 else ""
    return [
        f"differs{place}: {found['signal']} is {found['recorded']}, not {found['expected']}: {found['reason']}",
        *(f"  {change['text']}" for change in answer["changes"]),
        *(["updated: what the host does now is the reference from here on"] if answer.get("updated") else []),
        *answer["notes"],
    ]
