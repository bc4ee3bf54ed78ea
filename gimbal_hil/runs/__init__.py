"""Run folders: write while running, read in any state, replay, export."""

from gimbal_hil.runs.growing import GrowingLog
from gimbal_hil.runs.header import RunEnd, RunHeader, RunRecord, read_header
from gimbal_hil.runs.integrity import content_hash
from gimbal_hil.runs.reader import Run, is_run_folder, open_run
from gimbal_hil.runs.schema import (
    FRAME_ROW,
    TICK_ROW,
    Event,
    EventKind,
    FrameDirection,
    blocks_of_frames,
    tick_rows,
)
from gimbal_hil.runs.writer import RunWriter

__all__ = [
    "FRAME_ROW",
    "TICK_ROW",
    "Event",
    "EventKind",
    "FrameDirection",
    "GrowingLog",
    "Run",
    "RunEnd",
    "RunHeader",
    "RunRecord",
    "RunWriter",
    "blocks_of_frames",
    "content_hash",
    "is_run_folder",
    "open_run",
    "read_header",
    "tick_rows",
]
