"""`gimbal-hil improve`: experiment, diagnose and correct until the model is at the noise floor or has to give up."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from firmware_protocol.places import require_new
from gimbal_hil.surface.cli.completion import model_names

if TYPE_CHECKING:
    from gimbal_hil.knowledge.improvement import Improvement, Journal, Site, Task
    from gimbal_hil.loop.settings import DaemonSettings
    from gimbal_hil.surface.cli.progress import ProgressBar
    from sim_backend.model import AntennaModel

RESULT_FILE, MODEL_FILE, REPORT_FILE = "improve.json", "model.yaml", "report.html"


@dataclass(frozen=True)
class LimitOptions:
    """What the experiments must keep within."""

    rounds: Annotated[int, typer.Option(help="Rounds (a diagnosis each) at most.", min=1)] = 6
    budget: Annotated[float, typer.Option(help="Antenna time at most, s.", min=1.0)] = 900.0
    torque: Annotated[
        list[str] | None, typer.Option(metavar="AXIS=NM", help="Largest torque, N m; may be repeated.")
    ] = None
    travel: Annotated[
        list[str] | None, typer.Option(metavar="AXIS=LOW..HIGH", help="Travel, rad; may be repeated.")
    ] = None


@dataclass(frozen=True)
class SurveyOptions:
    """How long a survey is, and where its diagnosis is computed."""

    survey: Annotated[float, typer.Option(help="Length of each survey motion, s.", min=10.0)] = 60.0
    short: Annotated[bool, typer.Option("--short", help="Surveys of 24 s.")] = False
    workers: Annotated[int, typer.Option(help="Processes that score candidates.", min=1)] = 2
    dask: Annotated[str | None, typer.Option(metavar="ADDRESS", help="Score candidates on a Dask cluster instead.")] = (
        None
    )

    @property
    def length_s(self) -> float:
        """Of each motion of a survey."""
        from gimbal_hil.knowledge.experiments.sequences import SHORT_SURVEY_S

        return SHORT_SURVEY_S if self.short else self.survey


@dataclass(frozen=True)
class BeginningOptions:
    """Which antenna is improved, and the model that is begun with."""

    config: Annotated[
        Path | None, typer.Option(help="Configuration that names the antenna; without it the shipped virtual one.")
    ] = None
    run: Annotated[
        Path | None, typer.Option(help="Run folder of a running daemon: experiments go through it, in real time.")
    ] = None
    model: Annotated[
        str | None,
        typer.Option(
            metavar="MODEL",
            autocompletion=model_names,
            help="Model to start from, or name of a shipped one; without it the one that --config names, or thesis.",
        ),
    ] = None


def command(
    *,
    out: Annotated[
        Path,
        typer.Option(metavar="DIR", help="Folder for the runs, journal.jsonl, report.html, model.yaml, improve.json."),
    ],
    begun: BeginningOptions,
    limits: LimitOptions,
    surveys: SurveyOptions,
    resume: Annotated[bool, typer.Option("--resume", help="Go on with the stopped improvement in --out.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as one JSON object.")] = False,
    force: Annotated[bool, typer.Option("--force", help="Overwrite what is in the folder.")] = False,
) -> int:
    """Run experiments on the antenna itself until the model is at the noise floor (0), or say what is left (1).

    Ctrl-C or SIGTERM brings the joints back, switches torque off, ends with 130; --resume goes on with the finished
    runs kept.
    """
    from firmware_protocol.errors import EXIT_DONE, EXIT_NO
    from gimbal_hil.knowledge.improvement import (
        JOURNAL_FILE,
        Ending,
        Journal,
        Stopped,
        Task,
        budgets_of,
        site_of,
        torques_of,
        travels_of,
    )
    from gimbal_hil.surface.cli.following_logs import after_improve
    from gimbal_hil.surface.cli.next_line import print_next
    from gimbal_hil.surface.cli.progress import ProgressBar

    _refuse_what_stands_there(out, resume, force)
    settings, start = _begun_from(begun.config, begun.model)
    budgets = budgets_of(
        settings, limits.budget, limits.rounds, torques_of(limits.torque or []), travels_of(limits.travel or [])
    )
    task = Task(settings, start, out, budgets, surveys.length_s, surveys.workers, surveys.dask)
    journal = Journal(out / JOURNAL_FILE, resume=resume)
    _end_like_ctrl_c()
    try:
        _open_session(journal, task, resume)
        with ProgressBar(not as_json) as progress, site_of(settings, begun.config, out, begun.run, resume) as site:
            done = _improve(task, site, journal, progress, as_json)
    except BaseException as stop:
        journal.write(Stopped(_reason(stop), _used_s(journal)))
        _write_report(task, journal)
        raise
    finally:
        journal.close()
    _write_results(task, journal, done, as_json)
    if not as_json:
        hidden = [one["name"] for one in done.diagnoses[-1].would_not_show] if done.diagnoses else []
        print_next(after_improve(out, begun.config, done.ending is Ending.AT_THE_FLOOR, begun.run, hidden))
    return EXIT_DONE if done.ending is Ending.AT_THE_FLOOR else EXIT_NO


def _begun_from(config: Path | None, model: str | None) -> tuple[DaemonSettings, AntennaModel]:
    from gimbal_hil.loop.settings import load_settings, shipped_settings
    from sim_backend.model import model_named, shipped_model

    settings = load_settings(config) if config else shipped_settings()
    named = model or (settings.observer.model if config else None)
    start = model_named(named) if named else shipped_model()
    return settings.for_axes(start.axes, start.where), start


def _refuse_what_stands_there(out: Path, resume: bool, force: bool) -> None:
    from firmware_protocol.errors import BadInputError
    from gimbal_hil.knowledge.improvement import JOURNAL_FILE

    if resume and force:
        raise BadInputError("--resume", "keeps what is there, --force does not", "one of the two")
    require_new(out, resume or force, JOURNAL_FILE, instead="a new folder, --resume to go on")


def _end_like_ctrl_c() -> None:
    """SIGTERM and SIGHUP bring the joints back as Ctrl-C does; they would otherwise leave a daemon behind that goes
    on.
    """
    import signal
    import threading

    def interrupt(_number: int, _frame: object) -> None:
        raise KeyboardInterrupt

    if threading.current_thread() is threading.main_thread():
        for number in (signal.SIGTERM, signal.SIGHUP):
            signal.signal(number, interrupt)


def _improve(task: Task, site: Site, journal: Journal, progress: ProgressBar, as_json: bool) -> Improvement:
    from gimbal_hil.knowledge.improvement import improve

    def say(line: str) -> None:
        if not as_json:
            print(line, flush=True)

    say(f"experiments go to {site.text}")
    return improve(task, site, journal, progress=progress, say=say)


def _open_session(journal: Journal, task: Task, resume: bool) -> None:
    """The journal's first line, or the check that a stopped improvement goes on as it began."""
    from firmware_protocol.errors import BadInputError
    from gimbal_hil.knowledge.improvement import Resumed, Started, session_of

    session = session_of(task)
    if not resume:
        journal.write(Started(session))
        return
    first = journal.entries[0] if journal.entries else None
    if not isinstance(first, Started):
        raise BadInputError(
            str(journal.path), "does not say how the improvement began", "the journal of a stopped improvement"
        )
    for key, value in session.items():
        if first.session.get(key) != value:
            raise BadInputError(
                f"--resume: {key}", "is not what the improvement began with", "the same options as then"
            )
    journal.write(Resumed(len(journal.entries)))


def _reason(stop: BaseException) -> str:
    return "interrupted" if isinstance(stop, KeyboardInterrupt) else f"{type(stop).__name__}: {stop}"


def _used_s(journal: Journal) -> float:
    from gimbal_hil.knowledge.improvement import Measured

    return max((e.antenna_s for e in journal.entries if isinstance(e, Measured)), default=0.0)


def _write_report(task: Task, journal: Journal) -> None:
    from gimbal_hil.knowledge.improvement import Measured, improvement_page

    if any(isinstance(entry, Measured) for entry in journal.entries):
        improvement_page(task, journal.entries).write(task.out / REPORT_FILE)


def _write_results(task: Task, journal: Journal, done: Improvement, as_json: bool) -> None:
    import json
    from dataclasses import asdict

    record = {
        "schema": 1,
        "ending": done.ending.word,
        "text": done.text,
        "antenna_s": done.antenna_s,
        "rounds": [asdict(one) for one in done.diagnoses],
    }
    (task.out / RESULT_FILE).write_text(json.dumps(record, indent=2, allow_nan=False) + "\n", encoding="utf-8")
    (task.out / MODEL_FILE).write_text(done.model.to_yaml(), encoding="utf-8")
    _write_report(task, journal)
    if as_json:
        print(json.dumps(record, allow_nan=False))
    else:
        print(
            f"{done.antenna_s:.0f} s of antenna time; model: {task.out / MODEL_FILE}; report: {task.out / REPORT_FILE}"
        )
