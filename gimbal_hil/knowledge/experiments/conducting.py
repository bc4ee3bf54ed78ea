"""From a configuration to a finished experiment folder: log, table, report."""

from __future__ import annotations

import sys
from contextlib import closing
from dataclasses import replace
from functools import partial
from pathlib import Path

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.runs import RunHeader
from gimbal_hil.knowledge.experiments.antenna import LockstepAntenna
from gimbal_hil.knowledge.experiments.checkpoint import remove_checkpoint
from gimbal_hil.knowledge.experiments.daemon_antenna import DaemonAntenna
from gimbal_hil.knowledge.experiments.experiment import Experiment
from gimbal_hil.knowledge.experiments.runner import Outcome, ProgressSink, run_experiment, table_csv
from gimbal_hil.knowledge.experiments.side_by_side import remove_parts, run_side_by_side
from gimbal_hil.loop.settings import DaemonSettings, EmbeddedAntenna
from gimbal_hil.pages.report import Details, Listing, Page
from sim_backend.firmware_run import FirmwareRun
from sim_backend.model import AntennaModel, ModelKind, model_named

TABLE_FILE, REPORT_FILE = "table.csv", "report.html"


def embedded_model_of(settings: DaemonSettings) -> tuple[AntennaModel, int]:
    """Model and seed of the virtual antenna that the configuration names; BadInputError where it names a real link."""
    link = settings.link
    if not isinstance(link, EmbeddedAntenna):
        raise BadInputError(
            "link",
            f"is {link.kind}, which has no time of its own to wait",
            "an embedded antenna for --lockstep, or a daemon with --run",
        )
    named = link.embedded
    return model_named(named.model, "link.embedded.model"), named.seed


def run_header(settings: DaemonSettings, model: AntennaModel, seed: int, title: str, every: int) -> RunHeader:
    """Header of an experiment's run folder on the virtual antenna."""
    recording = settings.recording.model_copy(update={"frames": every == 1, "every_ticks": every})
    return RunHeader(
        configuration=settings.model_copy(update={"recording": recording}).model_dump(mode="json", by_alias=True),
        model=model.document,
        seed=seed,
        period_ns=round(1e9 / settings.rate_hz),
        lockstep=True,
        title=title,
        axes=settings.axis_names,
        command_line=tuple(sys.argv),
    )


def antenna_for(
    experiment: Experiment, settings: DaemonSettings, model: AntennaModel
) -> tuple[DaemonSettings, AntennaModel]:
    """Settings and model of the virtual antenna that the experiment is run on; BadInputError for a single axis."""
    if model.kind is not ModelKind.GIMBAL:
        raise BadInputError(
            f"{model.where}: kind", f"is {model.kind.value}, a single axis", "gimbal: experiments move two axes"
        )
    settings = settings.for_axes(model.axes, model.where).with_model()
    return settings, model if experiment.base is None else model.with_base(experiment.base)


def conduct(
    experiment: Experiment,
    settings: DaemonSettings,
    model: AntennaModel,
    seed: int,
    folder: Path,
    *,
    resume: bool = False,
    force: bool = False,
    progress: ProgressSink | None = None,
) -> Outcome:
    """Run an experiment on the virtual antenna in lockstep and leave log, table and report in `folder`."""
    settings, model = antenna_for(experiment, settings, model)
    antenna = partial(LockstepAntenna, settings, model, seed, experiment.every)
    header = run_header(settings, model, seed, experiment.name, experiment.every)
    if experiment.parts:
        outcome = run_side_by_side(experiment, antenna, folder, header, resume=resume, force=force, progress=progress)
    else:
        with closing(antenna()) as alone:
            outcome = run_experiment(experiment, alone, folder, header, resume=resume, force=force, progress=progress)
    write_results(outcome, f"{_answering(settings, model)}, seed {seed}, {settings.rate_hz:g} Hz in lockstep")
    return outcome


def _answering(settings: DaemonSettings, model: AntennaModel) -> str:
    link = settings.link
    if not isinstance(link, EmbeddedAntenna) or link.embedded.firmware is FirmwareRun.VIRTUAL:
        return model.name
    return f"C device ({link.embedded.firmware}) with antenna {model.name}"


def conduct_through_daemon(
    experiment: Experiment,
    run: Path,
    folder: Path,
    *,
    resume: bool = False,
    force: bool = False,
    progress: ProgressSink | None = None,
) -> Outcome:
    """Run an experiment in real time through the daemon that records into `run`; leaves log, table and report in
    `folder`.
    """
    antenna = DaemonAntenna(run, experiment.steps)
    try:
        header = replace(antenna.record.header, title=experiment.name, command_line=tuple(sys.argv))
        outcome = run_experiment(experiment, antenna, folder, header, resume=resume, force=force, progress=progress)
        antenna.let_go()
    finally:
        antenna.close()
    write_results(outcome, f"through the daemon of {run}, {antenna.rate_hz:g} Hz in real time")
    return outcome


def write_results(outcome: Outcome, where: str) -> Path:
    """Table and report page of a finished experiment, which needs its checkpoints no more; answers the page's path."""
    table = table_csv(outcome.rows)
    (outcome.folder / TABLE_FILE).write_text(table, encoding="utf-8")
    blocks = [
        *outcome.blocks,
        Details("The table as data (table.csv)", [Listing(table)]),
    ]
    page = Page(outcome.experiment.text, where, blocks).write(outcome.folder / REPORT_FILE)
    remove_checkpoint(outcome.folder)
    remove_parts(outcome.folder)
    return page
