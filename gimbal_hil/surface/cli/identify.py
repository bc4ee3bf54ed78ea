"""`gimbal-hil identify`: friction from recorded runs, with an interval and a verdict for every number."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from firmware_protocol.places import require_new
from gimbal_hil.surface.cli.columns import COLUMN_HELP, COLUMN_PAIR, REPAIR_HELP
from gimbal_hil.surface.cli.completion import model_names

if TYPE_CHECKING:
    from gimbal_hil.data.signals import ColumnMap
    from gimbal_hil.knowledge.identification import AxisIdentification, Log
    from sim_backend.model import AntennaModel

#: options that take several values after one another
MANY_VALUED = ("--column",)
MODEL_FILE, ANSWER_FILE, REPORT_FILE = "model.yaml", "identification.json", "report.html"


@dataclass(frozen=True)
class _Reading:
    """How logs are read: as the options of the same names say."""

    torque_driven: bool
    resample: bool
    drop_invalid: bool
    rate_hz: float | None
    columns: ColumnMap


def command(
    runs: Annotated[
        list[Path], typer.Argument(metavar="RUN...", help="Run folders, or signals tables (CSV, Parquet).")
    ],
    out: Annotated[
        Path, typer.Option(metavar="DIR", help=f"Folder for {MODEL_FILE}, {ANSWER_FILE} and {REPORT_FILE}.")
    ],
    model: Annotated[
        str | None,
        typer.Option(
            metavar="MODEL",
            autocompletion=model_names,
            help="Prior and rigid body: a model file or a shipped name; without it thesis.",
        ),
    ] = None,
    axis: Annotated[list[str] | None, typer.Option(help="Identify this axis only; may be repeated.")] = None,
    torque_driven: Annotated[
        bool,
        typer.Option(
            "--torque-driven",
            help="Tables without references were recorded under direct torque: use them for presliding and output "
            "error.",
        ),
    ] = False,
    ramps_at_rest: Annotated[
        bool,
        typer.Option(
            "--ramps-at-rest",
            help="Break-away torques of slow ramps are points at rest of the friction-velocity curve.",
        ),
    ] = False,
    breakaway: Annotated[
        list[str] | None,
        typer.Option(
            metavar="AXIS=TORQUE",
            help="Approximate break-away torque, in place of the model's: it decides which torque counts as slow.",
        ),
    ] = None,
    column: Annotated[list[str] | None, typer.Option(metavar=COLUMN_PAIR, help=COLUMN_HELP)] = None,
    resample: Annotated[
        bool, typer.Option("--resample", help="Accept tables with uneven time and resample them.")
    ] = False,
    rate: Annotated[
        float | None, typer.Option(metavar="HZ", help="Put every log on a grid of this rate; implies --resample.")
    ] = None,
    drop_invalid: Annotated[
        bool, typer.Option("--drop-invalid", help="Accept tables with invalid rows and drop those.")
    ] = False,
    repair: Annotated[bool, typer.Option("--repair", help=REPAIR_HELP)] = False,
    workers: Annotated[int, typer.Option(help="Processes, an axis in each.", min=1)] = 2,
    seed: Annotated[int, typer.Option(help="Seed of the start points.")] = 0,
    as_json: Annotated[bool, typer.Option("--json", help="Print the answer as JSON.")] = False,
    force: Annotated[bool, typer.Option("--force", help="Overwrite what is in the folder.")] = False,
) -> int:
    """Friction parameters with confidence intervals, into a new model file; 1 when not a single one could be
    identified.
    """
    import json

    from firmware_protocol.errors import EXIT_DONE, EXIT_NO
    from gimbal_hil.data.signals import ColumnMap
    from gimbal_hil.knowledge.identification import Determination, identification_record
    from gimbal_hil.surface.cli.following import after_identify, print_next

    require_new(out, force, MODEL_FILE, ANSWER_FILE, REPORT_FILE)
    given, axes = _prior(model, axis, breakaway)
    reading = _Reading(torque_driven, resample, drop_invalid, rate, ColumnMap.of_words(column))
    results, notes = _identify(runs, given, axes, reading, repair, workers, seed, ramps_at_rest, as_json)
    record = identification_record(results, [str(path) for path in runs]) | {"notes": notes}
    _write(out, given, results, record)
    told = "\n".join([*_lines(results, out), *(f"note: {note}" for note in notes)])
    print(json.dumps(record, allow_nan=False) if as_json else told)
    found = any(e.verdict is Determination.IDENTIFIED for result in results for e in result.estimates)
    if not as_json:
        print_next(after_identify(out, runs, len(given.axes), found, column or ()))
    return EXIT_DONE if found else EXIT_NO


def _prior(
    model: str | None, axis: list[str] | None, breakaway: list[str] | None
) -> tuple[AntennaModel, tuple[str, ...]]:
    """The model that is begun from, and the axes to identify; BadInputError where one cannot be."""
    from gimbal_hil.knowledge.identification import axes_to_identify
    from gimbal_hil.surface.cli.torques import torques_by_axis
    from sim_backend.model import model_named, shipped_model

    given = model_named(model) if model else shipped_model()
    axes = axes_to_identify(given, axis, "--axis")
    for name, torque in torques_by_axis(breakaway, given.axes).items():
        given = given.with_numbers(name, {"friction.breakaway": torque})
    return given, axes


def _write(out: Path, given: AntennaModel, results: list[AxisIdentification], record: dict[str, Any]) -> None:
    import json

    from gimbal_hil.knowledge.identification import identification_page, updated_model

    _make_folder(out)
    (out / MODEL_FILE).write_text(updated_model(given, results).to_yaml(), encoding="utf-8")
    (out / ANSWER_FILE).write_text(json.dumps(record, indent=2, allow_nan=False) + "\n", encoding="utf-8")
    identification_page(given, results, record["sources"]).write(out / REPORT_FILE)


def _make_folder(out: Path) -> None:
    from firmware_protocol.errors import BadInputError

    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BadInputError(str(out), error.strerror or "cannot be made", "a folder that can be written to") from error


def _identify(
    runs: list[Path],
    model: AntennaModel,
    axes: tuple[str, ...],
    reading: _Reading,
    repair: bool,
    workers: int,
    seed: int,
    ramps_at_rest: bool,
    quiet: bool,
) -> tuple[list[AxisIdentification], list[str]]:
    """The answers, and what a reader must know of the logs."""
    from dataclasses import replace

    from rich.progress import Progress

    from gimbal_hil.data.preflight import preflight, questioned
    from gimbal_hil.knowledge.executor import open_executor
    from gimbal_hil.knowledge.identification import identify_axis, read_logs
    from gimbal_hil.surface.cli.progress import error_console

    console = error_console()
    with Progress(console=console, transient=True, disable=quiet or not console.is_terminal) as bar:
        task = bar.add_task("reading logs", total=len(runs) + len(axes))
        logs: list[Log] = []
        for path in runs:
            logs += read_logs(path, model, **vars(reading))
            bar.advance(task)
        tables = questioned(model, tuple(log.table for log in logs), repair)
        logs = [replace(log, table=table) for log, table in zip(logs, tables, strict=True)]
        preflight(model, tables)
        bar.update(task, description=f"identifying {' and '.join(axes)}")
        results = []
        with open_executor(workers) as executor:
            shared = executor.share(logs)
            for one in [executor.submit(identify_axis, shared, model, name, seed, ramps_at_rest) for name in axes]:
                results.append(one.result())
                bar.advance(task)
    return results, [f"{table.source}: {note}" for table in tables for note in table.notes]


def _lines(results: list[AxisIdentification], out: Path) -> list[str]:
    lines = []
    for result in results:
        lines.append(result.axis)
        for e in result.estimates:
            verdict = e.verdict.value.replace("_", " ")
            lines.append(f"  {e.name:<18} {e.value_text:>10}  ({e.interval_text}) {e.unit:<10} {verdict}")
            if e.reason:
                lines.append(f"  {'':<18} {e.reason}" + (f"; to settle it: {e.experiment}" if e.experiment else ""))
        lines += [f"  ! {finding.text}" for finding in result.findings]
        if worst := result.correlations.worst(result.axis):
            lines.append(f"  {worst}")
    return [*lines, f"report: {out / REPORT_FILE}", f"model:  {out / MODEL_FILE}"]
