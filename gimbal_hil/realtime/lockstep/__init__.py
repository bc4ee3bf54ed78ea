"""Host and virtual antenna bound by sequence number, in this process: tick by tick, compiled, or from a recorded
run.
"""

from gimbal_hil.realtime.lockstep.flight_path import ErringNavigation, FlightPath, FlownBase
from gimbal_hil.realtime.lockstep.flight_run import ERROR_COLUMNS, SILENT
from gimbal_hil.realtime.lockstep.law_run import LawPath
from gimbal_hil.realtime.lockstep.paths import CHUNK_ROWS, CompiledPath, Exchange, FramePath, Lockstep, Recorded, joined
from gimbal_hil.realtime.lockstep.recorded_host import give_again, host_of

__all__ = [
    "CHUNK_ROWS",
    "ERROR_COLUMNS",
    "SILENT",
    "CompiledPath",
    "ErringNavigation",
    "Exchange",
    "FlightPath",
    "FlownBase",
    "FramePath",
    "LawPath",
    "Lockstep",
    "Recorded",
    "give_again",
    "host_of",
    "joined",
]
