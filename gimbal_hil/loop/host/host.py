"""The host as Python sees it: a block of frames in, a block of frames out, once a tick."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from functools import cache

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.json_object import Json
from gimbal_hil.loop.control import GIVEN_TABLE, LEARNED_BINS, LEARNED_TABLE, TORQUE, TORQUE_LIMIT, Mode
from gimbal_hil.loop.host import layout
from gimbal_hil.loop.host.events import AXIS_NAMES, HostEvent, host_event
from gimbal_hil.loop.host.frame_tick import host_frame_tick
from gimbal_hil.loop.host.identity import most_torque
from gimbal_hil.loop.host.memory import LOG_COUNT, RECEIVED_SIZE, ROWS_KEPT, SENT_AT, new_memory
from gimbal_hil.loop.host.program import AxisCommand, Program, Segment, program_of
from gimbal_hil.loop.host.states import HostCause, HostState, LinkStatus, UnnamedAxis
from gimbal_hil.loop.host.tick_row import LOG_WORDS, ROW_WORDS

_RECORD_SIZE = 10
#: for each number of bytes what cuts them out of a buffer, in half the time of a slice of a memoryview
_CUTS = tuple(struct.Struct(f"{size}s").unpack_from for size in range(257))


@cache
def _idle_plan() -> NDArray[np.float64]:
    """What a host has before its first command; nobody writes into a plan."""
    return program_of([Segment(outer=AxisCommand(), inner=AxisCommand())]).values


class Host:
    """Supervisor and control of one antenna. Everything it decides on comes through `tick` and the four commands.

    Fed the same calls again it sends the same bytes, which is what replay relies on. Not for several threads.
    """

    def __init__(self, configuration: NDArray[np.float64], axes: Sequence[str] = AXIS_NAMES) -> None:
        """`configuration` is the array `C`, shape (C_SIZE,), see `settings.host_configuration`; `axes` what events call
        both axes.
        """
        self.axes = tuple(axes)
        self.memory = new_memory(configuration)
        self.plan = _idle_plan()
        self._rows_taken = 0
        self._words, self._octets = self.memory.words, self.memory.octets.data
        # plain views: a number taken out of an array is several times slower, and this is done every tick
        self._integers = self.memory.integers.data
        self._log = self.memory.log.data.cast("B")
        self._events_taken = 0

    def command(self, program: Program) -> None:
        """Follow a program from the next tick on, in place of what is followed now. Refused, with an event, unless IDLE
        or ACTIVE. An axis that it does not name is held as configured.
        """
        self.plan = program.holding(UnnamedAxis(int(self.memory.C[layout.UNNAMED_AXIS])))
        G = self.memory.G
        G[layout.PLAN_LENGTH] = program.length
        G[layout.REQUESTS] |= layout.REQUEST_START

    def adjust(self, configuration: NDArray[np.float64]) -> None:
        """Other gains and limits from the next tick on: a whole array `C`, shape (C_SIZE,). Integrators stay."""
        C, H = self.memory.C, self.memory.H
        C[:] = configuration
        for axis in range(layout.AXES):
            h = layout.axis_h(axis)
            H[h + layout.MOST_TORQUE] = most_torque(C[layout.axis_c(axis) + TORQUE_LIMIT], H[h + layout.TORQUE_STEP])

    def learned(self, axis: int) -> list[tuple[int, float, float]]:
        """What the table of an axis holds now: bin, torque in the positive and in the negative direction (N m), without
        bins that hold nothing.
        """
        h, c = layout.axis_h(axis) + LEARNED_TABLE, layout.axis_c(axis) + GIVEN_TABLE
        table = (self.memory.H[h : h + 2 * LEARNED_BINS] + self.memory.C[c : c + 2 * LEARNED_BINS]).reshape(2, -1)
        return [(int(k), float(table[0, k]), float(table[1, k])) for k in np.flatnonzero(table.any(axis=0))]

    def stop(self) -> None:
        """Brake to rest, then switch torque off."""
        self.memory.G[layout.REQUESTS] |= layout.REQUEST_STOP

    def quick_stop(self) -> None:
        """No more torque from here: the drive brakes by itself; ends in FAULT, left by `reset_fault`."""
        self.memory.G[layout.REQUESTS] |= layout.REQUEST_QUICK_STOP

    def distrust(self) -> None:
        """Torque off now and a stop without sensors, because the antenna failed its first test; ends in FAULT."""
        self.memory.G[layout.REQUESTS] |= layout.REQUEST_DISTRUST

    def reset_fault(self) -> None:
        """Leave FAULT, reset the drive's fault whatever it was, and connect anew."""
        self.memory.G[layout.REQUESTS] |= layout.REQUEST_RESET

    def tick(self, tick: int, time_ns: int, received: bytes) -> bytes:
        """One tick: the block received since the last one in, the block to send out. Never raises for what the block
        holds.

        `tick` counts periods and jumps where they were skipped; `time_ns` only goes into the row.
        """
        n = len(received)
        if n > RECEIVED_SIZE:
            # older frames of a flood are dropped, the newest count
            n = RECEIVED_SIZE - RECEIVED_SIZE % _RECORD_SIZE
            received = received[len(received) - len(received) % _RECORD_SIZE - n :][:n]
        self._octets[:n] = received
        sent = host_frame_tick(self._words, self.plan, n, tick, time_ns)
        block: bytes = _CUTS[sent](self._octets, SENT_AT)[0]
        return block

    def forget_log(self) -> None:
        """Rows and events so far are not those of this host: it has been put where another one stood."""
        self._rows_taken = int(self._words[LOG_COUNT])
        self._events_taken = int(self._integers[layout.EVENT_COUNT])

    @property
    def row(self) -> bytes:
        """Row of the last tick, bytes of one `runs.TICK_ROW`."""
        at = (self._integers[LOG_COUNT] - 1) % ROWS_KEPT * (8 * LOG_WORDS)
        return self._log[at : at + 8 * ROW_WORDS].tobytes()

    def take_log(self) -> NDArray[np.int64]:
        """Log rows since the last call (at most ROWS_KEPT), int64 (n, LOG_WORDS): see `tick_row`."""
        written = int(self._words[LOG_COUNT])
        first = max(self._rows_taken, written - ROWS_KEPT)
        self._rows_taken = written
        begin, end = first % ROWS_KEPT, written % ROWS_KEPT
        if begin < end:
            return self.memory.log[begin:end].copy()
        return (
            np.concatenate([self.memory.log[begin:], self.memory.log[:end]])
            if written > first
            else self.memory.log[:0].copy()
        )

    def events(self) -> list[HostEvent]:
        """Events since the last call, oldest first; of a burst the newest EVENT_CAPACITY."""
        count = self._integers[layout.EVENT_COUNT]
        if count == self._events_taken:
            return []
        G = self.memory.G
        first = max(self._events_taken, count - layout.EVENT_CAPACITY)
        self._events_taken = count
        ring = G[layout.EVENTS : layout.EVENTS + layout.EVENT_CAPACITY * layout.EVENT_SIZE].reshape(
            -1, layout.EVENT_SIZE
        )
        return [host_event(self.axes, *(int(v) for v in ring[k % layout.EVENT_CAPACITY])) for k in range(first, count)]

    @property
    def state(self) -> HostState:
        """Where the supervisor stands."""
        return HostState(int(self.memory.integers[layout.STATE]))

    @property
    def cause(self) -> HostCause:
        """Why the host last stopped or went to FAULT."""
        return HostCause(int(self.memory.integers[layout.CAUSE]))

    @property
    def link_status(self) -> LinkStatus:
        """How far feedback can be relied on."""
        return LinkStatus(int(self.memory.integers[layout.LINK_STATUS]))

    @property
    def following(self) -> bool:
        """Whether a segment runs or the next one of the program is due."""
        return bool(self.memory.integers[layout.SEGMENT_RUNS]) or bool(
            self.memory.integers[layout.REQUESTS] & layout.REQUEST_START
        )

    def status(self) -> Json:
        """For people and dashboards: state, measurements, references, torques, drive; plain JSON."""
        G, H = self.memory.G, self.memory.H
        axes = {}
        for axis, name in enumerate(self.axes):
            h = layout.axis_h(axis)
            axes[name] = {
                "mode": Mode(int(G[layout.axis_g(axis) + layout.MODE])).name.lower(),
                "position_rad": float(H[h + layout.MEASURED_POSITION]),
                "rate_rad_s": float(H[h + layout.MEASURED_RATE]),
                "torque_nm": float(H[h + TORQUE]),
                "reference": float(H[h + layout.REFERENCE]),
                "motor_torque_nm": float(H[h + layout.MOTOR_TORQUE]),
                "motor_temperature_degc": float(H[h + layout.MOTOR_TEMPERATURE]),
            }
        return {
            "state": self.state.name.lower(),
            "cause": self.cause.name.lower(),
            "link": self.link_status.name.lower(),
            "drive_state": int(G[layout.DRIVE_STATE]),
            "drive_fault": int(G[layout.DRIVE_FAULT]),
            "deadman_margin_ticks": int(G[layout.DEADMAN_MARGIN]),
            "segment": int(G[layout.TICK_SEGMENT]),
            "axes": axes,
        }
