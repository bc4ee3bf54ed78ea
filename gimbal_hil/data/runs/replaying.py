"""Run a recorded run again: the same frames and commands into the same host core, bit by bit against what it did
then.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.errors import BadInputError
from firmware_protocol.protocol_versions import CURRENT
from firmware_protocol.schema import BY_CAN_ID
from gimbal_hil.data.runs.difference import Difference
from gimbal_hil.data.runs.frame_columns import crc_holds, describe_difference, describe_frame
from gimbal_hil.data.runs.log_damage import first_damage
from gimbal_hil.data.runs.reader import RecordedRun
from gimbal_hil.data.runs.schema import CONTENT_WORDS, TICK_ROW, Event, FrameDirection, blocks_of_frames, stored_name

_RECORD = 10
_CONTENT_BYTES = 8 * CONTENT_WORDS[TICK_ROW]


class ReplayHost(Protocol):
    """What replay needs of a host core."""

    def tick(self, tick: int, time_ns: int, received: bytes) -> bytes:
        """One tick: the block received in, the block sent out."""

    @property
    def row(self) -> bytes:
        """Row of the last tick, bytes of one TICK_ROW."""


@dataclass(frozen=True)
class ReplayResult:
    """`difference` is None when every frame sent and every tick row came out bit for bit; `ticks` and `frames` count
    what was compared.
    """

    ticks: int
    frames: int
    difference: Difference | None

    @property
    def identical(self) -> bool:
        """Whether the run is what its log says."""
        return self.difference is None


def replay(
    run: RecordedRun,
    host: ReplayHost,
    give: Callable[[Event], None],
    progress: Callable[[int], None] = lambda done: None,
) -> ReplayResult:
    """Run a log again and stop at the first difference; damage of the log itself counts as one.

    `give` hands a COMMAND event to the host. `progress` gets the number of finished ticks now and then. Raises
    BadInputError when the log has no tick that could be run again.
    """
    if run.protocol is not CURRENT:
        theirs = run.protocol.version
        wanted = (
            f"a run of version {CURRENT.version}; one of version {theirs} replays with the software that recorded it"
        )
        raise BadInputError(str(run.folder), f"was recorded with version {theirs} of the wire", wanted)
    if run.first_segment > 1:
        reason = (
            "the beginning of the run was given up (recording.keep_mb), and a host can only be run again from its start"
        )
        return ReplayResult(0, 0, Difference(-1, "log", f"segment {run.first_segment} on", "segment 1 on", reason))
    if run.replayable_ticks == 0:
        raise BadInputError(str(run.folder), "holds no whole batch of ticks and frames", "a longer recording")
    damage = first_damage(run)
    rows = run.ticks[: min(run.replayable_ticks, _sound_rows(run, damage))]
    received, sent = (
        BlocksByTick(run.frames, FrameDirection.DEVICE_TO_HOST),
        BlocksByTick(run.frames, FrameDirection.HOST_TO_DEVICE),
    )
    commands = sorted(run.commands(), key=lambda event: event.tick)
    recorded = np.ascontiguousarray(rows).tobytes()
    given = frames = 0
    for place, (tick, time_ns) in enumerate(zip(rows["tick"].tolist(), rows["time_ns"].tolist(), strict=True)):
        while given < len(commands) and commands[given].tick <= tick:
            give(commands[given])
            given += 1
        arrived, expected = received.of(tick), sent.of(tick)
        answer = host.tick(tick, time_ns, arrived)
        frames += (len(arrived) + len(answer)) // _RECORD
        start = place * TICK_ROW.itemsize
        if answer != expected:
            return ReplayResult(place + 1, frames, _frame_difference(tick, expected, answer, arrived))
        if host.row[:_CONTENT_BYTES] != recorded[start : start + _CONTENT_BYTES]:
            return ReplayResult(
                place + 1, frames, _row_difference(rows[place], host.row, arrived, run.record.header.axes)
            )
        if place % 1024 == 1023:
            progress(place + 1)
    progress(len(rows))
    return ReplayResult(len(rows), frames, damage)


def _sound_rows(run: RecordedRun, damage: Difference | None) -> int:
    """How many leading tick rows the damage of the log cannot touch, as the log stands and as it was."""
    touched = [*run.ticks["tick"][run.broken_ticks].tolist(), *run.frames["tick"][run.broken_frames].tolist()]
    if damage is not None and damage.tick >= 0:
        touched.append(damage.tick)
    if not touched:
        return len(run.ticks)
    stop = np.flatnonzero(run.ticks["tick"] >= min(touched))
    return int(min([len(run.ticks), *stop[:1], *run.broken_ticks[:1]]))


class BlocksByTick:
    """The blocks of one direction by tick."""

    def __init__(self, frames: NDArray[np.void], direction: FrameDirection) -> None:
        rows = frames[frames["direction"] == direction]
        rows = rows[np.argsort(rows["tick"], kind="stable")]
        ticks, starts, counts = np.unique(rows["tick"], return_index=True, return_counts=True)
        self._data = blocks_of_frames(rows)
        self._spans = dict(
            zip(ticks.tolist(), zip(starts.tolist(), (starts + counts).tolist(), strict=True), strict=True)
        )

    def of(self, tick: int) -> bytes:
        """The block of one tick, empty where nothing went this way."""
        start, end = self._spans.get(tick, (0, 0))
        return self._data[_RECORD * start : _RECORD * end]


def _frame_difference(tick: int, recorded: bytes, answer: bytes, arrived: bytes) -> Difference:
    hint = _hint(arrived)
    for (identifier, payload), (again, word) in zip(_records(recorded), _records(answer), strict=False):
        if identifier != again:
            names = describe_frame(identifier), describe_frame(again)
            return Difference(tick, "frame sent", *names, f"the host core sends another frame{hint}")
        if payload != word:
            signal, expected, found = describe_difference(identifier, word, payload)
            return Difference(tick, signal, found, expected, f"the host core sends another value{hint}")
    counts = f"{len(recorded) // _RECORD} frames", f"{len(answer) // _RECORD} frames"
    return Difference(tick, "frames sent", *counts, f"the host core sends another number of frames{hint}")


def _row_difference(recorded: np.void, row: bytes, arrived: bytes, axes: tuple[str, str]) -> Difference:
    again = np.frombuffer(row, TICK_ROW)[0]
    names = [name for name in TICK_ROW.names or () if recorded[name].tobytes() != again[name].tobytes()]
    values = str(recorded[names[0]].item()), str(again[names[0]].item())
    return Difference(
        int(recorded["tick"]),
        stored_name(names[0], axes),
        *values,
        f"the host core comes to another result{_hint(arrived)}",
    )


def _hint(arrived: bytes) -> str:
    """Received frames that may be the cause: those that fail their CRC."""
    bad = [describe_frame(identifier) for identifier, payload in _records(arrived) if not _is_good(identifier, payload)]
    return f"; at this tick {bad[0]} in the log fails its CRC" if bad else ""


def _is_good(identifier: int, payload: int) -> bool:
    message = BY_CAN_ID.get(identifier)
    return message is not None and bool(crc_holds(message, np.array([payload], np.uint64))[0])


def _records(block: bytes) -> list[tuple[int, int]]:
    return [
        (int.from_bytes(block[at : at + 2], "little"), int.from_bytes(block[at + 2 : at + _RECORD], "little"))
        for at in range(0, len(block), _RECORD)
    ]
