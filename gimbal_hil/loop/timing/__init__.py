"""Time: clocks, deadlines and the causes of missed ones, the witness process, ring buffers between processes."""

from gimbal_hil.loop.timing.clock import (
    NS_PER_S,
    Clock,
    Duration,
    Instant,
    LockstepClock,
    MonotonicClock,
    wall_clock_utc,
)
from gimbal_hil.loop.timing.clock_sync import ClockSync, clock_sync, clock_sync_of
from gimbal_hil.loop.timing.histogram import Histogram, upper_bound_ns
from gimbal_hil.loop.timing.machine_check import MachineReport, check_machine
from gimbal_hil.loop.timing.mailbox import RingReader, RingRecord, RingWriter, create_ring
from gimbal_hil.loop.timing.miss_causes import MISS_CODE, Miss, MissCause, ThreadUsage
from gimbal_hil.loop.timing.reference_loop import ReferenceLoop, compiler
from gimbal_hil.loop.timing.scheduling import Granted, control_and_witness_cores, real_time
from gimbal_hil.loop.timing.tick_engine import Tick, TickEngine, TickStatistics
from gimbal_hil.loop.timing.witness import WitnessProcess

__all__ = [
    "MISS_CODE",
    "NS_PER_S",
    "Clock",
    "ClockSync",
    "Duration",
    "Granted",
    "Histogram",
    "Instant",
    "LockstepClock",
    "MachineReport",
    "Miss",
    "MissCause",
    "MonotonicClock",
    "ReferenceLoop",
    "RingReader",
    "RingRecord",
    "RingWriter",
    "ThreadUsage",
    "Tick",
    "TickEngine",
    "TickStatistics",
    "WitnessProcess",
    "check_machine",
    "clock_sync",
    "clock_sync_of",
    "compiler",
    "control_and_witness_cores",
    "create_ring",
    "real_time",
    "upper_bound_ns",
    "wall_clock_utc",
]
