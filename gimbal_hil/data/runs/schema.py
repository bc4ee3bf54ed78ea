"""What a run's log holds: one row a host tick, one row a frame, one event a change.

Both row types are packed into whole 64-bit words. The words that two runs of equal seed and input must share come
first, readings of the wall clock after them, and the upper half of the last word is the row's check (see `integrity`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum, IntEnum, StrEnum

import numpy as np
from numpy.typing import NDArray

#: what the columns of TICK_ROW call the axes: the carrying one, the carried one; files have the antenna's own names in
#: their place
AXES = ("outer", "inner")

#: files of a run folder that hold its log
TICKS_FILE, FRAMES_FILE, EVENTS_FILE = "ticks.arrow", "frames.arrow", "events.jsonl"


class FrameDirection(IntEnum):
    """Which way the bytes of a frame row went."""

    HOST_TO_DEVICE = 0
    #: handed to the host core as received, valid or not: what replay feeds
    DEVICE_TO_HOST = 1


class EventKind(Enum):
    """What an event reports. COMMAND is input from outside the host core: replay gives it back; the others are
    observations.
    """

    COMMAND = "command"
    SEGMENT = "segment"
    STATE = "state"
    FAULT = "fault"
    LINK = "link"
    DRIVE = "drive"
    TIMING = "timing"
    RECORDING = "recording"
    NOTE = "note"


class StepPurpose(StrEnum):
    """What a SEGMENT event of an experiment began, under the key `purpose` of its data."""

    MEASUREMENT = "measurement"
    #: the way back to a safe pose, and torque off
    TEARDOWN = "teardown"


#: key of a COMMAND event that says where the host stood: the log begins, or goes on after a gap, at its tick
BEGINS = "begins"

#: one row a host tick; torques in N m, angles in rad, rates in rad/s; `time_ns` is the scheduled time of the tick
TICK_ROW = np.dtype(
    [
        ("tick", "<i8"),
        ("time_ns", "<i8"),
        ("position_ref_outer", "<f8"),
        ("position_ref_inner", "<f8"),
        ("rate_ref_outer", "<f8"),
        ("rate_ref_inner", "<f8"),
        ("torque_outer", "<f8"),
        ("torque_inner", "<f8"),
        ("segment", "<i4"),
        ("skipped_ticks", "<i4"),  # whole periods that the host lost just before this tick
        ("host_state", "i1"),
        ("mode_outer", "i1"),
        ("mode_inner", "i1"),
        ("link_status", "i1"),
        ("rejected_frames", "<i4"),  # received at this tick and dropped by CRC, counter or bounds
        ("wake_latency_ns", "<i4"),
        ("computing_ns", "<i4"),
        ("miss_cause", "<i4"),
        ("check", "<u4"),
    ]
)

#: one row a frame; `payload` is the eight bytes read as a little-endian word
FRAME_ROW = np.dtype(
    [("tick", "<i8"), ("payload", "<u8"), ("identifier", "<u2"), ("direction", "<u2"), ("check", "<u4")]
)

#: columns of a tick row that are readings of the wall clock: no part of a run's content
WALL_CLOCK_COLUMNS = ("wake_latency_ns", "computing_ns", "miss_cause")

#: 64-bit words at the start of each row type that make up a run's content
CONTENT_WORDS = {TICK_ROW: 10, FRAME_ROW: 3}

#: one frame in a block, as links, host and device pass it
BLOCK_RECORD = np.dtype([("identifier", "<u2"), ("payload", "<u8")])


@dataclass(frozen=True)
class Event:
    """One change, at the tick at which it took effect; `data` is plain JSON."""

    tick: int
    time_ns: int
    kind: EventKind
    text: str
    data: Mapping[str, object] = field(default_factory=dict)

    @property
    def begins_teardown(self) -> bool:
        """Whether an experiment is over here and only makes safe what it moved."""
        return self.kind is EventKind.SEGMENT and self.data.get("purpose") == StepPurpose.TEARDOWN

    @property
    def begins_log(self) -> bool:
        """Whether the log begins here, or goes on after a gap, with the host as the event says."""
        return self.kind is EventKind.COMMAND and self.data.get(BEGINS) is True


def stored_name(column: str, axes: Sequence[str]) -> str:
    """What a column of a row type is called in files of an antenna with these axes."""
    for own, name in zip(AXES, axes, strict=True):
        if column.endswith(f"_{own}"):
            return column.removesuffix(own) + name
    return column


def tick_rows(count: int) -> NDArray[np.void]:
    """`count` empty tick rows to be filled and appended."""
    return np.zeros(count, TICK_ROW)


def frames_of_blocks(ticks: NDArray[np.int64], directions: NDArray[np.int64], blocks: list[bytes]) -> NDArray[np.void]:
    """Frame rows of blocks (runs of ten-byte records), each with its tick and direction."""
    sizes = np.fromiter(map(len, blocks), np.int64, len(blocks))
    if np.any(sizes % BLOCK_RECORD.itemsize):
        raise ValueError("a block is a whole number of ten-byte records")
    counts = sizes // BLOCK_RECORD.itemsize
    records = np.frombuffer(b"".join(blocks), BLOCK_RECORD)
    rows = np.zeros(len(records), FRAME_ROW)
    rows["tick"] = np.repeat(ticks, counts)
    rows["direction"] = np.repeat(directions, counts)
    rows["identifier"] = records["identifier"]
    rows["payload"] = records["payload"]
    return rows


def blocks_of_frames(frames: NDArray[np.void]) -> bytes:
    """The block (ten-byte records, in order) that frame rows came from."""
    records = np.zeros(len(frames), BLOCK_RECORD)
    records["identifier"] = frames["identifier"]
    records["payload"] = frames["payload"]
    return records.tobytes()
