"""The files that a part of the log lies in: `ticks.arrow`, then `ticks.0002.arrow` and so on; likewise frames, events
and the chain. All parts of a segment begin and are given up together.
"""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from pathlib import Path

from gimbal_hil.data.runs.schema import EVENTS_FILE


def segment_name(stream: str, number: int) -> str:
    """File name of segment `number`, counted from 1, of a stream such as `ticks.arrow`."""
    stem, _, ending = stream.rpartition(".")
    return stream if number == 1 else f"{stem}.{number:04d}.{ending}"


def segments_of(folder: Path, stream: str) -> list[tuple[int, Path]]:
    """Number and path of every segment that is there, oldest first; old ones may have been given up
    (`recording.keep_mb`).
    """
    stem, _, ending = stream.rpartition(".")
    found = [(1, folder / stream)] if (folder / stream).exists() else []
    for path in folder.glob(f"{stem}.[0-9]*.{ending}"):
        number = path.name[len(stem) + 1 : -len(ending) - 1]
        if number.isdecimal() and len(number) < 10 and segment_name(stream, int(number)) == path.name:
            found.append((int(number), path))
    return sorted(found)


def newest_events_file(folder: Path) -> Path:
    """Where the next event of a run belongs."""
    segments = segments_of(folder, EVENTS_FILE)
    return segments[-1][1] if segments else folder / EVENTS_FILE


def give_up_old_segments(folder: Path, parts: Sequence[str], keep_bytes: float) -> list[int]:
    """Remove whole segments of all parts, oldest first, while the ones behind them hold `keep_bytes`; their numbers."""
    sizes: dict[int, int] = {}
    for part in parts:
        for number, path in segments_of(folder, part):
            with contextlib.suppress(OSError):
                sizes[number] = sizes.get(number, 0) + path.stat().st_size
    given_up: list[int] = []
    for number in sorted(sizes)[:-1]:
        if sum(size for other, size in sizes.items() if other > number) < keep_bytes:
            break
        for part in parts:
            with contextlib.suppress(OSError):  # what cannot be removed is tried again with the next segment
                (folder / segment_name(part, number)).unlink(missing_ok=True)
        del sizes[number]
        given_up.append(number)
    return given_up
