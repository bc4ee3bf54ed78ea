"""A satellite from its two-line elements, by skyfield: SGP4, then TEME to Earth-fixed axes.

Skyfield's own table gives the difference between civil time and the Earth's rotation, so nothing is downloaded. Polar
motion is left out (15 m at most). The elements are the larger error: about 1 km when they are fresh and 1 to 3 km a day
after, which is 2 mrad at 500 km.
"""

from __future__ import annotations

from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

from firmware_protocol.errors import BadInputError
from gimbal_hil.pointing.following.geodesy import Table

#: elements this old still say where the satellite is about, days
OLD_DAYS = 14.0
_LINE = 69
#: times at once: skyfield holds some thousand numbers for each, which would be 10 GB for ten minutes of ticks
_AT_ONCE = 4096


@dataclass(frozen=True)
class Elements:
    """Two-line elements, checked."""

    name: str
    first: str
    second: str

    def positions(self, start: datetime, time_s: Table) -> Table:
        """ECEF positions (n, 3), m, so many seconds after `start`; BadInputError where SGP4 has none."""
        api, itrs = _skyfield()
        scale = api.load.timescale(builtin=True)
        start = start.astimezone(UTC)
        seconds = start.second + 1e-6 * start.microsecond + time_s
        satellite: Any = api.EarthSatellite(self.first, self.second, self.name, scale)
        found = np.empty((len(seconds), 3))
        for begin in range(0, len(seconds), _AT_ONCE):
            some = slice(begin, begin + _AT_ONCE)
            times = scale.utc(start.year, start.month, start.day, start.hour, start.minute, seconds[some])
            found[some] = satellite.at(times).frame_xyz(itrs).m.T
        if not np.all(np.isfinite(found)):
            raise BadInputError(f"elements of {self.name}", "give no position at that time", "elements of these days")
        return found


def read_elements(path: Path) -> Elements:
    """The first satellite in a file: two lines of elements, with a name before them or not."""
    try:
        lines = [line.rstrip() for line in path.read_text(encoding="ascii").splitlines() if line.strip()]
    except (OSError, UnicodeDecodeError) as error:
        raise BadInputError(str(path), f"cannot be read ({error})", "a file with two-line elements") from None
    for place in range(len(lines) - 1):
        first, second = lines[place], lines[place + 1]
        if first.startswith("1 ") and second.startswith("2 "):
            for line in (first, second):
                _require_line(path, line)
            name = lines[place - 1].removeprefix("0 ").strip() if place else f"satellite {first[2:7].strip()}"
            return Elements(name, first, second)
    raise BadInputError(str(path), "holds no two-line elements", "a line that begins with 1, and one with 2")


def _require_line(path: Path, line: str) -> None:
    """A line of elements has its length and its checksum: digits, and a minus counts as one."""
    if len(line) != _LINE:
        raise BadInputError(f"{path}: line {line[0]}", f"has {len(line)} characters", f"{_LINE}")
    total = sum(int(sign) if sign.isdigit() else sign == "-" for sign in line[:-1]) % 10
    if line[-1] != str(total):
        raise BadInputError(f"{path}: line {line[0]}", f"ends in {line[-1]}", f"the checksum of the line, {total}")


def _skyfield() -> tuple[Any, Any]:
    """Skyfield and its Earth-fixed axes; BadInputError where it is not installed."""
    try:
        from skyfield import api
        from skyfield.framelib import itrs
    except ModuleNotFoundError:
        expected = "pip install 'gimbal-hil[satellites]'"
        raise BadInputError("--target", "a satellite by its elements needs skyfield", expected) from None
    return api, itrs
