"""`gimbal-hil discrepancy`: where model and measurement disagree, what is missing, by name, with proof."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from firmware_protocol.json_object import Json
from firmware_protocol.places import require_new
from gimbal_hil.surface.cli.log_options import LogOptions, SearchOptions
from gimbal_hil.surface.cli.option_types import AskedModel
from gimbal_hil.surface.cli.settling import SETTLE_FILE, limits_in, write_settling

if TYPE_CHECKING:
    from gimbal_hil.surface.library import Finding

#: options that take several values after one another
MANY_VALUED = ("--measured", "--holdout", "--column")
SETTLE_HELP = f"Of ambiguous and cannot_judge, the motion that settles it too ({SETTLE_FILE}): a minute more."
WRITE_EFFECT_HELP = "Of a described formula, the skeleton of an effect of your own too."
MODEL_FILE, VERDICT_FILE, REPORT_FILE, RECALIBRATED_FILE = (
    "model.yaml",
    "verdict.json",
    "report.html",
    "model_recalibrated.yaml",
)


@dataclass(frozen=True)
class AskedLogs:
    """Which logs are held against which model, and where the answer goes."""

    measured: Annotated[
        list[Path],
        typer.Option(
            metavar="LOG",
            help="To search in: a run of `experiment survey`, or your own CSV or Parquet; may be repeated.",
        ),
    ]
    out: Annotated[
        Path, typer.Option(metavar="DIR", help=f"Folder for {VERDICT_FILE}, {MODEL_FILE} and {REPORT_FILE}.")
    ]
    holdout: Annotated[
        list[Path] | None,
        typer.Option(
            metavar="LOG", help="To judge on, another trajectory: a run of `experiment survey_holdout`, or a file."
        ),
    ] = None
    model: AskedModel = None

    @property
    def logs(self) -> list[Path]:
        """Those to search in, then those to judge on."""
        return [*self.measured, *(self.holdout or ())]


@dataclass(frozen=True)
class AnswerOptions:
    """What is written beside the verdict, and which verdicts fail."""

    fail_on: Annotated[
        str, typer.Option(metavar="VERDICTS", help="Verdicts that exit 1, such as unexplained,ambiguous (CI).")
    ] = ""
    junit: Annotated[Path | None, typer.Option(metavar="FILE", help="The verdict as JUnit XML too (CI).")] = None
    write_effect: Annotated[bool, typer.Option("--write-effect", help=WRITE_EFFECT_HELP)] = False
    settle: Annotated[bool, typer.Option("--settle", help=SETTLE_HELP)] = False


@dataclass(frozen=True)
class SearchEffort:
    """Where candidates are scored."""

    workers: Annotated[int, typer.Option(help="Processes that score candidates.", min=1)] = 2
    dask: Annotated[str | None, typer.Option(metavar="ADDRESS", help="Score candidates on a Dask cluster instead.")] = (
        None
    )


def command(
    *,
    asked: AskedLogs,
    reading: LogOptions,
    search: SearchOptions,
    answer: AnswerOptions,
    effort: SearchEffort,
    as_json: Annotated[bool, typer.Option("--json", help="Print the verdict as JSON.")] = False,
    force: Annotated[bool, typer.Option("--force", help="Overwrite what is in the folder.")] = False,
) -> int:
    """Find what the model lacks, name it, add it, and show the gap shrink on held-out data.

    Logs come from `gimbal-hil experiment survey` (to search in) and `survey_holdout` (to judge on), or are tables of
    your own with the columns time_s, AXIS.position and AXIS.torque (docs/reference/signals-table.md), or with others,
    which --column names: `--column time_s=t_ms:ms joint.position=theta:deg`.
    """
    from gimbal_hil.knowledge.discrepancy import Kind
    from gimbal_hil.surface.library import question_of
    from sim_backend.model import model_named, shipped_model

    fails = _verdicts(answer.fail_on)
    _refuse(asked, force, search)
    given = model_named(asked.model) if asked.model else shipped_model()
    _all_there(asked.logs)
    limits = limits_in(asked.logs) if answer.settle else None
    with searching(as_json) as tell:
        with _refusal_kept(asked.out, answer.junit, as_json):
            question = question_of(given, asked.measured, asked.holdout or (), reading.reading(), search.scope())
            finding = question.asked(workers=effort.workers, dask=effort.dask, progress=tell)
            finding = with_all_effects_next(finding, asked, reading, search)
        tell("writing the report")
        _write(asked.out, finding)
        if answer.write_effect:
            _write_effects(asked.out, finding)
        settling = ""
        if limits is not None and finding.kind in (Kind.AMBIGUOUS, Kind.CANNOT_JUDGE):
            settling = write_settling(asked.out / SETTLE_FILE, finding, limits, effort.workers, tell)
    return _told(finding, asked, fails, answer.junit, as_json, settling)


#: verdicts that `--fail-on` also takes for others
_ALSO = {"described": ("unexplained",)}


def _refuse(asked: AskedLogs, force: bool, search: SearchOptions) -> None:
    """What would be overwritten, names that are no effects, and none to search, before anything is read."""
    from gimbal_hil.knowledge.discrepancy import effect_names
    from sim_backend.effects import effect_named

    _spared(asked.out, asked.model)
    require_new(asked.out, force, MODEL_FILE, VERDICT_FILE, REPORT_FILE, RECALIBRATED_FILE, SETTLE_FILE)
    for option, names in (("--only", search.only), ("--without", search.without)):
        for effect in names or ():
            effect_named(effect, option)
    effect_names(tuple(search.only or ()), tuple(search.without or ()))


def _spared(out: Path, model: str | None) -> None:
    """Raise BadInputError where the answer would take the place of the model that is asked about."""
    from firmware_protocol.errors import BadInputError

    for name in (MODEL_FILE, RECALIBRATED_FILE):
        if model is not None and (out / name).exists() and (out / name).resolve() == Path(model).resolve():
            raise BadInputError(f"--model {model}", "is in --out, where the answer takes its place", "another --out")


def _all_there(logs: Sequence[Path]) -> None:
    """Raise BadInputError for a log that is not there: a name that was mistyped is no reason to remove an earlier
    answer.
    """
    from firmware_protocol.errors import BadInputError

    for log in logs:
        if not log.exists():
            raise BadInputError(str(log), "no such file or folder", "a run folder, or a table (CSV, Parquet, npz)")


def _write(out: Path, finding: Finding) -> None:
    """The verdict, the model where it changed, and the report."""
    import json

    out.mkdir(parents=True, exist_ok=True)
    (out / SETTLE_FILE).unlink(missing_ok=True)
    for name, changed in ((MODEL_FILE, finding.model), (RECALIBRATED_FILE, finding.recalibrated)):
        (out / name).unlink(missing_ok=True)
        if changed is not None:
            (out / name).write_text(changed.to_yaml(), encoding="utf-8")
    text = json.dumps(finding.verdict.document, indent=2, allow_nan=False)
    (out / VERDICT_FILE).write_text(text + "\n", encoding="utf-8")
    finding.page.write(out / REPORT_FILE)


def _write_effects(out: Path, finding: Finding) -> None:
    """A skeleton for every law that has a formula."""
    from gimbal_hil.knowledge.discrepancy import effect_source

    described, linear = finding.result.described, finding.result.model.is_linear
    for number, law in enumerate(described.laws if described is not None else (), 1):
        name = f"law_{number}_of_{law.curve.shape.axis}"
        source = None if law.formula is None else effect_source(law.formula, name, linear)
        if source is not None:
            (out / f"{name}.py").write_text(source, encoding="utf-8")


def _told(
    finding: Finding, asked: AskedLogs, fails: frozenset[str], junit: Path | None, as_json: bool, settling: str
) -> int:
    """The answer on the terminal, and as JUnit where asked; the exit code."""
    import json

    from firmware_protocol.errors import EXIT_DONE, EXIT_NO
    from gimbal_hil.surface.cli.following_logs import after_discrepancy
    from gimbal_hil.surface.cli.next_line import print_next

    verdict = finding.verdict.document
    print(json.dumps(verdict, allow_nan=False) if as_json else verdict_summary(verdict, asked.out))
    if not as_json:
        if settling:
            print(settling)
        axes, made = len(finding.result.model.axes), asked.out / SETTLE_FILE
        assumed = _assumed_and_hidden(finding)
        if assumed:
            print(f"  why: {_assumed_words(assumed, axes, asked.out if finding.recalibrated else None)}")
        names = {name for name, _ in assumed}
        print_next(after_discrepancy(verdict, asked.model, axes, asked.out, asked.logs, made, assumed=names))
    # where no name fits is unexplained to whoever asked before laws were told
    failed = bool({finding.kind.value, *_ALSO.get(finding.kind.value, ())} & fails)
    if junit is not None:
        _write_junit(junit, f"{finding.kind.value}: {finding.verdict.text}", failed)
    return EXIT_NO if failed else EXIT_DONE


def _assumed_and_hidden(finding: Finding) -> list[tuple[str, str]]:
    """Of the numbers (effect, axis) that keep logs from judging the model those that nobody measured."""
    from gimbal_hil.knowledge.discrepancy import Kind

    if finding.kind is not Kind.CANNOT_JUDGE:
        return []
    from gimbal_hil.knowledge.tuning import is_assumed
    from sim_backend.effects import CATALOGUE

    model = finding.result.model
    paths = [(name, axis, CATALOGUE[name].parameters[0].path) for name, axis in finding.result.hidden]
    return [
        (name, axis) for name, axis, path in paths if path and is_assumed(model, axis, model.number_path(axis, path))
    ]


def _assumed_words(numbers: list[tuple[str, str]], axes: int, moved_in: Path | None) -> str:
    """Why logs cannot judge a model of which nobody measured these numbers, and what to do; `moved_in` is the folder
    of the model in which numbers are where these logs put them.
    """
    from gimbal_hil.surface.cli.following_logs import FRICTIONS
    from sim_backend.effects import CATALOGUE

    said = ", ".join(f"{CATALOGUE[name].asked_as or name} on {axis}" for name, axis in numbers)
    # no experiment moves a single axis, and sliding says nothing of an inertia
    friction = axes > 1 and any(name in FRICTIONS for name, _ in numbers)
    measure = "Measure friction (experiment sliding, then identify), and write" if friction else "Write"
    moved = f" {moved_in / RECALIBRATED_FILE} has what these logs say: ask again with it." if moved_in else ""
    return (
        f"{said}: assumed, which counts as known to 50 %, and an error within that is no gap. {measure} beside what "
        f"you know better how well (uncertainty: 5%).{moved}"
    )


def with_all_effects_next(finding: Finding, asked: AskedLogs, reading: LogOptions, search: SearchOptions) -> Finding:
    """Where nothing that was searched explains the logs, and not all was: with the command that searches all."""
    from dataclasses import replace

    from gimbal_hil.knowledge.discrepancy import Kind
    from gimbal_hil.surface.cli.next_line import command_line, free_path

    planned = finding.verdict.next_experiment
    if not search.limited or planned is None or finding.kind not in (Kind.UNEXPLAINED, Kind.DESCRIBED):
        return finding
    logs = {"measured": asked.measured, "holdout": asked.holdout, "column": reading.column}
    # the answer to this call is about to stand in --out
    out = free_path(asked.out.with_name(f"{asked.out.name}_of_all"))
    command = command_line("discrepancy", model=asked.model, **logs, **reading.repairs, **search.of_all, out=out)
    return replace(finding, verdict=replace(finding.verdict, next_experiment=planned | {"command": command}))


def _verdicts(text: str) -> frozenset[str]:
    """The verdicts of `--fail-on`, checked."""
    from firmware_protocol.errors import BadInputError
    from gimbal_hil.knowledge.discrepancy import Kind

    found = [word.strip() for word in text.split(",") if word.strip()]
    known = [kind.value for kind in Kind if kind is not Kind.UNUSABLE_DATA]
    for word in found:
        if word not in known:
            raise BadInputError("--fail-on", f"{word!r} is no verdict", "a list of " + ", ".join(known))
    return frozenset(found)


@contextmanager
def _refusal_kept(out: Path, junit: Path | None, as_json: bool) -> Iterator[None]:
    """Logs that are refused leave a verdict that says so, and nothing of an earlier one beside it. An option that is
    refused says nothing of the logs.
    """
    import json

    from firmware_protocol.errors import BadInputError

    try:
        yield
    except BadInputError as error:
        if error.where.startswith("--"):
            raise
        from gimbal_hil.knowledge.discrepancy import refusal

        verdict = refusal(str(error)).document
        out.mkdir(parents=True, exist_ok=True)
        for name in (MODEL_FILE, RECALIBRATED_FILE, REPORT_FILE, SETTLE_FILE):
            (out / name).unlink(missing_ok=True)
        (out / VERDICT_FILE).write_text(json.dumps(verdict, indent=2) + "\n", encoding="utf-8")
        if as_json:
            print(json.dumps(verdict))
        if junit is not None:
            _write_junit(junit, f"unusable_data: {error}", True)
        raise


def _write_junit(path: Path, text: str, failed: bool) -> None:
    from gimbal_hil.pages.report import Case, write_junit

    write_junit(path, "gimbal-hil discrepancy", [Case("discrepancy", text, failed)])


class searching:
    """A line on the terminal that says what is being done; silent where nobody looks."""

    def __init__(self, quiet: bool) -> None:
        from gimbal_hil.surface.cli.progress import error_console

        console = error_console()
        self._status = console.status("starting") if console.is_terminal and not quiet else None

    def __enter__(self) -> Callable[[str], None]:
        if self._status is not None:
            self._status.start()
        return lambda text: self._status.update(text) if self._status is not None else None

    def __exit__(self, *_: object) -> None:
        if self._status is not None:
            self._status.stop()


def _in_words(parameter: tuple[str, Json]) -> str:
    name, number = parameter
    return f"{name} {number['value']:.4g} {number['unit'] if number['unit'] != '1' else ''}".rstrip()


def verdict_summary(verdict: Json, out: Path) -> str:
    """What the terminal says of a verdict whose files are in `out`."""
    from gimbal_hil.knowledge.discrepancy import entries_of, told_contradictions

    said = " ".join(part for part in (*verdict["answer"].splitlines(), verdict["grounds"]) if part)
    lines = [f"{verdict['verdict'].replace('_', ' ')}: {said}", *([f"  {verdict['left']}"] if verdict["left"] else [])]
    for effect in verdict["effects"]:
        values = "; ".join(", ".join(map(_in_words, entry.items())) for entry in entries_of(effect))
        lines.append(f"  {effect['name']} on {effect['axis']} ({effect['status']}): {values}")
    lines += [f"  ! {against}" for against in told_contradictions(verdict["contradictions"])]
    if verdict["next_experiment"]:
        lines.append(f"  to decide it: {verdict['next_experiment']['plan']}")
    return "\n".join([*lines, f"report: {out / REPORT_FILE}"])
