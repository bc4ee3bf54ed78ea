"""The demonstration: stages that each run something real and leave blocks for one report page."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from gimbal_hil.experiments.conducting import conduct, embedded_model_of
from gimbal_hil.experiments.runner import ProgressSink
from gimbal_hil.experiments.sequences import SequenceOptions, build_experiment
from gimbal_hil.report import Block, Page, Text
from gimbal_hil.runs import open_run
from gimbal_hil.runs.recorded_host import give_again, host_of
from gimbal_hil.runs.replay import replay
from gimbal_hil.settings import DaemonSettings


@dataclass(frozen=True)
class Told:
    """What a stage has to say: one line for the terminal, blocks for the page."""

    line: str
    blocks: list[Block]


@dataclass(frozen=True)
class Stage:
    """One stage of the story."""

    name: str
    text: str
    run: Callable[[DaemonSettings, Path, ProgressSink], Told]


def _step(settings: DaemonSettings, out: Path, progress: ProgressSink) -> Told:
    model, seed = embedded_model_of(settings)
    experiment = build_experiment("step", SequenceOptions(settings.rate_hz))
    outcome = conduct(experiment, settings, model, seed, out / "step", force=True, progress=progress)
    slowest = max(row["settling_s"] or float("inf") for row in outcome.rows)
    most = max(row["overshoot_percent"] for row in outcome.rows)
    line = f"{len(outcome.rows)} steps of both axes settled within {slowest:.2f} s, overshoot at most {most:.2f} %"
    return Told(line, experiment.conclude(outcome.rows, outcome.drawn))


def _replay(settings: DaemonSettings, out: Path, progress: ProgressSink) -> Told:
    run = open_run(out / "step")
    host = host_of(run)
    result = replay(run, host, lambda event: give_again(host, run, event))
    said = "identical" if result.identical else f"differs: {result.difference}"
    line = f"the recorded run again, against its own frames: {said} ({result.ticks} ticks, {result.frames} frames)"
    return Told(line, [Text(line[0].upper() + line[1:] + ".")])


#: the stages in order
STAGES = (
    Stage("step", "step responses through daemon core, frames and virtual antenna", _step),
    Stage("replay", "the recorded run again, bit for bit", _replay),
)


def tell(settings: DaemonSettings, out: Path, progress: ProgressSink, say: Callable[[str, str], None]) -> Path:
    """Run every stage; `say(stage, line)` is told what each found. Answers the path of the report."""
    blocks: list[Block] = []
    for stage in STAGES:
        told = stage.run(settings, out, progress)
        say(stage.name, told.line)
        blocks += told.blocks
    subtitle = "virtual antenna in this process, the same frames as a real one"
    return Page("What gimbal-hil does", subtitle, blocks).write(out / "report.html")
