"""`gimbal-hil experiment`: a sequence or a plan file, on the virtual antenna in lockstep or on whatever a daemon
controls.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gimbal_hil.surface.cli.completion import model_names, one_of

if TYPE_CHECKING:
    from gimbal_hil.knowledge.experiments import Outcome
    from gimbal_hil.surface.cli.origin import LogOrigin


#: those of the registry, which --help and completion do not wait for
_SEQUENCES = (
    "step", "sliding", "presliding", "gravity_map", "sweep", "base_motion", "warm_up", "survey", "survey_holdout",
    "plateaus", "full_turn", "creep", "reversals", "two_loads", "one_locked", "warm_and_cool",
)  # fmt: skip


@dataclass(frozen=True)
class ExperimentOptions:
    """What is done, and to which antenna."""

    config: Annotated[Path | None, typer.Option(help="Configuration file; without it the shipped virtual antenna.")] = (
        None
    )
    model: Annotated[
        str | None,
        typer.Option(
            metavar="MODEL",
            autocompletion=model_names,
            help="Model (file or shipped name) of the embedded antenna, not the configuration's; with --run --known.",
        ),
    ] = None
    known: Annotated[
        str | None,
        typer.Option(
            metavar="MODEL",
            autocompletion=model_names,
            help="Model that you have of the antenna: torques come from it, and what is printed as next asks about it.",
        ),
    ] = None
    axis: Annotated[list[str] | None, typer.Option(help="Only this axis; may be repeated.")] = None
    short: Annotated[bool, typer.Option("--short", help="The short variant of the sequence.")] = False
    every: Annotated[
        int | None, typer.Option(help="Keep one tick in so many in the log (1 keeps frames too).", min=1)
    ] = None
    base: Annotated[
        str | None,
        typer.Option(help="Base motion of base_motion: a case of the thesis (3.1/1 to 3.2/4) or a CSV file."),
    ] = None
    breakaway: Annotated[
        list[str] | None,
        typer.Option(
            metavar="AXIS=N_M",
            help="Break-away torque as far as known: presliding torques are shares of it. May be repeated.",
        ),
    ] = None
    seed: Annotated[
        int | None, typer.Option(help="Seed of the embedded antenna's noise, in place of the configuration's.", min=0)
    ] = None

    def has_of_the_antenna(self, run: Path | None) -> str | None:
        """The model that is asked about the antenna: a daemon's is not made of one."""
        return self.known or (None if run is None else self.model)

    def origin(self, run: Path | None) -> LogOrigin:
        """Which antenna is moved."""
        from gimbal_hil.surface.cli.origin import LogOrigin

        return LogOrigin(self.config, run, None if run is not None else self.model)


@dataclass(frozen=True)
class RunOptions:
    """Where it goes, and what is there already."""

    out: Annotated[Path | None, typer.Option(help="Run folder; without it a new one below ./runs.")] = None
    resume: Annotated[bool, typer.Option("--resume", help="Go on with the stopped experiment in --out.")] = False
    force: Annotated[bool, typer.Option("--force", help="Overwrite what is in the folder.")] = False


def command(
    name: Annotated[
        str,
        typer.Argument(
            help=f"A plan file, thesis, or a sequence: {', '.join(_SEQUENCES)}.", autocompletion=one_of(*_SEQUENCES)
        ),
    ],
    *,
    asked: ExperimentOptions,
    lockstep: Annotated[
        bool, typer.Option("--lockstep/--real-time", help="Virtual time (the default), or a daemon in real time.")
    ] = True,
    run: Annotated[
        Path | None, typer.Option(help="Run folder of a running daemon: the experiment goes through it, in real time.")
    ] = None,
    leaving: RunOptions,
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as one JSON object.")] = False,
) -> int:
    """Run a sequence; leaves a run folder with log, table.csv and report.html."""
    import sys

    from firmware_protocol.errors import EXIT_INTERRUPTED
    from gimbal_hil.knowledge.experiments import CHECKPOINT_FILE, PARTS_FOLDER
    from gimbal_hil.pages.report import counted
    from gimbal_hil.surface.cli.following_logs import after_experiment
    from gimbal_hil.surface.cli.next_line import print_next
    from gimbal_hil.surface.cli.progress import ProgressBar

    folder = _folder(name, leaving, run, lockstep)
    if name == "thesis":
        return _thesis(folder, leaving.force, as_json)
    try:
        with ProgressBar(not as_json) as progress:
            if run is None:
                conducted = _in_lockstep(name, asked)
            else:
                conducted = _through_daemon(name, asked, run)
            outcome = conducted(folder, resume=leaving.resume, force=leaving.force, progress=progress)
    except KeyboardInterrupt:
        begun = (folder / CHECKPOINT_FILE).exists() or (folder / PARTS_FOLDER).is_dir()
        how = f"; the same command with --out {folder} --resume goes on after the last whole step" if begun else ""
        print(f"interrupted{how}", file=sys.stderr)
        return EXIT_INTERRUPTED
    if as_json:
        _print_json(outcome, folder)
    else:
        print(outcome.experiment.text)
        for line in _findings(outcome):
            print(f"  {line}")
        print(f"  table   {folder / 'table.csv'} ({counted(len(outcome.rows), 'row')})")
        print(f"  report  {folder / 'report.html'}")
        known = asked.has_of_the_antenna(run)
        print_next(after_experiment(outcome.experiment.name, folder, asked.origin(run), known, asked.short))
    return 0


def _findings(outcome: Outcome) -> list[str]:
    """What the report says first of each part, under the name of the part."""
    from gimbal_hil.pages.report import Callout, Heading

    found, part = [], ""
    for block in outcome.blocks:
        if isinstance(block, Heading):
            part = f"{block.text}: "
        elif isinstance(block, Callout):
            found.append(f"{part}{block.text}")
    return found


def _folder(name: str, leaving: RunOptions, run: Path | None, lockstep: bool) -> Path:
    """Where the run goes; BadInputError where the options do not go together."""
    from firmware_protocol.errors import BadInputError
    from gimbal_hil.loop.timing import wall_clock_utc

    if not lockstep and run is None:
        raise BadInputError("--real-time", "does not say which daemon", "--run with the run folder of a running daemon")
    if leaving.resume and leaving.out is None:
        raise BadInputError("--resume", "does not say which run", "--out with the folder of the stopped experiment")
    return leaving.out or Path("runs") / f"{Path(name).stem}-{wall_clock_utc()[:19].replace(':', '').replace('-', '')}"


def _print_json(outcome: Outcome, folder: Path) -> None:
    import json

    document = {"experiment": outcome.experiment.name, "run": str(folder), "rows": list(outcome.rows)}
    print(json.dumps(document, allow_nan=False))


def _in_lockstep(name: str, asked: ExperimentOptions) -> Callable[..., Outcome]:
    """The experiment on the embedded antenna, ready to be conducted."""
    from gimbal_hil.knowledge.experiments import conduct, embedded_model_of
    from gimbal_hil.knowledge.experiments.sequences import SequenceOptions, breakaway_torques, build_experiment
    from gimbal_hil.loop.settings import load_settings, shipped_settings
    from gimbal_hil.surface.cli.torques import torques_by_axis
    from sim_backend.model import model_named

    settings = load_settings(asked.config) if asked.config else shipped_settings()
    antenna, own_seed = embedded_model_of(settings)
    if asked.model is not None:
        antenna = model_named(asked.model)
    settings = settings.for_axes(antenna.axes, antenna.where)
    names = settings.axis_names
    known = breakaway_torques(model_named(asked.known) if asked.known else antenna)
    known |= torques_by_axis(asked.breakaway, names)
    axes = axes_named(asked.axis, names)
    options = SequenceOptions(settings.rate_hz, axes, asked.short, asked.every, known, asked.base, names)
    seed = own_seed if asked.seed is None else asked.seed
    return partial(conduct, build_experiment(name, options), settings, antenna, seed)


def _through_daemon(name: str, asked: ExperimentOptions, run: Path) -> Callable[..., Outcome]:
    """The experiment on whatever a daemon controls, ready to be conducted."""
    from gimbal_hil.data.runs import read_header
    from gimbal_hil.knowledge.experiments import conduct_through_daemon
    from gimbal_hil.knowledge.experiments.sequences import SequenceOptions, breakaway_torques, build_experiment
    from gimbal_hil.surface.cli.torques import torques_by_axis
    from sim_backend.model import model_named

    header = read_header(run).header
    rate_hz, names = 1e9 / header.period_ns, header.axes
    model = asked.has_of_the_antenna(run)
    known = (breakaway_torques(model_named(model)) if model else {}) | torques_by_axis(asked.breakaway, names)
    # a real antenna's log is not thinned: it cannot be made again
    options = SequenceOptions(rate_hz, axes_named(asked.axis, names), asked.short, 1, known, names=names)
    return partial(conduct_through_daemon, build_experiment(name, options), run)


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
