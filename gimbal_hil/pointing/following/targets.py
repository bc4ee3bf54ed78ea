"""What an antenna is to look at, as directions over time.

azel:120,35     azimuth clockwise from true north and elevation above the horizon, degrees
geo:13.0E       a geostationary longitude, degrees (W or a minus for the west)
tle:FILE        a satellite by its two-line elements
FILE.csv        columns time_s, azimuth_deg, elevation_deg, from the start on
"""

from __future__ import annotations

import csv
import math
from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np

from firmware_protocol.errors import BadInputError
from gimbal_hil.pointing.following.geodesy import Flight, Table, geostationary, seen_from
from gimbal_hil.pointing.following.satellite import Elements, read_elements

#: azimuth (rad, clockwise from north, without jumps) and elevation (rad) so many seconds after the start
Directions = Callable[[Table], tuple[Table, Table]]
_FORMS = "azel:AZIMUTH,ELEVATION, geo:LONGITUDE, tle:FILE, or a CSV file with time_s, azimuth_deg, elevation_deg"
_COLUMNS = ("time_s", "azimuth_deg", "elevation_deg")
#: how far ahead a pass is looked for, and in which steps
_AHEAD_S, _STEP_S = 86400.0, 20.0


@dataclass(frozen=True)
class Target:
    """A target by name, and where it is seen from the aircraft."""

    name: str
    directions: Directions
    #: seconds that it is known for
    lasts_s: float = math.inf

    def require_visible(self, duration_s: float, advice: str = "") -> None:
        """BadInputError where it is below the horizon at the start, or not known for so long."""
        if duration_s > self.lasts_s:
            raise BadInputError("--duration", f"{duration_s:g} s", f"at most {self.lasts_s:g} s, which the file has")
        _, elevation = self.directions(np.zeros(1))
        if elevation[0] <= 0.0:
            below = f"{self.name} is {-math.degrees(elevation[0]):.1f} degrees below the horizon at the start"
            raise BadInputError("--target", below, advice or "a target above the horizon")


def target_of(text: str, flight: Flight | None, start: datetime) -> Target:
    """The target that a text names; BadInputError says what was expected."""
    kind, _, value = text.partition(":")
    if kind == "azel":
        return _fixed(value)
    if kind == "geo":
        return _standing(value, _known(flight, text))
    if kind == "tle":
        return _passing(read_elements(Path(value)), _known(flight, text), start)
    if text.endswith(".csv"):
        return _listed(Path(text))
    raise BadInputError("--target", f"is {text!r}", _FORMS)


def next_pass(target: Target, start: datetime, duration_s: float) -> str:
    """In words when a target comes up within a day of the start, for those who asked too early."""
    time_s = np.arange(0.0, _AHEAD_S, _STEP_S)
    _, elevation = target.directions(time_s)
    up = elevation > 0.0
    rises = np.flatnonzero(up[1:] & ~up[:-1]) + 1
    if not len(rises):
        return "a target that comes above the horizon within a day"
    rise = int(rises[0])
    sets = np.flatnonzero(~up[rise:])
    end = rise + (int(sets[0]) if len(sets) else len(up) - rise)
    at = start + timedelta(seconds=float(time_s[rise]))
    highest, long_s = math.degrees(float(elevation[rise:end].max())), _STEP_S * (end - rise)
    return f"--at {at:%Y-%m-%dT%H:%M:%SZ}: it rises then, for {long_s:.0f} s, {highest:.0f} degrees at its highest"


def _known(flight: Flight | None, target: str) -> Flight:
    if flight is None:
        raise BadInputError(f"--target {target}", "is seen from somewhere", "--position LAT,LON,ALT")
    return flight


def _fixed(value: str) -> Target:
    try:
        azimuth, elevation = (math.radians(float(word)) for word in value.split(","))
    except ValueError:
        raise BadInputError("--target", f"is azel:{value}", "azel:AZIMUTH,ELEVATION in degrees") from None
    if not abs(azimuth) <= 2.0 * math.pi or not abs(elevation) <= 0.5 * math.pi:
        raise BadInputError("--target", f"is azel:{value}", "azimuth -360 to 360, elevation -90 to 90 degrees")

    def directions(time_s: Table) -> tuple[Table, Table]:
        return np.full(len(time_s), azimuth), np.full(len(time_s), elevation)

    return Target(f"azimuth {math.degrees(azimuth):g}, elevation {math.degrees(elevation):g} degrees", directions)


def _standing(value: str, flight: Flight) -> Target:
    side = -1.0 if value[-1:] in "Ww" and value else 1.0
    try:
        longitude = side * float(value.rstrip("EeWw"))
    except ValueError:
        longitude = math.nan
    if not abs(longitude) <= 360.0:
        raise BadInputError("--target", f"is geo:{value}", "geo:LONGITUDE in degrees, as in geo:13.0E")

    def directions(time_s: Table) -> tuple[Table, Table]:
        return seen_from(flight, time_s, geostationary(longitude, len(time_s)))

    return Target(f"geostationary {abs(longitude):g} {'W' if longitude < 0.0 else 'E'}", directions)


def _passing(elements: Elements, flight: Flight, start: datetime) -> Target:
    def directions(time_s: Table) -> tuple[Table, Table]:
        return seen_from(flight, time_s, elements.positions(start, time_s))

    return Target(elements.name, directions)


def _listed(path: Path) -> Target:
    expected = f"columns {', '.join(_COLUMNS)} and two rows or more, times increasing"
    try:
        with path.open(newline="", encoding="utf-8") as handle:
            rows = [[float(row[name]) for name in _COLUMNS] for row in csv.DictReader(handle)]
        time_s, azimuth, elevation = np.array(rows, dtype=np.float64).T
    except (OSError, KeyError, TypeError, ValueError) as error:
        raise BadInputError(str(path), f"cannot be read as directions ({error})", expected) from None
    if len(time_s) < 2 or not np.all(np.isfinite(rows)) or np.any(np.diff(time_s) <= 0.0):
        raise BadInputError(str(path), "is no list of directions", expected)
    turned, raised = np.unwrap(np.radians(azimuth)), np.radians(elevation)

    def directions(at_s: Table) -> tuple[Table, Table]:
        at_s = at_s + time_s[0]
        return np.interp(at_s, time_s, turned), np.interp(at_s, time_s, raised)

    return Target(path.name, directions, float(time_s[-1] - time_s[0]))
