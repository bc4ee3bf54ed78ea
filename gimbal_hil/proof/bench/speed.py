"""What is measured: plant step, frame path, compiled path, start of the command."""

from __future__ import annotations

import math
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterator

from firmware_protocol.compiling import entry_point
from gimbal_hil.loop.host import AxisCommand, Mode, Program, Segment, Shape, program_of
from gimbal_hil.loop.settings import DaemonSettings, shipped_settings
from gimbal_hil.proof.bench.figures import Figure, Goal, GoalKind, paired, times_faster, times_longer, times_real_time
from gimbal_hil.proof.bench.references import mujoco_steps, pinocchio_accelerations
from gimbal_hil.realtime.lockstep import CompiledPath, FramePath
from sim_backend import layout
from sim_backend.effects import CATALOGUE
from sim_backend.model import AntennaModel, plant_arrays, shipped_model
from sim_backend.plant import run_steps

PLANT_STEPS, STRETCHES = 20_000, 20
SINES = 100_000
LOCKSTEP_S = 5.0
#: how the figures of the effects begin
STEP_WITH = "step with "


@entry_point
def sum_of_sines(n: int) -> float:
    """The yardstick of the machine: n sines, one after the other."""
    total = 0.0
    for i in range(n):
        total += math.sin(1e-3 * i + 1e-9 * total)
    return total


def sines() -> float:
    """One call of the yardstick."""
    return float(sum_of_sines(SINES))


def speed_figures(repeats: int = 9, say: Callable[[str], None] = lambda name: None) -> list[Figure]:
    """All figures, in the order of the table; `say` is called with what is being measured."""
    figures: list[Figure] = []
    for name, measure in (
        ("plant", plant_figures),
        ("effects", effect_figures),
        ("lockstep", lockstep_figures),
        ("start", start_figures),
    ):
        say(name)
        figures += list(measure(repeats))
    return figures


def moving_plant(model: AntennaModel) -> Callable[[], object]:
    """A call that makes PLANT_STEPS steps of a plant whose joints slide at a steady rate."""
    arrays = plant_arrays(model)
    start = arrays.X.copy()
    start[layout.RATE : layout.RATE + 2] = 0.05

    # friction alone on the outer axis, friction less gravity on the inner one; started anew before the motion is
    # another one
    def steps() -> None:
        for _ in range(STRETCHES):
            arrays.X[:] = start
            run_steps(arrays.P, arrays.K, arrays.X, 0.244, -0.899, PLANT_STEPS // STRETCHES)

    return steps


def plant_figures(repeats: int) -> Iterator[Figure]:
    """One plant step beside MuJoCo's step, Pinocchio's forward dynamics and a sine."""
    ours = moving_plant(shipped_model())
    times = paired(ours, sines, repeats)
    yield times_faster("plant step", "ns", PLANT_STEPS, *times, "one sine", SINES)
    for reference, made, share, target in (
        ("MuJoCo mj_step, the same body", mujoco_steps, 2000, Goal(GoalKind.RATIO_AT_LEAST, 10.0)),
        ("Pinocchio aba from Python, the same body", pinocchio_accelerations, 500, None),
    ):
        work = made(shipped_model(), share)
        if work is not None:
            yield times_faster("plant step", "ns", PLANT_STEPS, *paired(ours, work, repeats), reference, share, target)


def effect_figures(repeats: int) -> Iterator[Figure]:
    """A plant step with one hook effect on, as a share of the step without; at the end the median of all effects."""
    plain = moving_plant(shipped_model())
    costs = []
    for name, effect in CATALOGUE.items():
        if not effect.is_number:
            present = shipped_model().with_effect(name, "outer", {p.name: p.neutral for p in effect.parameters})
            ours, theirs = paired(moving_plant(present), plain, repeats)
            value, target = 1e9 * statistics.median(ours) / PLANT_STEPS, Goal(GoalKind.RATIO_BELOW, 1.3)
            cost = times_longer(f"{STEP_WITH}{name}", "ns", value, ours, theirs, "step without", target)
            costs.append(cost)
            yield cost
    middles = [cost.ratio for cost in costs]
    yield Figure(
        "median step with an effect",
        statistics.median(cost.value for cost in costs),
        "ns",
        "step without",
        statistics.median(middles),
        min(middles),
        max(middles),
        repeats,
        Goal(GoalKind.RATIO_BELOW, 1.15),
    )


def ask_for_kernels() -> None:
    """Compile what this bench alone calls, for this machine."""
    sum_of_sines(1)
    arrays = plant_arrays(shipped_model())
    run_steps(arrays.P, arrays.K, arrays.X, 0.0, 0.0, 1)


def work_program(settings: DaemonSettings) -> Program:
    """Both axes follow sines in position: control, friction and rigid body all at work."""
    outer = AxisCommand(Mode.POSITION, Shape.SINE, (0.0, 0.5, 0.3, 0.0))
    inner = AxisCommand(Mode.POSITION, Shape.SINE, (0.0, 0.3, 0.5, 0.0))
    return program_of([Segment(outer=outer, inner=inner, duration_ticks=round(1e6 * settings.rate_hz))])


def lockstep_figures(repeats: int) -> Iterator[Figure]:
    """Both lockstep paths with recording on, and the compiled one without."""
    settings, model = shipped_settings(), shipped_model()
    ticks = round(LOCKSTEP_S * settings.rate_hz)

    def running(engine: FramePath | CompiledPath, every: int) -> Callable[[], object]:
        engine.connect()
        engine.host.command(work_program(settings))
        return lambda: engine.advance(ticks, every=every)

    frame_path = running(FramePath(settings, model, 1, keep_frames=True), 1)
    yield times_real_time(
        "frame path, every frame and tick kept",
        LOCKSTEP_S,
        *paired(frame_path, sines, repeats),
        "1e5 sines",
        Goal(GoalKind.VALUE_AT_LEAST, 1000.0),
    )
    compiled = running(CompiledPath(settings, model, 1, keep_frames=True), 1)
    yield times_real_time(
        "compiled path, every frame and tick kept",
        LOCKSTEP_S,
        *paired(compiled, sines, repeats),
        "1e5 sines",
        Goal(GoalKind.VALUE_AT_LEAST, 1600.0),
    )
    campaign = running(CompiledPath(settings, model, 1), 100)
    yield times_real_time(
        "compiled path, one tick in 100 kept",
        LOCKSTEP_S,
        *paired(campaign, sines, repeats),
        "1e5 sines",
        Goal(GoalKind.VALUE_AT_LEAST, 2000.0),
    )
    yield times_real_time(
        "frame path over compiled path",
        LOCKSTEP_S,
        *paired(frame_path, campaign, repeats),
        "compiled path",
    )


def start_figures(repeats: int) -> Iterator[Figure]:
    """`--help` beside a bare interpreter."""

    def started(*words: str) -> Callable[[], object]:
        return lambda: subprocess.run([sys.executable, *words], check=True, capture_output=True)

    ours, theirs = paired(
        started("-c", "from gimbal_hil.surface.cli import main; main()", "--help"),
        started("-c", "pass"),
        repeats,
        time.perf_counter,
    )
    target = Goal(GoalKind.VALUE_BELOW, 0.5)
    yield times_longer("--help", "s", statistics.median(ours), ours, theirs, "bare interpreter", target)
