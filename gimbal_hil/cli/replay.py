"""`gimbal-hil replay`: is a recorded run what its log says it is, bit for bit?"""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from gimbal_hil.runs import ReplayResult, Run

ANSWER_FILE = "replay.json"


def command(
    run: Annotated[Path, typer.Argument(help="Run folder.")],
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help=f"Also write the answer to {ANSWER_FILE} in this folder.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the answer as JSON.")] = False,
    force: Annotated[bool, typer.Option("--force", help="Overwrite an answer that is there.")] = False,
) -> int:
    """Run the recorded frames and commands through the host core again; the first tick and signal that differ, or
    identical.
    """
    import time

    from firmware_protocol.errors import EXIT_DONE, EXIT_NO, BadInputError
    from gimbal_hil.runs import open_run

    if out is not None and (out / ANSWER_FILE).exists() and not force:
        raise BadInputError(str(out / ANSWER_FILE), "already exists", "a new folder, or --force to overwrite it")
    log = open_run(run)
    began = time.perf_counter()
    result = _replay(log, quiet=as_json)
    answer = _answer(log, result, time.perf_counter() - began)
    if out is not None:
        out.mkdir(parents=True, exist_ok=True)
        (out / ANSWER_FILE).write_text(json.dumps(answer, indent=2) + "\n", encoding="utf-8")
    print(json.dumps(answer, indent=2) if as_json else "\n".join(_lines(answer)))
    return EXIT_DONE if result.identical else EXIT_NO


def _replay(log: Run, *, quiet: bool) -> ReplayResult:
    from rich.console import Console
    from rich.progress import Progress

    from gimbal_hil.lockstep import give_again, host_of
    from gimbal_hil.runs import replay

    host = host_of(log)
    console = Console(stderr=True)
    with Progress(console=console, transient=True, disable=quiet or not console.is_terminal) as bar:
        task = bar.add_task("replaying ticks", total=log.replayable_ticks)
        return replay(
            log, host, lambda event: give_again(host, log, event), lambda done: bar.update(task, completed=done)
        )


def _answer(log: Run, result: ReplayResult, took_s: float) -> dict[str, Any]:
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


def _lines(answer: dict[str, Any]) -> list[str]:
    found = answer["difference"]
    if found is None:
        counts = f"{answer['ticks']} ticks, {answer['frames']} frames"
        return [
            f"identical: {counts}, {answer['recorded_s']:.1f} s of antenna time in {answer['took_s']:.1f} s",
            *answer["notes"],
        ]
    place = f"tick {found['tick']}" if found["tick"] >= 0 else "no single tick"
    return [
        f"differs at {place}: {found['signal']} is {found['recorded']}, not {found['expected']}: {found['reason']}",
        *answer["notes"],
    ]
