"""The files that a stream of rows lies in: `ticks.arrow`, then `ticks.0002.arrow` and so on, each a whole Arrow
stream.
"""

from __future__ import annotations

from pathlib import Path


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
