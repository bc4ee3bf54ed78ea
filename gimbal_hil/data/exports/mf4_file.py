"""A run as MDF 4: a channel group a group, physical units, enumerations with the names of their values."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path

from gimbal_hil.data.exports.groups import ExportedSignal, Group, Progress, missing_extra
from gimbal_hil.data.runs import RecordedRun


def export_mf4(run: RecordedRun, groups: tuple[Group, ...], path: Path, progress: Progress) -> int:
    """Channels `group.channel` over seconds of the run; answers their number."""
    try:
        from asammdf import MDF, Signal
    except ImportError:
        raise missing_extra("mf4", "asammdf") from None

    with MDF(version="4.10") as file:
        for done, group in enumerate(groups):
            progress(done, len(groups))
            time_s = group.time_ns / 1e9
            signals = [
                Signal(
                    one.values, time_s, unit=one.unit, name=f"{group.name}.{one.name}", conversion=_names_of_values(one)
                )
                for one in group.channels
            ]
            file.append(signals, comment=group.name)
        file.header.start_time = datetime.fromisoformat(run.record.started_utc)
        file.save(path, overwrite=True)
    progress(len(groups), len(groups))
    return sum(len(group.channels) for group in groups)


def _names_of_values(channel: ExportedSignal) -> dict[str, object] | None:
    """MDF's table from value to text."""
    if channel.labels is None:
        return None
    table: dict[str, object] = {}
    for place, (value, name) in enumerate(sorted(channel.labels.items())):
        table |= {f"val_{place}": value, f"text_{place}": name.encode()}
    return table | {"default": b""}
