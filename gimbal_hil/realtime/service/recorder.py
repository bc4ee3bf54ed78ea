"""From telemetry records to the run folder: a row after a miss waits a moment, so that the cause reaches the row it
belongs to.
"""

from __future__ import annotations

from collections import deque

import numpy as np

from firmware_protocol.json_object import Json
from gimbal_hil.data.runs import TICK_ROW, EventKind, RunWriter
from gimbal_hil.loop.timing import RingReader
from gimbal_hil.realtime.telemetry import Exchange

#: longer than the tick engine waits for the witness
_HOLD_NS = 50_000_000


class Recorder:
    """Feeds a RunWriter. Records lost in the ring become an event, never a silent gap.

    `frames` False keeps tick rows alone; of the rows those are kept whose tick is a multiple of `every_ticks`.
    """

    def __init__(self, writer: RunWriter, period_ns: int, frames: bool = True, every_ticks: int = 1) -> None:
        self._writer = writer
        self._frames = frames
        self._every_ticks = every_ticks
        self._hold_ticks = _HOLD_NS // period_ns + 1
        self._waiting: deque[Exchange] = deque()
        self._causes: dict[int, int] = {}
        self._lost = 0
        self._last = (0, 0)

    @property
    def failure(self) -> str | None:
        """Why recording has ended early, None while it goes on."""
        return self._writer.failure

    @property
    def running_out(self) -> str | None:
        """Why recording should end soon, in good order: the disk is nearly full."""
        return self._writer.running_out

    @property
    def state(self) -> Json:
        """For people: is all kept, and how much room is there? `lamp` is ok, low, stopping or failed."""
        low = self._writer.is_low
        lamp = "failed" if self.failure else "stopping" if self.running_out else "low" if low else "ok"
        free = self._writer.free_mb
        return {
            "lamp": lamp,
            "free_mb": None if free is None else round(free),
            "problem": self.failure or self.running_out,
        }

    def take_exchanges(self, exchanges: list[Exchange]) -> None:
        """Keep ticks, in their order."""
        self._waiting.extend(exchanges)

    def miss(self, tick: int, code: int) -> None:
        """The cause of the periods that were skipped before `tick`."""
        self._causes[tick] = code

    def event(self, event: Json) -> None:
        """Keep an event as the control process sent it."""
        self._last = (event["tick"], event["time_ns"])
        self._writer.event(event["tick"], event["time_ns"], EventKind(event["kind"]), event["text"], event["data"])

    def command(self, tick: int, time_ns: int, text: str, data: Json) -> None:
        """Keep an operator's command at the tick at which the host took it."""
        self._writer.command(tick, time_ns, text, data)

    def note_lost(self, ring: RingReader) -> None:
        """Say in the log that records were overwritten before they could be kept."""
        if ring.lost > self._lost:
            data = {"records": ring.lost - self._lost}
            self._writer.event(
                *self._last, EventKind.RECORDING, "records were overwritten before the recorder could take them", data
            )
        self._lost = ring.lost

    def write(self, everything: bool = False) -> None:
        """Pass on the rows whose misses have been explained by now; all of them at the end."""
        waiting, writer = self._waiting, self._writer
        if not waiting:
            return
        newest = waiting[-1].tick
        rows: list[bytes] = []
        while waiting and (everything or self._is_explained(waiting[0], newest)):
            exchange = waiting.popleft()
            if self._frames:
                writer.append_exchange(exchange.tick, exchange.received, exchange.sent)
            rows.append(exchange.row)
        if not rows:
            return
        table = np.frombuffer(b"".join(rows), TICK_ROW).copy()
        if self._causes:
            skipped = table["skipped_ticks"] > 0
            table["miss_cause"][skipped] = [self._causes.pop(int(tick), 0) for tick in table["tick"][skipped]]
        self._last = (int(table["tick"][-1]), int(table["time_ns"][-1]))
        writer.append_ticks(table if self._every_ticks == 1 else table[table["tick"] % self._every_ticks == 0])

    def _is_explained(self, exchange: Exchange, newest: int) -> bool:
        """Whether nothing more will be known of a row: it skipped nothing, its cause has come, or will not come any
        more.
        """
        return exchange.skipped == 0 or exchange.tick in self._causes or exchange.tick + self._hold_ticks <= newest

    def close(self, exit_code: int, reason: str) -> None:
        """Write all that waits and the end of the run."""
        self.write(everything=True)
        self._writer.close(exit_code, reason)
