"""`gimbal-hil runs`: what was recorded, one run in words, or two side by side."""

from __future__ import annotations

from collections.abc import Sequence
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from firmware_protocol.places import require_new

if TYPE_CHECKING:
    from gimbal_hil.data.catalogue import Comparison
    from gimbal_hil.data.runs import Event

REPORT_FILE, ANSWER_FILE = "report.html", "comparison.json"


class RunsAction(StrEnum):
    """What to do with the runs."""

    LIST = "list"
    SHOW = "show"
    COMPARE = "compare"


def command(
    action: Annotated[RunsAction, typer.Argument(help="list [FOLDER], show RUN, or compare A B.")],
    paths: Annotated[
        list[Path] | None, typer.Argument(metavar="PATH...", help="Run folders; of list the folder, else ./runs.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help=f"compare: folder for {REPORT_FILE} and {ANSWER_FILE}.")
    ] = None,
    tolerance: Annotated[
        float | None,
        typer.Option(
            metavar="SHARE", min=0.0, help="compare: 1 where a figure differs by more than this share (0.05: 5 %)."
        ),
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Overwrite what is in the folder.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the answer as one JSON object.")] = False,
) -> int:
    """List the runs below a folder, show what one of them was, or compare two: figures side by side, what differs in
    configuration and model, and both drawn over each other (with --out). `show` answers 1 for a run that is not what
    was recorded.
    """
    from firmware_protocol.errors import EXIT_DONE, EXIT_NO, BadInputError

    given = paths or []
    if action is RunsAction.LIST:
        if len(given) > 1:
            raise BadInputError("runs list", f"has {len(given)} folders", "one folder, or none for ./runs")
        _list(given[0] if given else None, as_json)
    elif action is RunsAction.SHOW:
        if len(given) != 1:
            raise BadInputError("runs show", f"has {len(given)} runs", "one run folder")
        return EXIT_DONE if _show(given[0], as_json) else EXIT_NO
    else:
        if len(given) != 2:
            raise BadInputError("runs compare", f"has {len(given)} runs", "two run folders")
        return _compare(given[0], given[1], out, tolerance, force, as_json)
    return EXIT_DONE


def _list(given: Path | None, as_json: bool) -> None:
    import json

    from gimbal_hil.data.catalogue import find_runs, summary_of
    from gimbal_hil.surface.cli.next_line import command_line, print_next

    folder = given or Path("runs")
    # whoever names no folder need not have one yet
    found = [summary_of(run) for run in find_runs(folder)] if given or folder.is_dir() else []
    if as_json:
        print(json.dumps({"runs": [one.as_dict() for one in found]}))
        return
    width = max((len(str(one.folder)) for one in found), default=0)
    for one in found:
        length = "      -" if one.length_s is None else f"{one.length_s:7.1f}"
        _say(f"{one.folder!s:<{width}}  {one.started_utc[:19]:<19} {length} s  {one.title:<14} {one.ending}")
    if not found:
        _say(f"no runs below {folder}")
        print_next(command_line("experiment", "step"))
    else:
        print_next(command_line("runs", "show", found[-1].folder))


def _show(folder: Path, as_json: bool) -> bool:
    """Whether the run is what it was when it was recorded."""
    import json

    from firmware_protocol.errors import GimbalHilError
    from gimbal_hil.data.catalogue import measures_of, summary_of
    from gimbal_hil.data.runs import EventKind, damage_of, open_run
    from gimbal_hil.data.signals import signals_of_run
    from gimbal_hil.surface.cli.next_line import command_line, print_next

    run, line = open_run(folder), summary_of(folder)
    damage = [f"damaged: {found.in_words()}" for found in damage_of(run)]
    notes = [*run.notes, *damage]
    try:
        table = signals_of_run(run, drop_invalid=True)
    except GimbalHilError as error:
        table = None
        notes.append(str(error))
    measures = measures_of(run, table)
    told = [event for event in run.events if event.kind in (EventKind.FAULT, EventKind.COMMAND, EventKind.LINK)]
    if as_json:
        figures = [{"name": one.name, "value": one.value, "unit": one.unit} for one in measures]
        events = [{"tick": event.tick, "kind": event.kind.value, "text": event.text} for event in told]
        print(json.dumps(line.as_dict() | {"figures": figures, "events": events, "notes": notes, "sound": not damage}))
        return not damage
    length = "" if line.length_s is None else f", {line.length_s:.1f} s"
    _say(f"{folder}: {line.title or 'a run'} of {line.started_utc[:19]}{length}; {line.ending}")
    if damage:
        _say("NOT AS IT WAS RECORDED: what follows is of the rest; the notes say what is wrong")
    _say(f"axes {', '.join(line.axes)}; model {line.model}")
    _say("\n".join(f"  {one.name:<32} {one.value:>12.6g} {one.unit}".rstrip() for one in measures))
    _say("\n".join(_told_events(told, run.record.header.period_ns * 1e-9)))
    _say("\n".join(f"  note: {note}" for note in notes))
    print_next(command_line("replay", folder))
    return not damage


def _told_events(events: Sequence[Event], period_s: float) -> list[str]:
    """The last twenty, a line each; the same one again and again is one line."""
    found: list[tuple[Event, int, Event]] = []
    for event in events:
        if found and (found[-1][0].kind, found[-1][0].text) == (event.kind, event.text):
            found[-1] = (found[-1][0], found[-1][1] + 1, event)
        else:
            found.append((event, 1, event))
    return [
        f"  {first.tick * period_s:9.3f} s  {first.kind.value:<8} {first.text}"
        + (f" ({count} times, the last at {last.tick * period_s:.3f} s)" if count > 1 else "")
        for first, count, last in found[-20:]
    ]


def _compare(first: Path, second: Path, out: Path | None, tolerance: float | None, force: bool, as_json: bool) -> int:
    import json

    from firmware_protocol.errors import EXIT_DONE, EXIT_NO
    from gimbal_hil.data.catalogue import compare, comparison_headline, comparison_page
    from gimbal_hil.data.runs import open_run
    from gimbal_hil.surface.cli.following_logs import after_compare
    from gimbal_hil.surface.cli.next_line import command_line, print_next

    if out is not None:
        require_new(out, force, REPORT_FILE, ANSWER_FILE)
    found = compare(open_run(first), open_run(second))
    apart = () if tolerance is None else found.apart(tolerance)
    answer = found.as_dict() | ({} if tolerance is None else {"tolerance": tolerance, "apart": list(apart)})
    code = EXIT_NO if apart or not found.sound else EXIT_DONE
    if out is not None:
        out.mkdir(parents=True, exist_ok=True)
        (out / ANSWER_FILE).write_text(json.dumps(answer, indent=2) + "\n", encoding="utf-8")
        comparison_page(found, tolerance).write(out / REPORT_FILE)
    if as_json:
        print(json.dumps(answer))
        return code
    if not found.sound:
        _say("NOT AS RECORDED: what follows is of the rest; the notes say what is wrong")
    _say(comparison_headline(found))
    if tolerance is not None:
        _say(found.within(tolerance))
    _say("\n".join(_lines(found)))
    if out is None:
        print_next(command_line("runs", "compare", first, second, out="compared"))
    else:
        _say(f"report: {out / REPORT_FILE}")
        print_next(after_compare(first, second, out, found.sound))
    return code


def _lines(found: Comparison) -> list[str]:
    def shown(value: object) -> str:
        return "-" if value is None else f"{value:.6g}"

    lines = [f"{'':<36}{'first':>14}{'second':>14}"]
    lines += [f"{f'{name} {unit}':<36}{shown(a):>14}{shown(b):>14}" for name, unit, a, b in found.measures]
    lines += [f"{key}: {a} | {b}" for key, a, b in found.differences]
    lines += [f"note: {note}" for note in found.notes]
    return lines


def _say(text: str) -> None:
    """What stands in a run is text of somebody else."""
    from firmware_protocol.errors import shown

    if text:
        print(shown(text))
