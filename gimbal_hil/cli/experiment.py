"""`gimbal-hil experiment`: a sequence or a plan file, on the virtual antenna in lockstep or on whatever a daemon
controls.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from gimbal_hil.experiments import Outcome


def command(
    name: Annotated[
        str,
        typer.Argument(
            help="A plan file, thesis, or a sequence: step, sliding, presliding, gravity_map, sweep, base_motion, "
            "warm_up, survey, survey_holdout, plateaus, full_turn, creep, reversals, two_loads, one_locked, "
            "warm_and_cool."
        ),
    ],
    config: Annotated[
        Path | None, typer.Option(help="Configuration file; without it the shipped virtual antenna.")
    ] = None,
    model: Annotated[
        str | None,
        typer.Option(
            metavar="MODEL",
            help="Model (file or shipped name) of the embedded antenna, not the configuration's; with --run where "
            "torques come from.",
        ),
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Run folder; without it a new one below ./runs.")] = None,
    axis: Annotated[list[str] | None, typer.Option(help="Only this axis; may be repeated.")] = None,
    short: Annotated[bool, typer.Option("--short", help="The short variant of the sequence.")] = False,
    every: Annotated[
        int | None, typer.Option(help="Keep one tick in so many in the log (1 keeps frames too).", min=1)
    ] = None,
    base: Annotated[
        str | None,
        typer.Option(help="Base motion of base_motion: a case of the thesis (3.1/1 to 3.2/4) or a CSV file."),
    ] = None,
    breakaway: Annotated[
        list[str] | None,
        typer.Option(
            metavar="AXIS=N_M",
            help="Break-away torque as far as known: presliding torques are shares of it. May be repeated.",
        ),
    ] = None,
    seed: Annotated[
        int | None, typer.Option(help="Seed of the embedded antenna's noise, in place of the configuration's.", min=0)
    ] = None,
    lockstep: Annotated[
        bool, typer.Option("--lockstep/--real-time", help="Virtual time (the default), or a daemon in real time.")
    ] = True,
    run: Annotated[
        Path | None, typer.Option(help="Run folder of a running daemon: the experiment goes through it, in real time.")
    ] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Go on with the stopped experiment in --out.")] = False,
    force: Annotated[bool, typer.Option("--force", help="Overwrite what is in the folder.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as one JSON object.")] = False,
) -> int:
    """Run a sequence; leaves a run folder with log, table.csv and report.html."""
    import json
    import sys

    from firmware_protocol.errors import EXIT_INTERRUPTED, BadInputError
    from gimbal_hil.cli.progress import ProgressBar
    from gimbal_hil.experiments import CHECKPOINT_FILE, PARTS_FOLDER
    from gimbal_hil.runs import wall_clock_utc

    if not lockstep and run is None:
        raise BadInputError("--real-time", "does not say which daemon", "--run with the run folder of a running daemon")
    if resume and out is None:
        raise BadInputError("--resume", "does not say which run", "--out with the folder of the stopped experiment")
    folder = out or Path("runs") / f"{Path(name).stem}-{wall_clock_utc()[:19].replace(':', '').replace('-', '')}"
    if name == "thesis":
        return _thesis(folder, force, as_json)
    try:
        with ProgressBar(not as_json) as progress:
            outcome = (
                _conduct(
                    name, config, model, folder, axis, short, every, base, breakaway, seed, resume, force, progress
                )
                if run is None
                else _conduct_through_daemon(name, run, model, folder, axis, short, breakaway, resume, force, progress)
            )
    except KeyboardInterrupt:
        begun = (folder / CHECKPOINT_FILE).exists() or (folder / PARTS_FOLDER).is_dir()
        how = f"; the same command with --out {folder} --resume goes on after the last whole step" if begun else ""
        print(f"interrupted{how}", file=sys.stderr)
        return EXIT_INTERRUPTED
    if as_json:
        print(
            json.dumps(
                {"experiment": outcome.experiment.name, "run": str(folder), "rows": list(outcome.rows)}, allow_nan=False
            )
        )
    else:
        print(f"{outcome.experiment.text}: {len(outcome.rows)} rows")
        print(f"  table   {folder / 'table.csv'}\n  report  {folder / 'report.html'}")
        print(f"next: {_following(outcome.experiment.name, folder, config, model, run)}")
    return 0


def _following(name: str, folder: Path, config: Path | None, model: str | None, run: Path | None) -> str:
    """The command that one mostly wants after this experiment."""
    named = f" --model {model}" if model else ""
    where = "".join(f" --{option} {value}" for option, value in (("config", config), ("run", run)) if value) + named
    beside = folder.parent
    if name in ("sliding", "presliding"):
        return f"gimbal-hil identify {folder}{named} --out {beside / 'identified'}"
    if name == "survey":
        return f"gimbal-hil experiment survey_holdout{where} --out {beside / 'survey_holdout'}"
    if name == "survey_holdout":
        logs = f"--measured {beside / 'survey'} --holdout {folder}"
        return f"gimbal-hil discrepancy{named} {logs} --out {beside / 'verdict'}"
    return f"gimbal-hil experiment survey{where} --out {beside / 'survey'}"


def _conduct(
    name: str,
    config: Path | None,
    model: str | None,
    folder: Path,
    axis: list[str] | None,
    short: bool,
    every: int | None,
    base: str | None,
    breakaway: list[str] | None,
    seed: int | None,
    resume: bool,
    force: bool,
    progress: object,
) -> Outcome:
    from gimbal_hil.cli.torques import torques_by_axis
    from gimbal_hil.experiments import conduct, embedded_model_of
    from gimbal_hil.experiments.sequences import SequenceOptions, breakaway_torques, build_experiment
    from gimbal_hil.settings import load_settings, shipped_settings
    from sim_backend.model import model_named

    settings = load_settings(config) if config else shipped_settings()
    antenna, own_seed = embedded_model_of(settings)
    if model is not None:
        antenna = model_named(model)
    settings = settings.for_axes(antenna.axes, antenna.where)
    names = settings.axis_names
    known = breakaway_torques(antenna) | torques_by_axis(breakaway, names)
    experiment = build_experiment(
        name, SequenceOptions(settings.rate_hz, _axes(axis, names), short, every, known, base, names)
    )
    return conduct(
        experiment,
        settings,
        antenna,
        own_seed if seed is None else seed,
        folder,
        resume=resume,
        force=force,
        progress=progress,  # type: ignore[arg-type]
    )


def _conduct_through_daemon(
    name: str,
    run: Path,
    model: str | None,
    folder: Path,
    axis: list[str] | None,
    short: bool,
    breakaway: list[str] | None,
    resume: bool,
    force: bool,
    progress: object,
) -> Outcome:
    from gimbal_hil.cli.torques import torques_by_axis
    from gimbal_hil.experiments import conduct_through_daemon
    from gimbal_hil.experiments.sequences import SequenceOptions, breakaway_torques, build_experiment
    from gimbal_hil.runs import read_header
    from sim_backend.model import model_named

    header = read_header(run).header
    rate_hz, names = 1e9 / header.period_ns, header.axes
    known = (breakaway_torques(model_named(model)) if model else {}) | torques_by_axis(breakaway, names)
    # a real antenna's log is not thinned: it cannot be made again
    experiment = build_experiment(name, SequenceOptions(rate_hz, _axes(axis, names), short, 1, known, names=names))
    return conduct_through_daemon(experiment, run, folder, resume=resume, force=force, progress=progress)  # type: ignore[arg-type]


def _axes(asked: list[str] | None, names: tuple[str, str]) -> tuple[str, ...]:
    from firmware_protocol.errors import BadInputError

    for name in asked or ():
        if name not in names:
            raise BadInputError("--axis", f"no axis {name!r}", " or ".join(names))
    return tuple(dict.fromkeys(asked)) if asked else names


def _thesis(folder: Path, force: bool, as_json: bool) -> int:
    import json

    from gimbal_hil.cli.progress import ProgressBar
    from gimbal_hil.thesis import as_document, as_text, run_thesis

    with ProgressBar(not as_json) as bar:
        bar.begin("thesis", 1.0, 0.0)
        told = 0.0

        def tell(what: str, share: float) -> None:
            nonlocal told
            bar.at(what, share - told)
            told = share

        report = run_thesis(folder, force, tell)
    print(json.dumps(as_document(report), allow_nan=False) if as_json else as_text(report))
    if not as_json:
        print(f"  report  {report.page}")
    return 0 if report.within_bounds else 1
