"""Where an aircraft is and in which direction it sees a point: WGS 84, in closed form (NIMA TR8350.2).

Earth-fixed axes (ECEF): x to longitude 0 on the equator, z to the north pole, in metres. Azimuth is clockwise from true
north, elevation above the plane that touches the ellipsoid; geometric, without refraction and light time.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.errors import BadInputError

Table = NDArray[np.float64]
#: semi-major axis (m) and square of the eccentricity
_A_M, _E2 = 6378137.0, 6.69437999014e-3
#: radius of the geostationary orbit (m)
GEOSTATIONARY_M = 42164172.0
_MOST_SPEED_M_S, _MOST_ALTITUDE_M = 1500.0, 50e3


@dataclass(frozen=True)
class Flight:
    """A position that may move at a constant speed on a constant track: degrees, m above the ellipsoid, m/s."""

    latitude_deg: float
    longitude_deg: float
    altitude_m: float = 0.0
    speed_m_s: float = 0.0
    track_deg: float = 0.0

    def places(self, time_s: Table) -> tuple[Table, Table]:
        """Latitude and longitude (rad) at times: a rhumb line with the radii of curvature of where it began, which is
        within a metre and a half over ten minutes at 230 m/s and at a latitude of 50 degrees.
        """
        lat = math.radians(self.latitude_deg)
        w2 = 1.0 - _E2 * math.sin(lat) ** 2
        meridian, prime = _A_M * (1.0 - _E2) / w2**1.5, _A_M / math.sqrt(w2)
        north = self.speed_m_s * math.cos(math.radians(self.track_deg)) / (meridian + self.altitude_m)
        east = self.speed_m_s * math.sin(math.radians(self.track_deg)) / (prime + self.altitude_m)
        latitude = lat + north * time_s
        # the parallels get shorter on the way north: their mean over the way
        middle = np.cos(0.5 * (lat + latitude))
        return latitude, math.radians(self.longitude_deg) + east * time_s / middle


def flight_of(position: str, moving: str | None = None) -> Flight:
    """The flight in `LAT,LON,ALT` (degrees, m; ALT may be left out) and `SPEED,TRACK` (m/s, degrees)."""
    numbers = _numbers("--position", position, "LAT,LON,ALT in degrees and m, as in 48.35,11.79,10700", (2, 3))
    lat, lon, alt = (*numbers, 0.0)[:3]
    if abs(lat) > 89.0 or abs(lon) > 360.0 or not -500.0 <= alt <= _MOST_ALTITUDE_M:
        raise BadInputError("--position", position, "latitude -89 to 89, longitude -360 to 360 degrees, up to 50 km")
    if moving is None:
        return Flight(lat, lon, alt)
    speed, track = _numbers("--moving", moving, "SPEED,TRACK in m/s and degrees from north, as in 230,90", (2,))
    if not 0.0 <= speed <= _MOST_SPEED_M_S:
        raise BadInputError("--moving", moving, f"a speed of 0 to {_MOST_SPEED_M_S:g} m/s")
    return Flight(lat, lon, alt, speed, track)


def _numbers(option: str, text: str, expected: str, sizes: tuple[int, ...]) -> list[float]:
    try:
        numbers = [float(word) for word in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) not in sizes or not all(map(math.isfinite, numbers)):
        raise BadInputError(option, f"is {text!r}", expected)
    return numbers


def earth_fixed(latitude: Table, longitude: Table, altitude_m: float) -> Table:
    """ECEF position (n, 3), m, of places (rad)."""
    prime = _A_M / np.sqrt(1.0 - _E2 * np.sin(latitude) ** 2)
    level = (prime + altitude_m) * np.cos(latitude)
    up = (prime * (1.0 - _E2) + altitude_m) * np.sin(latitude)
    return np.column_stack([level * np.cos(longitude), level * np.sin(longitude), up])


def seen_from(flight: Flight, time_s: Table, target_m: Table) -> tuple[Table, Table]:
    """Azimuth (rad, clockwise from north, without jumps) and elevation (rad) of ECEF positions (n, 3) at times."""
    latitude, longitude = flight.places(time_s)
    away = target_m - earth_fixed(latitude, longitude, flight.altitude_m)
    sa, ca, so, co = np.sin(latitude), np.cos(latitude), np.sin(longitude), np.cos(longitude)
    x, y, z = away.T
    east = -so * x + co * y
    north = -sa * co * x - sa * so * y + ca * z
    up = ca * co * x + ca * so * y + sa * z
    return np.unwrap(np.arctan2(east, north)), np.arctan2(up, np.hypot(east, north))


def geostationary(longitude_deg: float, rows: int) -> Table:
    """ECEF position (rows, 3), m, of a satellite that stands above a longitude."""
    angle = math.radians(longitude_deg)
    return np.tile([GEOSTATIONARY_M * math.cos(angle), GEOSTATIONARY_M * math.sin(angle), 0.0], (rows, 1))
