"""Run folders: write while running, read in any state, replay."""

from gimbal_hil.data.runs.difference import Difference
from gimbal_hil.data.runs.disk import Retention
from gimbal_hil.data.runs.frame_columns import MessageColumns, columns_of
from gimbal_hil.data.runs.golden import Again, Change, changes, run_again, update
from gimbal_hil.data.runs.growing import GrowingLog
from gimbal_hil.data.runs.header import RUN_FILE, RunEnd, RunHeader, RunRecord, read_header
from gimbal_hil.data.runs.integrity import content_hash
from gimbal_hil.data.runs.log_damage import damage_of, require_frames
from gimbal_hil.data.runs.new_folder import SCOPE_FOLDER
from gimbal_hil.data.runs.reader import RecordedRun, is_run_folder, open_run
from gimbal_hil.data.runs.replaying import ReplayResult, replay
from gimbal_hil.data.runs.run_lock import one_writer
from gimbal_hil.data.runs.schema import (
    AXES,
    BEGINS,
    FRAME_ROW,
    TICK_ROW,
    Event,
    EventKind,
    FrameDirection,
    StepPurpose,
    blocks_of_frames,
    frames_of_blocks,
    stored_name,
    tick_rows,
)
from gimbal_hil.data.runs.segments import newest_events_file
from gimbal_hil.data.runs.writer import RunWriter

__all__ = [
    "AXES",
    "BEGINS",
    "FRAME_ROW",
    "RUN_FILE",
    "SCOPE_FOLDER",
    "TICK_ROW",
    "Again",
    "Change",
    "Difference",
    "Event",
    "EventKind",
    "FrameDirection",
    "GrowingLog",
    "MessageColumns",
    "RecordedRun",
    "ReplayResult",
    "Retention",
    "RunEnd",
    "RunHeader",
    "RunRecord",
    "RunWriter",
    "StepPurpose",
    "blocks_of_frames",
    "changes",
    "columns_of",
    "content_hash",
    "damage_of",
    "frames_of_blocks",
    "is_run_folder",
    "newest_events_file",
    "one_writer",
    "open_run",
    "read_header",
    "replay",
    "require_frames",
    "run_again",
    "stored_name",
    "tick_rows",
    "update",
]
