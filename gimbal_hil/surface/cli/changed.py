"""`gimbal-hil changed`: what differs between two units, days, settings or temperatures."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from firmware_protocol.places import require_new
from gimbal_hil.surface.cli.log_options import LogOptions, SearchOptions
from gimbal_hil.surface.cli.option_types import AskedModel

if TYPE_CHECKING:
    from gimbal_hil.data.signals import LogReading
    from gimbal_hil.surface.library import Changes, SearchScope

#: options that take several values after one another
MANY_VALUED = ("--before", "--after", "--column")
ANSWER_FILE, MODEL_FILE, REPORT_FILE = "changed.json", "model_before.yaml", "report.html"


@dataclass(frozen=True)
class ComparedLogs:
    """What is compared, and where the answer goes."""

    before: Annotated[
        list[Path], typer.Option(metavar="LOG", help="Logs of the machine as it was: runs or tables; may be repeated.")
    ]
    after: Annotated[
        list[Path], typer.Option(metavar="LOG", help="Logs of the other unit, day or setting; may be repeated.")
    ]
    out: Annotated[Path, typer.Option(metavar="DIR", help=f"Folder for {ANSWER_FILE}, {MODEL_FILE} and {REPORT_FILE}.")]
    model: AskedModel = None


def command(
    *,
    asked: ComparedLogs,
    reading: LogOptions,
    search: SearchOptions,
    fail_on: Annotated[
        str, typer.Option(metavar="VERDICTS", help="Verdicts that exit 1, such as changed,ambiguous (CI).")
    ] = "",
    workers: Annotated[int, typer.Option(help="Processes that score candidates.", min=1)] = 2,
    as_json: Annotated[bool, typer.Option("--json", help="Print the answer as JSON.")] = False,
    force: Annotated[bool, typer.Option("--force", help="Overwrite what is in the folder.")] = False,
) -> int:
    """Say which numbers or effects of a machine are not what they were, or that none shows.

    The model is fitted to the logs before; what it then lacks for the logs after is searched, and each cause is put to
    the logs before: only one that they speak against is a change (docs/reference/changed.md).
    """
    import json

    from firmware_protocol.errors import EXIT_DONE, EXIT_NO
    from gimbal_hil.surface.cli.following_logs import after_changed
    from gimbal_hil.surface.cli.next_line import print_next

    fails = _verdicts(fail_on)
    require_new(asked.out, force, ANSWER_FILE, MODEL_FILE, REPORT_FILE)
    found = _compared(asked, reading.reading(), search.scope(), workers, as_json)
    if as_json:
        print(json.dumps(found.document, allow_nan=False))
    else:
        print("\n".join(_lines(found, asked.out)))
        print_next(after_changed(found.document, asked, reading, search, len(found.model.axes)))
    return EXIT_NO if found.kind.value in fails else EXIT_DONE


def _compared(asked: ComparedLogs, reading: LogReading, scope: SearchScope, workers: int, quiet: bool) -> Changes:
    """The answer, with its files in the folder."""
    from firmware_protocol.errors import BadInputError
    from gimbal_hil.surface.cli.discrepancy import searching
    from gimbal_hil.surface.library import changes_between
    from sim_backend.model import model_named, shipped_model

    for log in (*asked.before, *asked.after):
        if not log.exists():
            raise BadInputError(str(log), "no such file or folder", "a run folder, or a table (CSV, Parquet, npz)")
    given = model_named(asked.model) if asked.model else shipped_model()
    with searching(quiet) as tell:
        found = changes_between(given, asked.before, asked.after, reading, scope, workers=workers, progress=tell)
        _write(asked.out, found)
    return found


def _verdicts(text: str) -> frozenset[str]:
    """The verdicts of `--fail-on`, checked."""
    from firmware_protocol.errors import BadInputError
    from gimbal_hil.knowledge.change import ChangeKind

    found = [word.strip() for word in text.split(",") if word.strip()]
    known = [kind.value for kind in ChangeKind]
    for word in found:
        if word not in known:
            raise BadInputError("--fail-on", f"{word!r} is no verdict", "a list of " + ", ".join(known))
    return frozenset(found)


def _write(out: Path, found: Changes) -> None:
    """The answer, the model of the machine before, and the report."""
    import json

    out.mkdir(parents=True, exist_ok=True)
    (out / MODEL_FILE).write_text(found.model.to_yaml(), encoding="utf-8")
    text = json.dumps(found.document, indent=2, allow_nan=False)
    (out / ANSWER_FILE).write_text(text + "\n", encoding="utf-8")
    found.page.write(out / REPORT_FILE)


def _lines(found: Changes, out: Path) -> list[str]:
    document = found.document
    lines = [f"{document['verdict'].replace('_', ' ')}: {document['text']}"]
    lines += [f"  no change: {one['name']} on {one['axis']}, {one['reason']}" for one in document["dismissed"]]
    lines += [f"note: {note}" for note in document["notes"]]
    return [*lines, f"report: {out / REPORT_FILE}", f"model:  {out / MODEL_FILE} (the machine before)"]
