"""From telemetry records to the run folder: rows wait a moment so that the cause of a miss reaches the row it belongs to."""

from __future__ import annotations

import json
import struct
from collections import deque
from typing import Any

import numpy as np

from gimbal_hil.daemon.mailbox import Record, RingReader
from gimbal_hil.daemon.telemetry import COMMAND_HEADER, Exchange, TelemetryKind, exchange_from
from gimbal_hil.runs import TICK_ROW, EventKind, RunWriter

Json = dict[str, Any]
#: longer than the tick engine waits for the witness
_HOLD_NS = 50_000_000


class Recorder:
    """Feeds a RunWriter; `writer` None keeps nothing. Rows lost in the ring become an event, never a silent gap."""

    def __init__(self, writer: RunWriter | None, period_ns: int) -> None:
        self._writer = writer
        self._hold_ticks = _HOLD_NS // period_ns + 1
        self._waiting: deque[Exchange] = deque()
        self._causes: dict[int, int] = {}
        self._lost = 0
        self._last = (0, 0)

    @property
    def failure(self) -> str | None:
        """Why recording has ended early, None while it goes on."""
        return self._writer.failure if self._writer else None

    def take(self, record: Record) -> None:
        """Keep one record that belongs in the log; other kinds are let pass."""
        if self._writer is None:
            return
        if record.kind == TelemetryKind.TICK:
            self._waiting.append(exchange_from(record.payload))
        elif record.kind == TelemetryKind.MISS:
            tick, code = struct.unpack("<qi", record.payload)
            self._causes[tick] = code
        elif record.kind == TelemetryKind.REJECTED:
            self._writer.append_rejected(COMMAND_HEADER.unpack_from(record.payload)[0], record.payload[COMMAND_HEADER.size :])
        elif record.kind == TelemetryKind.EVENT:
            event = json.loads(record.payload)
            self._last = (event["tick"], event["time_ns"])
            self._writer.event(event["tick"], event["time_ns"], EventKind(event["kind"]), event["text"], event["data"])

    def command(self, tick: int, time_ns: int, text: str, data: Json) -> None:
        """Keep an operator's command at the tick at which the host took it."""
        if self._writer is not None:
            self._writer.command(tick, time_ns, text, data)

    def note_lost(self, ring: RingReader) -> None:
        """Say in the log that records were overwritten before they could be kept."""
        if self._writer is not None and ring.lost > self._lost:
            data = {"records": ring.lost - self._lost}
            self._writer.event(*self._last, EventKind.RECORDING, "records were overwritten before the recorder could take them", data)
        self._lost = ring.lost

    def write(self, everything: bool = False) -> None:
        """Pass on the rows whose misses have been explained by now; all of them at the end."""
        waiting, writer = self._waiting, self._writer
        if writer is None or not waiting:
            return
        newest = waiting[-1].tick
        rows: list[bytes] = []
        while waiting and (everything or waiting[0].tick + self._hold_ticks <= newest):
            exchange = waiting.popleft()
            writer.append_exchange(exchange.tick, exchange.received, exchange.sent)
            rows.append(exchange.row)
        if not rows:
            return
        table = np.frombuffer(b"".join(rows), TICK_ROW).copy()
        if self._causes:
            skipped = table["skipped_ticks"] > 0
            table["miss_cause"][skipped] = [self._causes.pop(int(tick), 0) for tick in table["tick"][skipped]]
        self._last = (int(table["tick"][-1]), int(table["time_ns"][-1]))
        writer.append_ticks(table)

    def close(self, exit_code: int, reason: str) -> None:
        """Write all that waits and the end of the run."""
        if self._writer is not None:
            self.write(everything=True)
            self._writer.close(exit_code, reason)
