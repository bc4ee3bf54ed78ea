"""A run's frames as Vector BLF, raw as they were on the wire."""

from __future__ import annotations

from pathlib import Path

from gimbal_hil.data.exports.groups import PROGRESS_ROWS, Progress, frames_of, start_ns
from gimbal_hil.data.runs import FrameDirection, RecordedRun

_STANDARD_IDENTIFIERS = 0x800


def export_blf(run: RecordedRun, path: Path, progress: Progress) -> int:
    """Both directions, damaged frames included; answers how many."""
    from can import Message as CanMessage
    from can.io.blf import BLFWriter

    frames = frames_of(run)
    frames = frames[frames["identifier"] < _STANDARD_IDENTIFIERS]
    start_s, period_s = start_ns(run) / 1e9, run.record.header.period_ns / 1e9
    with BLFWriter(path) as writer:
        for place, frame in enumerate(frames):
            message = CanMessage(
                timestamp=start_s + int(frame["tick"]) * period_s,
                arbitration_id=int(frame["identifier"]),
                is_extended_id=False,
                data=frame["payload"].tobytes(),
                is_rx=bool(frame["direction"] == FrameDirection.DEVICE_TO_HOST),
                channel=0,
            )
            writer.on_message_received(message)
            if place % PROGRESS_ROWS == 0:
                progress(place, len(frames))
    progress(len(frames), len(frames))
    return len(frames)
