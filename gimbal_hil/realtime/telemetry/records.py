"""What the control process hands to the service process, record by record: plain structs one way, plain JSON where it
is rare.
"""

from __future__ import annotations

import json
import struct
import time
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.json_object import Json
from gimbal_hil.loop.host import Program
from gimbal_hil.loop.timing import MISS_CODE, NS_PER_S, MissCause, RingReader, RingWriter

#: size of a row of `runs.TICK_ROW`, and where its wall-clock columns wake_latency_ns and computing_ns start;
#: `skipped_ticks`
ROW_BYTES, WALL_CLOCK_AT = 96, 80
_SKIPPED_AT = 68
#: tick that ran after the miss, periods lost, code of the cause
MISS_RECORD = struct.Struct("<qii")
_WALL_CLOCK = struct.Struct("<ii")
_WALL_CLOCK_END = WALL_CLOCK_AT + _WALL_CLOCK.size
_INT32_MAX = 2**31 - 1
_RECEIVED_LENGTH = struct.Struct("<I")
#: ten seconds at 2 kHz with every message on the bus
TELEMETRY_BYTES = 8 << 20
#: a plan with the largest tables that are accepted, four times over
COMMAND_BYTES = 32 << 20


class TelemetryKind(IntEnum):
    """What a record from the control process holds."""

    TICK = 1
    EVENT = 2
    MISS = 3
    REPLY = 4
    END = 5


_TICK = int(TelemetryKind.TICK)


class CommandKind(IntEnum):
    """What a record to the control process asks for; each starts with COMMAND_HEADER."""

    START = 1
    STOP = 2
    QUICK_STOP = 3
    FAULT_RESET = 4
    SHUT_DOWN = 5
    #: from the service itself: recording has failed, the reason follows
    RECORDING_FAILED = 6
    #: other gains and limits: the host's whole array `C`
    ADJUST = 7
    #: as START, and the host's image before it goes into the log: a run that begins here can be computed again
    START_WITH_IMAGE = 8
    #: whoever asked for a motion is still there; the number of that START follows, as in the two below
    RENEW = 9
    #: the motion needs its client no more
    RELEASE = 10
    #: the connection of the motion's client has closed
    CLIENT_GONE = 11


#: number of the request, and CLOCK_MONOTONIC when it was asked
COMMAND_HEADER = struct.Struct("<qq")
#: a motion that was asked for longer ago is not begun: by then its caller has been told that it was not taken
MOTION_PATIENCE_S = 3.0
#: length of the program, and ticks of its lease
_PROGRAM_HEAD = struct.Struct("<qq")
_MOTION_NUMBER = struct.Struct("<q")


def pack_program(program: Program, lease_ticks: int = 0) -> bytes:
    """A program as a START command carries it; a lease of 0 ticks is none."""
    return _PROGRAM_HEAD.pack(program.length, lease_ticks) + program.values.tobytes()


def unpack_program(payload: bytes) -> Program:
    """The program of a START command: it was checked before it was packed."""
    length, _ = _PROGRAM_HEAD.unpack_from(payload)
    return Program(np.frombuffer(payload, np.float64, offset=_PROGRAM_HEAD.size).copy(), length)


def lease_ticks_of(payload: bytes) -> int:
    """The lease of a START command, 0 for none."""
    return int(_PROGRAM_HEAD.unpack_from(payload)[1])


def pack_motion_number(number: int) -> bytes:
    """Which motion RENEW, RELEASE and CLIENT_GONE are about: the number of its START."""
    return _MOTION_NUMBER.pack(number)


def unpack_motion_number(payload: bytes) -> int:
    """The same read back."""
    return int(_MOTION_NUMBER.unpack_from(payload)[0])


def pack_configuration(configuration: NDArray[np.float64]) -> bytes:
    """The host's array as an ADJUST command carries it."""
    return configuration.tobytes()


def unpack_configuration(payload: bytes) -> NDArray[np.float64]:
    """The array of an ADJUST command: it was checked before it was packed."""
    return np.frombuffer(payload, np.float64)


@dataclass(frozen=True, slots=True)
class Exchange:
    """One tick as the recorder takes it: its row, bytes of TICK_ROW, and the blocks received and sent."""

    row: bytes
    received: bytes
    sent: bytes

    @property
    def tick(self) -> int:
        """Number of the tick."""
        return int.from_bytes(self.row[:8], "little", signed=True)

    @property
    def skipped(self) -> int:
        """Periods that were lost just before it."""
        return int.from_bytes(self.row[_SKIPPED_AT : _SKIPPED_AT + 4], "little", signed=True)


def exchange_from(payload: bytes) -> Exchange:
    """Take a TICK record apart."""
    end = ROW_BYTES + _RECEIVED_LENGTH.size
    (length,) = _RECEIVED_LENGTH.unpack_from(payload, ROW_BYTES)
    return Exchange(payload[:ROW_BYTES], payload[end : end + length], payload[end + length :])


class Telemetry:
    """The control process' end. In real time a full ring loses its oldest records; in lockstep, where time can wait,
    the writer waits.
    """

    def __init__(self, ring: RingWriter, lockstep: bool) -> None:
        self._ring = ring
        self._lockstep = lockstep

    def tick(self, row: bytes, late_ns: int, computing_ns: int, received: bytes, sent: bytes) -> None:
        """One tick: the host's row, the two readings of the wall clock that complete it, and its blocks."""
        wall_clock = _WALL_CLOCK.pack(min(late_ns, _INT32_MAX), min(computing_ns, _INT32_MAX))
        parts = (
            row[:WALL_CLOCK_AT],
            wall_clock,
            row[_WALL_CLOCK_END:],
            _RECEIVED_LENGTH.pack(len(received)),
            received,
            sent,
        )
        self._push(_TICK, b"".join(parts))

    def event(self, tick: int, time_ns: int, kind: str, text: str, data: Json | None = None) -> None:
        """One event; `kind` is the value of a `runs.EventKind`."""
        self._push_json(
            TelemetryKind.EVENT, {"tick": tick, "time_ns": time_ns, "kind": kind, "text": text, "data": data or {}}
        )

    def miss(self, tick: int, periods: int, cause: MissCause) -> None:
        """The cause of the periods that were skipped before `tick`."""
        self._push(TelemetryKind.MISS, MISS_RECORD.pack(tick, periods, MISS_CODE[cause]))

    def reply(self, request: int, tick: int, time_ns: int, problem: str = "", not_ready: bool = False) -> None:
        """What became of a request: taken at `tick`, or why not; `not_ready`: ask again in a moment."""
        told = {"request": request, "tick": tick, "time_ns": time_ns, "problem": problem, "not_ready": not_ready}
        self._push_json(TelemetryKind.REPLY, told)

    def end(self, exit_code: int, reason: str) -> None:
        """The last record: the control process is done and torque is off."""
        self._push_json(TelemetryKind.END, {"exit_code": exit_code, "reason": reason})

    def _push_json(self, kind: TelemetryKind, content: Json) -> None:
        self._push(kind, json.dumps(content).encode())

    def _push(self, kind: int, payload: bytes) -> None:
        if self._lockstep:
            patience_ns = time.monotonic_ns() + 5 * NS_PER_S
            while not self._ring.push_if_room(kind, payload):
                if time.monotonic_ns() > patience_ns:
                    self._lockstep = False  # nobody reads any more: the control loop will find out why
                    break
                time.sleep(0.001)
            else:
                return
        self._ring.push(kind, payload)


class Commands:
    """The service process' end of the other ring: requests that have been checked, on their way to the control
    process.
    """

    def __init__(self, ring: RingWriter) -> None:
        self._ring = ring
        self._last_number = 0

    def send(self, kind: CommandKind, payload: bytes = b"") -> int | None:
        """Hand on a request; answers its number, or None when the control process has not taken the ones before."""
        number = self._last_number + 1
        if not self._ring.push_if_room(kind, COMMAND_HEADER.pack(number, time.monotonic_ns()) + payload):
            return None
        self._last_number = number
        return number


@dataclass(frozen=True, slots=True)
class Command:
    """One request as the control process takes it."""

    kind: CommandKind
    number: int
    payload: bytes
    asked_ns: int

    @property
    def is_stale(self) -> bool:
        """Whether it was asked too long ago for a motion; both processes read the machine's own clock."""
        return time.monotonic_ns() - self.asked_ns > MOTION_PATIENCE_S * NS_PER_S


def take_commands(ring: RingReader) -> list[Command]:
    """Requests that came since the last call."""
    if ring.is_empty:
        return []
    commands = []
    for record in ring.take():
        number, asked_ns = COMMAND_HEADER.unpack_from(record.payload)
        commands.append(Command(CommandKind(record.kind), number, record.payload[COMMAND_HEADER.size :], asked_ns))
    return commands
