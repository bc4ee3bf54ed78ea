"""ASAM MDF, version 3 and 4 (`asammdf` owns it): a group a channel group, times of its master channel."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from gimbal_hil.data.containers.contents import Contents, SampledGroup, from_first, missing


def is_mdf(path: Path, start: bytes) -> bool:
    """By its magic bytes; a recording that was not finished begins otherwise."""
    return start.startswith((b"MDF     ", b"UnFinMF "))


def read_mdf(path: Path) -> Contents:
    """Every channel group with numbers. A name that several groups have is preceded by its group's."""
    try:
        from asammdf import MDF
    except ImportError:
        raise missing(path, "an MF4 (MDF) file", "asammdf", "mf4") from None
    with MDF(str(path)) as file:
        groups = [_group(file, index) for index in range(len(file.groups))]
    filled = [group for group in groups if group.columns]
    times = from_first({group.name: group.time_s for group in filled if group.time_s is not None})
    names = [name for group in filled for name in group.columns]
    several = {name for name in names if names.count(name) > 1}
    return Contents(path, "MF4 file", tuple(_named_apart(group, several, times) for group in filled))


def _group(file: object, index: int) -> SampledGroup:
    columns, units, time_s = {}, {}, None
    for signal in file.select([(None, index, place) for place in _places(file, index)]):  # type: ignore[attr-defined]
        values = np.asarray(signal.samples)
        if values.ndim == 1 and values.dtype.kind in "fiub":
            columns[signal.name] = values.astype(np.float64)
            units[signal.name] = str(signal.unit or "")
            time_s = np.asarray(signal.timestamps, np.float64)
    called = getattr(file.groups[index].channel_group, "acq_name", "") or f"group {index}"  # type: ignore[attr-defined]
    return SampledGroup(f"{called} ({index})", time_s, columns, {name: unit for name, unit in units.items() if unit})


def _places(file: object, index: int) -> list[int]:
    master = file.masters_db.get(index)  # type: ignore[attr-defined]
    return [place for place in range(len(file.groups[index].channels)) if place != master]  # type: ignore[attr-defined]


def _named_apart(group: SampledGroup, several: set[str], times: dict[str, np.ndarray]) -> SampledGroup:
    def called(name: str) -> str:
        return f"{group.name}.{name}" if name in several else name

    return SampledGroup(
        group.name,
        times.get(group.name),
        {called(name): values for name, values in group.columns.items()},
        {called(name): unit for name, unit in group.units.items()},
    )
