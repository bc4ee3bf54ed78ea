"""Budgets that do not depend on the machine: ratios of processor time with wide margins, calls and memory per tick.

Ratios are between two things measured in turn, best of several, in processor time of this process, so that other work
on the machine does not fail a test; what is asked of a free machine is in the bench.
"""

from __future__ import annotations

import gc
import sys
import time
from collections.abc import Callable
from types import FrameType

import pytest

from gimbal_hil.loop.host import Host
from gimbal_hil.loop.settings import host_configuration, shipped_settings
from gimbal_hil.loop.timing.clock import Duration, LockstepClock
from gimbal_hil.loop.timing.mailbox import RingReader, RingWriter, create_ring
from gimbal_hil.loop.timing.tick_engine import TickEngine
from gimbal_hil.proof.bench.figures import paired
from gimbal_hil.proof.bench.references import mujoco_steps
from gimbal_hil.proof.bench.speed import PLANT_STEPS, moving_plant, work_program
from gimbal_hil.realtime.daemon.antenna_link import embedded_antenna
from gimbal_hil.realtime.daemon.control_loop import ControlLoop, LoopTime
from gimbal_hil.realtime.daemon.link_keeper import LinkKeeper
from gimbal_hil.realtime.daemon.service_end import ServiceEnd
from gimbal_hil.realtime.lockstep import CompiledPath, Exchange, FramePath
from gimbal_hil.realtime.telemetry.records import COMMAND_BYTES, TELEMETRY_BYTES, Telemetry
from sim_backend.model import shipped_model

#: what every byte through encoder and decoder may cost, as times of a tick without; now 1.6
FRAMES_OVER_MAIL = 2.4
#: asked: ten times
PLANT_OVER_MUJOCO = 4.0
#: Python and C functions that one tick calls: what there are now, and a fifth more; of the frame path where somebody is
#: told of each tick, and where nobody is
TOLD_TICK_CALLS, FRAME_TICK_CALLS, DAEMON_TICK_CALLS = 10, 0.2, 85


def times_faster(ours: Callable[[], object], theirs: Callable[[], object]) -> float:
    mine, other = paired(ours, theirs, 5, time.process_time)
    return min(other) / min(mine)


def advancing(engine: FramePath | CompiledPath, ticks: int) -> Callable[[], object]:
    engine.connect()
    engine.host.command(work_program(shipped_settings()))
    engine.advance(10)
    return lambda: engine.advance(ticks, every=100)


def daemon_engine() -> TickEngine:
    """The daemon's tick as it is, on an embedded antenna and without a service that would read its rings."""
    settings = shipped_settings()
    clock, period = LockstepClock(), Duration.of_seconds(settings.step_s)
    antenna = embedded_antenna(settings, settings.link)  # type: ignore[arg-type]
    link = LinkKeeper(clock, lambda: antenna, lambda opened, text: None)
    telemetry = Telemetry(RingWriter(create_ring(TELEMETRY_BYTES)), lockstep=False)
    host = Host(host_configuration(settings))
    service = ServiceEnd(telemetry, RingReader(create_ring(COMMAND_BYTES)), lambda: True)
    loop = ControlLoop(host, link, service, LoopTime(clock, period))
    return TickEngine(clock, period, loop.step)


def calls_of(work: Callable[[], object]) -> int:
    count = 0

    def listen(frame: FrameType, event: str, argument: object) -> None:
        nonlocal count
        count += event in ("call", "c_call")

    sys.setprofile(listen)
    try:
        work()
    finally:
        sys.setprofile(None)
    return count


def test_frames_cost_little() -> None:
    settings, model = shipped_settings(), shipped_model()
    compiled, frames = advancing(CompiledPath(settings, model, 1), 2000), advancing(FramePath(settings, model, 1), 2000)
    assert times_faster(compiled, frames) < FRAMES_OVER_MAIL


def test_a_plant_step_is_much_faster_than_one_of_mujoco() -> None:
    pytest.importorskip("mujoco", reason="mujoco is not installed (the extra test has it)")
    theirs = mujoco_steps(shipped_model(), PLANT_STEPS // 10)
    assert theirs is not None
    assert 10.0 * times_faster(moving_plant(shipped_model()), theirs) > PLANT_OVER_MUJOCO


@pytest.mark.parametrize(("exchange", "most"), [(lambda *block: None, TOLD_TICK_CALLS), (None, FRAME_TICK_CALLS)])
def test_a_tick_of_the_frame_path_calls_few_functions(exchange: Exchange | None, most: float) -> None:
    def calls_in(ticks: int) -> int:
        return calls_of(advancing(FramePath(shipped_settings(), shipped_model(), 1, exchange=exchange), ticks))

    assert (calls_in(500) - calls_in(100)) / 400 <= most


def test_a_tick_of_the_daemon_calls_few_functions() -> None:
    engine = daemon_engine()
    engine.run(500)
    few, many = calls_of(lambda: engine.run(100)), calls_of(lambda: engine.run(500))
    assert (many - few) / 400 <= DAEMON_TICK_CALLS


def test_ticks_leave_no_memory_behind_and_no_garbage_to_collect() -> None:
    engine, ticks = daemon_engine(), 2000
    engine.run(3000)
    gc.collect()
    gc.disable()
    try:
        before, waiting = sys.getallocatedblocks(), gc.get_count()[0]
        engine.run(ticks)
        grown, tracked = sys.getallocatedblocks() - before, gc.get_count()[0] - waiting
    finally:
        gc.enable()
    assert grown / ticks < 0.05
    assert tracked / ticks < 0.05
    assert gc.collect() < 50
