"""Where targets are seen from an aircraft, against formulas and libraries that the project does not use for it."""

from __future__ import annotations

import builtins
import math
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest

from firmware_protocol.errors import BadInputError
from gimbal_hil.loop.host.references import reference_at
from gimbal_hil.loop.host.states import Shape
from gimbal_hil.pointing.arena import between, boresight
from gimbal_hil.pointing.following import (
    Flight,
    catmull_rom,
    earth_fixed,
    flight_of,
    geostationary,
    joints_seen,
    next_pass,
    read_elements,
    seen_from,
    target_of,
    way_of,
)
from sim_backend.shipped import shipped_file

ELEMENTS = shipped_file("scenarios", "example.tle")
START = datetime(2026, 11, 22, 12, 6, 30, tzinfo=UTC)
MUNICH = Flight(48.35, 11.79, 10700.0, 230.0, 0.0)
TIMES = np.arange(0.0, 600.0, 10.0)


def test_a_geostationary_satellite_stands_where_the_formula_for_a_round_earth_says() -> None:
    # cos(angle at the centre) = cos(latitude) cos(difference in longitude); on the ellipsoid up to 0.2 degrees off
    azimuth, elevation = seen_from(Flight(48.35, 11.79), np.zeros(1), geostationary(30.0, 1))
    lat, east = math.radians(48.35), math.radians(30.0 - 11.79)
    centre = math.acos(math.cos(lat) * math.cos(east))
    assert math.degrees(elevation[0]) == pytest.approx(
        math.degrees(math.atan2(math.cos(centre) - 6378.137 / 42164.172, math.sin(centre))), abs=0.2
    )
    south = 180.0 - math.degrees(math.atan2(math.tan(east), math.sin(lat)))
    assert math.degrees(azimuth[0]) % 360.0 == pytest.approx(south, abs=0.2)
    _, above = seen_from(Flight(0.0, 30.0), np.zeros(1), geostationary(30.0, 1))
    assert above[0] == pytest.approx(math.pi / 2.0)


@pytest.mark.parametrize(("latitude", "longitude"), [(48.35, 11.79), (-33.9, 151.2), (0.0, 29.0), (70.0, -20.0)])
def test_a_geostationary_satellite_stands_where_skyfield_sees_it(latitude: float, longitude: float) -> None:
    from skyfield.api import load, wgs84
    from skyfield.toposlib import ITRSPosition
    from skyfield.units import Distance

    azimuth, elevation = seen_from(Flight(latitude, longitude, 10700.0), np.zeros(1), geostationary(13.0, 1))
    time = load.timescale(builtin=True).utc(2026, 11, 22, 12)
    satellite = ITRSPosition(Distance(m=geostationary(13.0, 1)[0]))
    place = wgs84.latlon(latitude, longitude, elevation_m=10700.0)
    above, around, _ = (satellite - place).at(time).altaz()
    assert elevation[0] == pytest.approx(above.radians, abs=1e-6)
    assert azimuth[0] % (2.0 * math.pi) == pytest.approx(around.radians, abs=1e-6)


def test_a_pass_is_where_skyfield_sees_it_from_a_place_that_stands_still() -> None:
    from skyfield.api import EarthSatellite, load, wgs84

    elements = read_elements(ELEMENTS)
    scale = load.timescale(builtin=True)
    satellite = EarthSatellite(elements.first, elements.second, "", scale)
    times = scale.utc(2026, 11, 22, 12, 6, 30.0 + TIMES)
    above, around, _ = (satellite - wgs84.latlon(48.35, 11.79, elevation_m=10700.0)).at(times).altaz()
    target = target_of(f"tle:{ELEMENTS}", Flight(48.35, 11.79, 10700.0), START)
    azimuth, elevation = target.directions(TIMES)
    assert np.abs(elevation - above.radians).max() < 2e-6
    assert np.abs(np.angle(np.exp(1j * (azimuth - around.radians)))).max() < 1e-5
    assert elevation.min() > 0.1 and math.degrees(elevation.max()) > 60.0


def test_a_satellite_is_where_sgp4_and_the_mean_sidereal_time_put_it() -> None:
    from sgp4.api import Satrec, jday

    elements = read_elements(ELEMENTS)
    found = elements.positions(START, TIMES)
    satellite = Satrec.twoline2rv(elements.first, elements.second)
    for row in range(0, len(TIMES), 10):
        day, fraction = jday(2026, 11, 22, 12, 6, 30.0 + TIMES[row])
        _, teme, _ = satellite.sgp4(day, fraction)
        centuries = (day - 2451545.0 + fraction) / 36525.0
        # Vallado 2013, equation 3-47, seconds of time
        sidereal = (
            67310.54841
            + (876600.0 * 3600.0 + 8640184.812866) * centuries
            + 0.093104 * centuries**2
            - 6.2e-6 * centuries**3
        )
        angle = math.radians(sidereal % 86400.0 / 240.0)
        c, s = math.cos(angle), math.sin(angle)
        x, y, z = (1e3 * value for value in teme)
        # UT1 is taken for UTC here: a tenth of a second of the Earth's rotation at this height is 53 m
        assert np.linalg.norm(found[row] - [c * x + s * y, c * y - s * x, z]) < 60.0


def test_a_flight_is_a_line_of_constant_track_on_the_ellipsoid() -> None:
    flight = Flight(48.35, 11.79, 10700.0, 230.0, 60.0)
    latitude, longitude = flight.places(np.array([600.0]))
    # by small steps, each with the radii of curvature where it begins
    lat, lon, step_s = math.radians(48.35), math.radians(11.79), 0.1
    for _ in range(6000):
        w2 = 1.0 - 6.69437999014e-3 * math.sin(lat) ** 2
        meridian, prime = 6378137.0 * (1.0 - 6.69437999014e-3) / w2**1.5, 6378137.0 / math.sqrt(w2)
        new = lat + step_s * 230.0 * math.cos(math.radians(60.0)) / (meridian + 10700.0)
        lon += step_s * 230.0 * math.sin(math.radians(60.0)) / ((prime + 10700.0) * math.cos(0.5 * (lat + new)))
        lat = new
    end = earth_fixed(np.array([lat]), np.array([lon]), 10700.0)
    # seen from 36,000 km that is a nanoradian, from 800 km away 25 microradians
    assert np.linalg.norm(earth_fixed(latitude, longitude, 10700.0) - end) < 20.0


@pytest.mark.parametrize("text", ["azel:120,35", "geo:13.0E", f"tle:{ELEMENTS}"])
def test_the_way_of_a_target_is_within_a_microradian_of_it_between_its_rows(text: str) -> None:
    target = target_of(text, MUNICH, START)
    way = way_of(target, 600.0)
    assert way.off_rad <= 1e-6 and len(way.outer) < 1500
    time_s = np.linspace(0.0, 600.0, 997)
    found = np.column_stack([catmull_rom(rows, way.row_s, time_s) for rows in (way.outer, way.inner)])
    assert between(boresight(found), boresight(joints_seen(target, time_s))).max() < 2e-6
    # the outer joint turns the other way than a compass, the inner one is positive downwards
    azimuth, elevation = target.directions(np.zeros(1))
    assert way.outer[0] == pytest.approx(-azimuth[0]) and way.inner[0] == pytest.approx(-elevation[0])


def test_the_host_joins_rows_as_the_way_was_judged() -> None:
    rows = np.array([0.1, 0.5, 0.2, -0.4, -0.3])
    plan = np.concatenate([[5.0, 5.0, 0.5, 2.0, 0.0], rows])
    for time_s in (-0.1, 0.0, 0.2, 0.5, 1.3, 1.99, 2.0, 5.0):
        value, slope = reference_at(int(Shape.TIMETABLE), plan, 0, 0.0, 0.0, time_s)
        inside = min(max(time_s, 0.0), 2.0)
        assert value == pytest.approx(2.0 * catmull_rom(rows, 0.5, np.array([inside]))[0], abs=1e-8)
        h = 1e-6
        if 0.0 < time_s < 2.0 - h:
            after, before = (
                reference_at(int(Shape.TIMETABLE), plan, 0, 0.0, 0.0, time_s + k * h)[0] for k in (1.0, -1.0)
            )
            assert slope == pytest.approx((after - before) / (2.0 * h), abs=1e-5)


def test_a_list_of_directions_is_followed_from_its_first_row_and_says_how_long_it_is(tmp_path: Path) -> None:
    file = tmp_path / "way.csv"
    file.write_text("time_s,azimuth_deg,elevation_deg\n10,350,20\n20,10,30\n30,20,40\n")
    target = target_of(str(file), None, START)
    azimuth, elevation = target.directions(np.array([0.0, 5.0, 10.0]))
    np.testing.assert_allclose(np.degrees(azimuth), [350.0, 360.0, 370.0])
    np.testing.assert_allclose(np.degrees(elevation), [20.0, 25.0, 30.0])
    with pytest.raises(BadInputError, match="at most 20 s"):
        target.require_visible(21.0)


def test_a_target_below_the_horizon_is_refused_with_the_next_pass() -> None:
    early = datetime(2026, 11, 22, 11, 50, tzinfo=UTC)
    target = target_of(f"tle:{ELEMENTS}", MUNICH, early)
    told = next_pass(target, early, 600.0)
    assert told.startswith("--at 2026-11-22T12:0")
    with pytest.raises(BadInputError, match="below the horizon"):
        target.require_visible(60.0, told)


@pytest.mark.parametrize(
    ("text", "flight", "words"),
    [
        ("moon", None, "expected azel:"),
        ("azel:1", None, "azel:AZIMUTH,ELEVATION"),
        ("azel:10,95", None, "elevation -90 to 90"),
        ("geo:13.0E", None, "--position"),
        ("geo:here", MUNICH, "geo:LONGITUDE"),
        ("tle:nowhere.tle", MUNICH, "two-line elements"),
        ("nowhere.csv", None, "azimuth_deg"),
    ],
)
def test_what_is_no_target_is_refused_with_what_was_expected(text: str, flight: Flight | None, words: str) -> None:
    with pytest.raises(BadInputError, match=words):
        target_of(text, flight, START)


@pytest.mark.parametrize(("position", "moving"), [("48", None), ("95,0", None), ("48,11,1e9", None), ("48,11", "x")])
def test_what_is_no_position_is_refused(position: str, moving: str | None) -> None:
    with pytest.raises(BadInputError, match=r"--position|--moving"):
        flight_of(position, moving)


def test_elements_with_a_wrong_digit_are_refused(tmp_path: Path) -> None:
    file = tmp_path / "wrong.tle"
    file.write_text(ELEMENTS.read_text().replace("86.4000", "86.5000"))
    with pytest.raises(BadInputError, match="checksum"):
        read_elements(file)


def test_without_skyfield_a_satellite_by_elements_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    real = builtins.__import__

    def without(name: str, *arguments: object, **named: object) -> object:
        if name.startswith("skyfield"):
            raise ModuleNotFoundError(name)
        return real(name, *arguments, **named)  # type: ignore[arg-type]

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(BadInputError, match=r"gimbal-hil\[satellites\]"):
        read_elements(ELEMENTS).positions(START, TIMES)
