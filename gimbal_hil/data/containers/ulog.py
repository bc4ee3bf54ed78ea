"""ULog, the log of PX4 (`pyulog` owns it): a group a topic, stamps in microseconds."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from gimbal_hil.data.containers.contents import Contents, SampledGroup, from_first, missing

_START = b"ULog\x01\x12\x35"


def is_ulog(path: Path, start: bytes) -> bool:
    """By its magic bytes."""
    return start.startswith(_START)


def read_ulog(path: Path) -> Contents:
    """Every topic of a log; a topic that several instances write has the instance's number in its name."""
    try:
        from pyulog import ULog
    except ImportError:
        raise missing(path, "a ULog", "pyulog", "ulog") from None
    log = ULog(str(path))
    several = {one.name for one in log.data_list if one.multi_id > 0}
    topics = {f"{one.name}.{one.multi_id}" if one.name in several else one.name: one.data for one in log.data_list}
    times = from_first({name: np.asarray(data["timestamp"], np.float64) for name, data in topics.items()}, 1e-6)
    groups = tuple(
        SampledGroup(
            name,
            times[name],
            {f"{name}.{key}": np.asarray(x, np.float64) for key, x in data.items() if key != "timestamp"},
        )
        for name, data in topics.items()
    )
    lost = sum(drop.duration for drop in log.dropouts)
    notes = (f"the logger lost data {len(log.dropouts)} times, {lost} ms in all",) if log.dropouts else ()
    return Contents(path, "ULog", groups, notes)
