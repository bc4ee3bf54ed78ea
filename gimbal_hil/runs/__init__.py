"""Run folders: write while running, read in any state, replay, export."""

from gimbal_hil.runs.difference import Difference
from gimbal_hil.runs.disk import Retention
from gimbal_hil.runs.frame_columns import MessageColumns, columns_of
from gimbal_hil.runs.frame_export import Progress, export_blf, export_mcap, export_mf4
from gimbal_hil.runs.growing import GrowingLog
from gimbal_hil.runs.header import RUN_FILE, RunEnd, RunHeader, RunRecord, read_header, wall_clock_utc
from gimbal_hil.runs.integrity import content_hash
from gimbal_hil.runs.log_damage import damage_of
from gimbal_hil.runs.reader import Run, is_run_folder, open_run
from gimbal_hil.runs.replaying import ReplayResult, replay
from gimbal_hil.runs.schema import (
    AXES,
    FRAME_ROW,
    TICK_ROW,
    Event,
    EventKind,
    FrameDirection,
    StepPurpose,
    blocks_of_frames,
    tick_rows,
)
from gimbal_hil.runs.writer import RunWriter

__all__ = [
    "AXES",
    "FRAME_ROW",
    "RUN_FILE",
    "TICK_ROW",
    "Difference",
    "Event",
    "EventKind",
    "FrameDirection",
    "GrowingLog",
    "MessageColumns",
    "Progress",
    "ReplayResult",
    "Retention",
    "Run",
    "RunEnd",
    "RunHeader",
    "RunRecord",
    "RunWriter",
    "StepPurpose",
    "blocks_of_frames",
    "columns_of",
    "content_hash",
    "damage_of",
    "export_blf",
    "export_mcap",
    "export_mf4",
    "is_run_folder",
    "open_run",
    "read_header",
    "replay",
    "tick_rows",
    "wall_clock_utc",
]
