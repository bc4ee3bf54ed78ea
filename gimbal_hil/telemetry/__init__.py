"""What the control process tells the processes beside it, and what an onlooker makes of it."""

from gimbal_hil.telemetry.live_view import LiveView
from gimbal_hil.telemetry.records import (
    COMMAND_BYTES,
    MISS_RECORD,
    TELEMETRY_BYTES,
    Command,
    CommandKind,
    Commands,
    Exchange,
    Telemetry,
    TelemetryKind,
    exchange_from,
    pack_program,
    take_commands,
    unpack_program,
)

__all__ = [
    "COMMAND_BYTES",
    "MISS_RECORD",
    "TELEMETRY_BYTES",
    "Command",
    "CommandKind",
    "Commands",
    "Exchange",
    "LiveView",
    "Telemetry",
    "TelemetryKind",
    "exchange_from",
    "pack_program",
    "take_commands",
    "unpack_program",
]
