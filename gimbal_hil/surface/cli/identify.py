"""`gimbal-hil identify`: friction from recorded runs, with an interval and a verdict for every number."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from firmware_protocol.json_object import Json
from firmware_protocol.places import require_new
from gimbal_hil.surface.cli.completion import model_names
from gimbal_hil.surface.cli.log_options import LogOptions

if TYPE_CHECKING:
    from rich.progress import Progress

    from gimbal_hil.knowledge.identification import AxisIdentification, Log, TemperatureResult
    from sim_backend.model import AntennaModel

#: options that take several values after one another
MANY_VALUED = ("--column",)
MODEL_FILE, ANSWER_FILE, REPORT_FILE = "model.yaml", "identification.json", "report.html"
TABLE_FILE = "over_temperature.csv"


@dataclass(frozen=True)
class FrictionOptions:
    """Which axes, and what is known of how they were driven."""

    axis: Annotated[list[str] | None, typer.Option(help="Identify this axis only; may be repeated.")] = None
    torque_driven: Annotated[
        bool,
        typer.Option(
            "--torque-driven",
            help="Tables without references were recorded under direct torque: use them for presliding and output "
            "error.",
        ),
    ] = False
    ramps_at_rest: Annotated[
        bool,
        typer.Option(
            "--ramps-at-rest",
            help="Break-away torques of slow ramps are points at rest of the friction-velocity curve.",
        ),
    ] = False
    breakaway: Annotated[
        list[str] | None,
        typer.Option(
            metavar="AXIS=TORQUE",
            help="Approximate break-away torque, in place of the model's: it decides which torque counts as slow.",
        ),
    ] = None
    over_temperature: Annotated[
        bool,
        typer.Option(
            "--over-temperature",
            help="Runs at several temperatures: identify each temperature by itself and write a table of friction over "
            "temperature, with intervals.",
        ),
    ] = False


@dataclass(frozen=True)
class IdentifyEffort:
    """How many processes compute, and where they begin."""

    workers: Annotated[int, typer.Option(help="Processes, an axis in each.", min=1)] = 2
    seed: Annotated[int, typer.Option(help="Seed of the start points.")] = 0


def command(
    *,
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
            help="Prior and rigid body: a model file or a shipped name; without it the shipped model thesis.",
        ),
    ] = None,
    friction: FrictionOptions,
    reading: LogOptions,
    effort: IdentifyEffort,
    as_json: Annotated[bool, typer.Option("--json", help="Print the answer as JSON.")] = False,
    force: Annotated[bool, typer.Option("--force", help="Overwrite what is in the folder.")] = False,
) -> int:
    """Friction parameters with confidence intervals, into a new model file; 1 when not a single one could be
    identified.
    """
    import json

    from firmware_protocol.errors import EXIT_DONE, EXIT_NO
    from gimbal_hil.knowledge.identification import (
        IN_TURNS,
        Determination,
        has_table,
        identification_record,
        table_record,
    )
    from gimbal_hil.surface.cli.following_logs import after_identify
    from gimbal_hil.surface.cli.next_line import print_next

    require_new(out, force, MODEL_FILE, ANSWER_FILE, REPORT_FILE)
    given, axes = _prior(model, friction.axis, friction.breakaway)
    logs, notes = _logs(runs, given, reading, friction.torque_driven, quiet=as_json)
    tabled = friction.over_temperature or has_table(given)
    groups = _groups(logs, given, tabled)
    found_in = _identify(groups, axes, effort, friction.ramps_at_rest, quiet=as_json)
    results = [result for one in found_in for result in one.results]
    record = identification_record(found_in[0].results, [str(path) for path in runs]) | {"notes": notes}
    if tabled:
        record["over_temperature"] = table_record(found_in)
    _write(out, given, found_in, record, tabled)
    told = "\n".join([*_told(found_in, tabled), *_files(out, tabled), *(f"note: {note}" for note in notes)])
    print(json.dumps(record, allow_nan=False) if as_json else told)
    found = any(e.verdict is Determination.IDENTIFIED for result in results for e in result.estimates)
    if not as_json:
        turned = [result.axis for result in results if any(one.rule == IN_TURNS for one in result.findings)]
        columns, axes_known = reading.column or (), len(given.axes)
        print_next(after_identify(out, runs, axes_known, found, columns, turned, model, reading.repairs))
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


def _groups(logs: list[Log], model: AntennaModel, tabled: bool) -> list[tuple[float, AntennaModel, list[Log]]]:
    """Temperature (degC), prior and logs of what is identified by itself: all together where there is no table."""
    import math

    from gimbal_hil.knowledge.identification import at_temperature, grouped, require_a_table

    if not tabled:
        return [(math.nan, model, logs)]
    groups = grouped(logs, model.axes)
    require_a_table(model, groups)
    return [(one.temperature_degc, at_temperature(model, one.temperature_degc), list(one.logs)) for one in groups]


def _write(out: Path, given: AntennaModel, found: list[TemperatureResult], record: Json, tabled: bool) -> None:
    import json

    from gimbal_hil.knowledge.identification import (
        identification_page,
        over_temperature_page,
        table_csv,
        updated_model,
        with_rows,
    )

    model = with_rows(given, found) if tabled else updated_model(given, found[0].results)
    _make_folder(out)
    (out / MODEL_FILE).write_text(model.to_yaml(), encoding="utf-8")
    (out / ANSWER_FILE).write_text(json.dumps(record, indent=2, allow_nan=False) + "\n", encoding="utf-8")
    if tabled:
        (out / TABLE_FILE).write_text(table_csv(found), encoding="utf-8")
        over_temperature_page(model, found, record["sources"]).write(out / REPORT_FILE)
    else:
        identification_page(given, found[0].results, record["sources"]).write(out / REPORT_FILE)


def _told(found: list[TemperatureResult], tabled: bool) -> list[str]:
    """What was found, for the terminal."""
    from gimbal_hil.knowledge.identification import over_temperature_lines

    return over_temperature_lines(found) if tabled else _lines(found[0].results)


def _files(out: Path, tabled: bool) -> list[str]:
    table = [f"table:  {out / TABLE_FILE}"] if tabled else []
    return [f"report: {out / REPORT_FILE}", f"model:  {out / MODEL_FILE}", *table]


def _make_folder(out: Path) -> None:
    from firmware_protocol.errors import BadInputError

    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BadInputError(str(out), error.strerror or "cannot be made", "a folder that can be written to") from error


def _logs(
    runs: list[Path], model: AntennaModel, options: LogOptions, torque_driven: bool, *, quiet: bool
) -> tuple[list[Log], list[str]]:
    """All logs, questioned, and what a reader must know of them."""
    from dataclasses import replace

    from gimbal_hil.data.preflight import preflight, questioned
    from gimbal_hil.knowledge.identification import read_logs

    reading = options.reading()
    logs: list[Log] = []
    with _progress(quiet) as bar:
        task = bar.add_task("reading logs", total=len(runs))
        for path in runs:
            logs += read_logs(path, model, reading, torque_driven=torque_driven)
            bar.advance(task)
        tables = questioned(model, tuple(log.table for log in logs), reading.repair)
    preflight(model, tables)
    sources: dict[str, list[str]] = {}
    for table in tables:
        for note in table.notes:
            sources.setdefault(note, []).append(table.source)
    notes = [f"{', '.join(where)}: {note}" for note, where in sources.items()]
    return [replace(log, table=table) for log, table in zip(logs, tables, strict=True)], notes


def _identify(
    groups: list[tuple[float, AntennaModel, list[Log]]],
    axes: tuple[str, ...],
    effort: IdentifyEffort,
    ramps_at_rest: bool,
    *,
    quiet: bool,
) -> list[TemperatureResult]:
    from gimbal_hil.knowledge.executor import open_executor
    from gimbal_hil.knowledge.identification import TemperatureResult, identify_axis

    results = []
    with _progress(quiet) as bar, open_executor(effort.workers) as executor:
        task = bar.add_task(f"identifying {' and '.join(axes)}", total=len(groups) * len(axes))
        for degc, prior, logs in groups:
            shared, found = executor.share(logs), []
            for one in [
                executor.submit(identify_axis, shared, prior, name, effort.seed, ramps_at_rest) for name in axes
            ]:
                found.append(one.result())
                bar.advance(task)
            results.append(TemperatureResult(degc, prior, tuple(found)))
    return results


def _progress(quiet: bool) -> Progress:
    from rich.progress import Progress

    from gimbal_hil.surface.cli.progress import error_console

    console = error_console()
    return Progress(console=console, transient=True, disable=quiet or not console.is_terminal)


def _lines(results: Sequence[AxisIdentification]) -> list[str]:
    lines = []
    for result in results:
        lines.append(result.axis)
        # where nothing was found there is no interval, and the value is the model's
        within = [f"({e.interval_text}) " if e.fitted_ends else "" for e in result.estimates]
        told = [f"{text}{'' if e.unit == '1' else e.unit}" for text, e in zip(within, result.estimates, strict=True)]
        width = max(map(len, told), default=0)
        for e, text in zip(result.estimates, told, strict=True):
            verdict = e.verdict.value.replace("_", " ")
            lines.append(f"  {e.name:<18} {e.value_text:>10}  {text:<{width}}  {verdict}")
            if e.reason:
                lines.append(f"  {'':<18} {e.reason}" + (f"; to settle it: {e.experiment}" if e.experiment else ""))
        lines += [f"  ! {finding.text}" for finding in result.findings]
        if worst := result.correlations.worst(result.axis):
            lines.append(f"  {worst}")
    return lines
