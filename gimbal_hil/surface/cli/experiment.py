"""`gimbal-hil experiment`: a sequence or a plan file, on the virtual antenna in lockstep or on whatever a daemon
controls.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gimbal_hil.surface.cli.completion import model_names, one_of

if TYPE_CHECKING:
    from gimbal_hil.knowledge.experiments import Outcome
    from gimbal_hil.surface.cli.progress import ProgressBar


#: those of the registry, which --help and completion do not wait for
_SEQUENCES = (
    "step", "sliding", "presliding", "gravity_map", "sweep", "base_motion", "warm_up", "survey", "survey_holdout",
    "plateaus", "full_turn", "creep", "reversals", "two_loads", "one_locked", "warm_and_cool",
)  # fmt: skip


@dataclass(frozen=True)
class _Wanted:
    """What is wanted whoever conducts the experiment: the options of the same names."""

    name: str
    model: str | None
    folder: Path
    axis: list[str] | None
    short: bool
    breakaway: list[str] | None
    resume: bool
    force: bool


def command(
    name: Annotated[
        str,
        typer.Argument(
            help=f"A plan file, thesis, or a sequence: {', '.join(_SEQUENCES)}.", autocompletion=one_of(*_SEQUENCES)
        ),
    ],
    config: Annotated[
        Path | None, typer.Option(help="Configuration file; without it the shipped virtual antenna.")
    ] = None,
    model: Annotated[
        str | None,
        typer.Option(
            metavar="MODEL",
            autocompletion=model_names,
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
    import sys

    from firmware_protocol.errors import EXIT_INTERRUPTED
    from gimbal_hil.knowledge.experiments import CHECKPOINT_FILE, PARTS_FOLDER
    from gimbal_hil.pages.report import counted
    from gimbal_hil.surface.cli.following import after_experiment, print_next
    from gimbal_hil.surface.cli.progress import ProgressBar

    folder = _folder(name, out, run, lockstep, resume)
    if name == "thesis":
        return _thesis(folder, force, as_json)
    wanted = _Wanted(name, model, folder, axis, short, breakaway, resume, force)
    try:
        with ProgressBar(not as_json) as progress:
            if run is None:
                outcome = _conduct(wanted, config, every, base, seed, progress)
            else:
                outcome = _conduct_through_daemon(wanted, run, progress)
    except KeyboardInterrupt:
        begun = (folder / CHECKPOINT_FILE).exists() or (folder / PARTS_FOLDER).is_dir()
        how = f"; the same command with --out {folder} --resume goes on after the last whole step" if begun else ""
        print(f"interrupted{how}", file=sys.stderr)
        return EXIT_INTERRUPTED
    if as_json:
        _print_json(outcome, folder)
    else:
        print(f"{outcome.experiment.text}: {counted(len(outcome.rows), 'row')}")
        print(f"  table   {folder / 'table.csv'}\n  report  {folder / 'report.html'}")
        print_next(after_experiment(outcome.experiment.name, folder, config, model, run, short))
    return 0


def _folder(name: str, out: Path | None, run: Path | None, lockstep: bool, resume: bool) -> Path:
    """Where the run goes; BadInputError where the options do not go together."""
    from firmware_protocol.errors import BadInputError
    from gimbal_hil.loop.timing import wall_clock_utc

    if not lockstep and run is None:
        raise BadInputError("--real-time", "does not say which daemon", "--run with the run folder of a running daemon")
    if resume and out is None:
        raise BadInputError("--resume", "does not say which run", "--out with the folder of the stopped experiment")
    return out or Path("runs") / f"{Path(name).stem}-{wall_clock_utc()[:19].replace(':', '').replace('-', '')}"


def _print_json(outcome: Outcome, folder: Path) -> None:
    import json

    document = {"experiment": outcome.experiment.name, "run": str(folder), "rows": list(outcome.rows)}
    print(json.dumps(document, allow_nan=False))


def _conduct(
    wanted: _Wanted, config: Path | None, every: int | None, base: str | None, seed: int | None, progress: ProgressBar
) -> Outcome:
    from gimbal_hil.knowledge.experiments import conduct, embedded_model_of
    from gimbal_hil.knowledge.experiments.sequences import SequenceOptions, breakaway_torques, build_experiment
    from gimbal_hil.loop.settings import load_settings, shipped_settings
    from gimbal_hil.surface.cli.torques import torques_by_axis
    from sim_backend.model import model_named

    settings = load_settings(config) if config else shipped_settings()
    antenna, own_seed = embedded_model_of(settings)
    if wanted.model is not None:
        antenna = model_named(wanted.model)
    settings = settings.for_axes(antenna.axes, antenna.where)
    names = settings.axis_names
    known = breakaway_torques(antenna) | torques_by_axis(wanted.breakaway, names)
    axes = axes_named(wanted.axis, names)
    options = SequenceOptions(settings.rate_hz, axes, wanted.short, every, known, base, names)
    experiment = build_experiment(wanted.name, options)
    return conduct(
        experiment,
        settings,
        antenna,
        own_seed if seed is None else seed,
        wanted.folder,
        resume=wanted.resume,
        force=wanted.force,
        progress=progress,
    )


def _conduct_through_daemon(wanted: _Wanted, run: Path, progress: ProgressBar) -> Outcome:
    from gimbal_hil.data.runs import read_header
    from gimbal_hil.knowledge.experiments import conduct_through_daemon
    from gimbal_hil.knowledge.experiments.sequences import SequenceOptions, breakaway_torques, build_experiment
    from gimbal_hil.surface.cli.torques import torques_by_axis
    from sim_backend.model import model_named

    header = read_header(run).header
    rate_hz, names = 1e9 / header.period_ns, header.axes
    known = (breakaway_torques(model_named(wanted.model)) if wanted.model else {}) | torques_by_axis(
        wanted.breakaway, names
    )
    # a real antenna's log is not thinned: it cannot be made again
    options = SequenceOptions(rate_hz, axes_named(wanted.axis, names), wanted.short, 1, known, names=names)
    experiment = build_experiment(wanted.name, options)
    return conduct_through_daemon(
        experiment, run, wanted.folder, resume=wanted.resume, force=wanted.force, progress=progress
    )


def axes_named(asked: list[str] | None, names: tuple[str, str]) -> tuple[str, ...]:
    """The axes that `--axis` names, all where it names none; BadInputError for another name."""
    from firmware_protocol.errors import BadInputError

    for name in asked or ():
        if name not in names:
            raise BadInputError("--axis", f"no axis {name!r}", " or ".join(names))
    return tuple(dict.fromkeys(asked)) if asked else names


def _thesis(folder: Path, force: bool, as_json: bool) -> int:
    import json

    from gimbal_hil.proof.thesis import as_document, as_text, run_thesis
    from gimbal_hil.surface.cli.progress import ProgressBar

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
