"""The demonstration: stages that each run something real and leave blocks for one report page."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from gimbal_hil.data.runs import open_run, replay
from gimbal_hil.data.signals import read_signals
from gimbal_hil.knowledge.discrepancy import (
    Kind,
    Request,
    Verdict,
    corrected_model,
    diagnose,
    discrepancy_page,
    verdict_of,
)
from gimbal_hil.knowledge.experiments import ProgressSink, conduct, embedded_model_of
from gimbal_hil.knowledge.experiments.sequences import SequenceOptions, breakaway_torques, build_experiment
from gimbal_hil.knowledge.identification import Log, identification_page, identify_axis, read_logs
from gimbal_hil.loop.settings import DaemonSettings
from gimbal_hil.pages.report import Block, Callout, Details, Heading, Page, Text, Tiles, plots_in
from gimbal_hil.realtime.lockstep import give_again, host_of
from gimbal_hil.surface.demo.ghost import ghost_of, side_by_side
from sim_backend.model import AntennaModel

#: plots of the last stage that stand at the top: how large the gap is, and what is left over position and speed
PROOFS = 2
_FRICTION = ("breakaway", "coulomb", "stribeck_velocity", "viscous", "shape", "sigma0", "sigma1")


@dataclass(frozen=True)
class StageResult:
    """What a stage says: a line for the terminal, its key figure as (value, what it is), blocks for the page, and what
    of them is seen without being asked for.
    """

    line: str
    figure: tuple[str, str]
    blocks: list[Block]
    seen: list[Block] = field(default_factory=list)


@dataclass(frozen=True)
class Stage:
    """One stage of the story."""

    name: str
    text: str
    #: what is folded away
    all_of_it: str
    run: Callable[[DaemonSettings, Path, ProgressSink], StageResult]


def _step(settings: DaemonSettings, out: Path, progress: ProgressSink) -> StageResult:
    model, seed = embedded_model_of(settings)
    experiment = build_experiment("step", SequenceOptions(settings.rate_hz, names=settings.axis_names))
    outcome = conduct(experiment, settings, model, seed, out / "step", force=True, progress=progress)
    slowest = max(row["settling_s"] or float("inf") for row in outcome.rows)
    most = max(row["overshoot_percent"] for row in outcome.rows)
    line = f"{len(outcome.rows)} steps of both axes settled within {slowest:.2f} s, overshoot at most {most:.2f} %"
    said = f"slowest of {len(outcome.rows)} steps settles"
    return StageResult(line, (f"{slowest:.2f} s", said), outcome.blocks)


def _replay(settings: DaemonSettings, out: Path, progress: ProgressSink) -> StageResult:
    run = open_run(out / "step")
    host = host_of(run)
    result = replay(run, host, lambda event: give_again(host, run, event))
    said = "identical" if result.identical else f"differs: {result.difference}"
    line = f"the recorded run again, against its own frames: {said} ({result.ticks} ticks, {result.frames} frames)"
    figure = ("identical" if result.identical else "differs", f"{result.ticks} recorded ticks, run again")
    return StageResult(line, figure, [Text(line[0].upper() + line[1:] + ".")])


def _friction(settings: DaemonSettings, out: Path, progress: ProgressSink) -> StageResult:
    model, seed = embedded_model_of(settings)
    axis = model.axes[0]
    blocks: list[Block] = []
    logs: list[Log] = []
    for name in ("sliding", "presliding"):
        experiment = build_experiment(
            name,
            SequenceOptions(
                settings.rate_hz, (axis,), short=True, breakaway_nm=breakaway_torques(model), names=settings.axis_names
            ),
        )
        outcome = conduct(experiment, settings, model, seed, out / name, force=True, progress=progress)
        blocks += outcome.blocks
        logs += read_logs(out / name, model.axes)
    progress.begin("identifying", 1.0, 0.0)
    result = identify_axis(logs, _doubtful(model, axis), axis)
    found = {estimate.name: estimate for estimate in result.estimates}
    worst = max(abs(found[name].value / model.number(axis, f"friction.{name}") - 1.0) for name in _FRICTION)
    line = f"seven friction numbers of the {axis} axis, the worst {100 * worst:.1f} % from the truth"
    figure = (f"{100 * worst:.1f} %", "from the truth: the worst of seven friction numbers")
    found_blocks = [*identification_page(model, [result], ["sliding", "presliding"]).blocks, *blocks]
    return StageResult(line, figure, found_blocks)


def _doubtful(model: AntennaModel, axis: str) -> AntennaModel:
    """A prior that does not know the answer: every friction number of an axis half as large again."""
    return model.with_numbers(
        axis, {f"friction.{name}": 1.5 * model.number(axis, f"friction.{name}") for name in _FRICTION}
    )


def _missing(settings: DaemonSettings, out: Path, progress: ProgressSink) -> StageResult:
    model, seed = embedded_model_of(settings)
    hidden = model.with_effect("cogging", model.axes[0], {"amplitude": 0.03, "order": 12.0, "phase": 0.7})
    tables = []
    for name in ("survey", "survey_holdout"):
        experiment = build_experiment(name, SequenceOptions(settings.rate_hz, short=True, names=settings.axis_names))
        conduct(experiment, settings, hidden, seed, out / name, force=True, progress=progress)
        tables.append(read_signals(out / name, model.axes))
    progress.begin("searching for what the model lacks", 1.0, 0.0)
    diagnosis = diagnose(
        Request(model, (tables[0],), (tables[1],)), workers=2, progress=lambda text: progress.at(text, 0.0)
    )
    verdict = verdict_of(diagnosis)
    corrected = corrected_model(diagnosis)
    if corrected is not None:
        (out / "model.yaml").write_text(corrected.to_yaml(), encoding="utf-8")
    page = discrepancy_page(diagnosis, verdict, corrected, ["survey", "survey_holdout"])
    progress.begin("the ghost of the model beside the antenna", 1.0, 0.0)
    added = " and ".join(str(effect["name"]).replace("_", " ") for effect in verdict.effects)
    models = [("the model as it was", model)] + ([] if corrected is None else [(f"with {added} added", corrected)])
    ghosts = {
        name: ghost_of(tables[1], model.axes[0], one, settings, seed, out / f"ghost_{number}")
        for number, (name, one) in enumerate(models)
    }
    return StageResult(
        f"an antenna with a hidden effect, judged blind: {verdict.kind.value}. {verdict.text}",
        (verdict.kind.value.replace("_", " "), "the effect that was hidden, judged blind"),
        [_found(verdict, page.blocks[0]), *page.blocks[1:]],
        [Heading("The model beside the antenna, moving"), side_by_side(tables[1], model.axes[0], ghosts)],
    )


def _found(verdict: Verdict, answer: Block) -> Block:
    """The answer of a verdict, as that of a story in which something was hidden."""
    if verdict.kind is not Kind.NAMED or not isinstance(answer, Callout):
        return answer
    return replace(answer, text=f"The hidden effect was found: {answer.text[0].lower()}{answer.text[1:]}")


#: the stages in order
STAGES = (
    Stage("step", "step responses through daemon core, frames and virtual antenna", "All step responses", _step),
    Stage("replay", "the recorded run again, bit for bit", "The whole replay", _replay),
    Stage("friction", "sliding and presliding, then friction with intervals", "All friction runs and fits", _friction),
    Stage("missing", "an effect that the model does not know: found, named, added", "The whole search", _missing),
)


def tell(settings: DaemonSettings, out: Path, progress: ProgressSink, say: Callable[[str, str], None]) -> Path:
    """Run every stage; `say(stage, line)` gets the result of each. Returns the path of the report."""
    antenna, _ = embedded_model_of(settings)
    settings = settings.for_axes(antenna.axes, antenna.where)
    told: list[StageResult] = []
    for stage in STAGES:
        told.append(stage.run(settings, out, progress))
        say(stage.name, told[-1].line)
    return story_page(told).write(out / "report.html")


def story_page(told: Sequence[StageResult]) -> Page:
    """The answer of the last stage and what moves, a figure of each, the plots that prove the answer; all else is
    folded away.
    """
    answer = told[-1].blocks
    tiles = Tiles([one.figure for one in told])
    blocks: list[Block] = [*answer[:1], *told[-1].seen, tiles, *list(plots_in(answer))[:PROOFS]]
    for stage, one in zip(STAGES, told, strict=True):
        line = one.line[:1].upper() + one.line[1:]
        blocks += [
            Heading(stage.text[:1].upper() + stage.text[1:]),
            Text(line if line.endswith(".") else f"{line}."),
            Details(stage.all_of_it, one.blocks),
            *(one.seen if one is not told[-1] else []),
        ]
    return Page("What gimbal-hil does", "virtual antenna in this process, the same frames as a real one", blocks)
