"""Time: clocks, deadlines and the causes of missed ones, the witness process, ring buffers between processes."""

from gimbal_hil.timing.clock import NS_PER_S, Clock, Duration, Instant, LockstepClock, MonotonicClock
from gimbal_hil.timing.histogram import Histogram, upper_bound_ns
from gimbal_hil.timing.machine_check import MachineReport, check_machine
from gimbal_hil.timing.mailbox import RingReader, RingRecord, RingWriter, create_ring
from gimbal_hil.timing.miss_causes import Miss, MissCause, ThreadUsage
from gimbal_hil.timing.reference_loop import ReferenceLoop, compiler
from gimbal_hil.timing.scheduling import Granted, control_and_witness_cores, real_time
from gimbal_hil.timing.tick_engine import Tick, TickEngine, TickStatistics
from gimbal_hil.timing.witness import WitnessProcess

__all__ = [
    "NS_PER_S",
    "Clock",
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
    "compiler",
    "control_and_witness_cores",
    "create_ring",
    "real_time",
    "upper_bound_ns",
]
