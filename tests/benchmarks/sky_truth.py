"""Where did the antenna look, against a sky that is computed without this project? Ten minutes of a pass and of a
geostationary satellite.

    python -m tests.benchmarks.sky_truth [--target pass|geostationary] [--duration 600] [--run FOLDER]

runs `gimbal-hil point` in lockstep (or reads a run that it left), and takes from the log nothing but tick numbers and
encoders. The sky is here: SGP4 by the package `sgp4`, from TEME to the Earth by the mean sidereal time (Vallado 2013,
equation 3-47) of UT1, the place on the ellipsoid by its radii of curvature, and two rotations to north, west and up.
Only the difference of UT1 and UTC is skyfield's, which nobody can compute. The geostationary satellite is the set of
mean elements that SGP4, with its deep-space terms, keeps nearest to one place above 13 degrees east during the run.

The base stands level with its x to the north, so the joints are the direction: the error is that of the encoders' own
steps (1.5 urad), the loops and everything between.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import math
import tempfile
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from sgp4.api import WGS72, Satrec, jday
from skyfield.api import load

from gimbal_hil.data.runs import columns_of, open_run
from gimbal_hil.surface.cli.app import run
from sim_backend.shipped import shipped_file

Table = NDArray[np.float64]
LATITUDE_DEG, LONGITUDE_DEG, HEIGHT_M, STANDS_DEG = 48.35, 11.79, 10700.0, 13.0
START = datetime(2026, 11, 22, 12, 6, 30, tzinfo=UTC)
#: radius of the geostationary orbit (m): Kepler's third law for a sidereal day of 86164.0905 s
GEOSTATIONARY_M = (3.986004418e14 * (86164.0905 / (2.0 * math.pi)) ** 2) ** (1.0 / 3.0)
#: settled is from so long after the first tick on (s)
_SETTLED_S = 10.0
#: directions are computed so often and joined by cubics; a low satellite turns by 0.03 rad/s at most (s)
_EACH_S = 0.25


def sidereal_rad(day: float, fraction: float, ut1_utc_s: float) -> float:
    """Mean sidereal time at Greenwich, rad."""
    centuries = (day - 2451545.0 + fraction + ut1_utc_s / 86400.0) / 36525.0
    seconds = 67310.54841 + (876600.0 * 3600.0 + 8640184.812866) * centuries
    seconds += 0.093104 * centuries**2 - 6.2e-6 * centuries**3
    return math.radians(seconds % 86400.0 / 240.0)


def at(when: datetime) -> tuple[float, float, float]:
    """Julian day, fraction and UT1 - UTC (s) of a time."""
    time = load.timescale(builtin=True).from_datetime(when)
    seconds = when.second + 1e-6 * when.microsecond
    return *jday(when.year, when.month, when.day, when.hour, when.minute, seconds), float(time.dut1)


def low_satellite() -> Satrec:
    """That of the shipped elements."""
    lines = shipped_file("scenarios", "example.tle").read_text().splitlines()
    first, second = (next(line for line in lines if line.startswith(f"{n} ")) for n in (1, 2))
    return Satrec.twoline2rv(first, second)


def standing_satellite(start: datetime, duration_s: float) -> Satrec:
    """One that stands above STANDS_DEG meanwhile: mean elements are fitted until SGP4 says so, with what the Moon and
    the Sun do to it.
    """
    from scipy.optimize import least_squares

    day, fraction, ut1 = at(start)
    times = fraction + np.linspace(0.0, duration_s, 5) / 86400.0
    place = GEOSTATIONARY_M * np.array([math.cos(math.radians(STANDS_DEG)), math.sin(math.radians(STANDS_DEG)), 0.0])

    def satellite(x: Table) -> Satrec:
        one, turned = Satrec(), math.atan2(x[1], x[0])
        closest = math.atan2(x[3], x[2])
        mean = sidereal_rad(day, fraction, ut1) + math.radians(STANDS_DEG) + x[4] - closest
        turns = 2.0 * math.pi * 1.00273790935 / 1440.0 * (1.0 + x[5])
        epoch, round_ = day + fraction - 2433281.5, math.hypot(x[2], x[3])
        shape = round_, (closest - turned) % (2.0 * math.pi), math.hypot(x[0], x[1]), mean % (2.0 * math.pi)
        one.sgp4init(WGS72, "i", 1, epoch, 0.0, 0.0, 0.0, *shape, turns, turned % (2.0 * math.pi))
        return one

    def off_km(x: Table) -> Table:
        one = satellite(x)
        return 1e-3 * np.concatenate([fixed(one, day, t, ut1) - place for t in times])

    begin = np.array([1e-4, 1e-5, 1e-5, 1e-5, 0.0, 0.0])
    found = least_squares(off_km, begin, x_scale=1e-4, diff_step=1e-2, xtol=1e-15, ftol=1e-15, gtol=1e-15)
    print(f"standing satellite: SGP4 has it within {1e3 * np.abs(found.fun).max():.0f} m of its place")
    return satellite(found.x)


def fixed(satellite: Satrec, day: float, fraction: float, ut1_utc_s: float) -> Table:
    """Earth-fixed position (3,), m."""
    wrong, teme, _ = satellite.sgp4(day, fraction)
    if wrong:
        raise ArithmeticError(f"SGP4 says {wrong}")
    angle = sidereal_rad(day, fraction, ut1_utc_s)
    c, s = math.cos(angle), math.sin(angle)
    x, y, z = (1e3 * value for value in teme)
    return np.array([c * x + s * y, c * y - s * x, z])


def seen(satellite: Satrec, start: datetime, time_s: Table) -> Table:
    """Unit vectors (n, 3) to north, west and up from the antenna to the satellite."""
    lat, lon = math.radians(LATITUDE_DEG), math.radians(LONGITUDE_DEG)
    a, flattening = 6378137.0, 1.0 / 298.257223563
    squared = flattening * (2.0 - flattening)
    prime = a / math.sqrt(1.0 - squared * math.sin(lat) ** 2)
    turned = np.array(
        [
            [-math.sin(lat) * math.cos(lon), -math.sin(lat) * math.sin(lon), math.cos(lat)],
            [math.sin(lon), -math.cos(lon), 0.0],
            [math.cos(lat) * math.cos(lon), math.cos(lat) * math.sin(lon), math.sin(lat)],
        ]
    )
    place = (prime + HEIGHT_M) * turned[2] - [0.0, 0.0, squared * prime * math.sin(lat)]
    day, fraction, ut1 = at(start)
    away = np.array([fixed(satellite, day, fraction + t / 86400.0, ut1) for t in time_s]) - place
    return (away / np.linalg.norm(away, axis=1)[:, None]) @ turned.T


def looked(folder: Path) -> tuple[Table, Table]:
    """Seconds since the first tick of the way (n,), and where the antenna looked (n, 3): north, west, up."""
    log = open_run(folder)
    first = next(event.tick for event in log.events if event.data.get("step") == "minute 1")
    columns = [columns_of(log.frames, f"feedback_{axis}", log.protocol) for axis in ("outer", "inner")]
    ticks = [log.frames["tick"][one.place].astype(np.int64) for one in columns]
    both, *places = np.intersect1d(*ticks, return_indices=True)
    outer, inner = (one.physical("position")[place] for one, place in zip(columns, places, strict=True))
    step_s = log.record.header.period_ns * 1e-9
    beam = np.column_stack([np.cos(inner) * np.cos(outer), np.cos(inner) * np.sin(outer), -np.sin(inner)])
    return (both - first) * step_s, beam


def said(target: str, folder: Path, duration_s: float) -> str:
    """The figures of a run."""
    from scipy.interpolate import CubicSpline

    satellite = low_satellite() if target == "pass" else standing_satellite(START, duration_s)
    grid = np.arange(-1.0, duration_s + 2.0, _EACH_S)
    sky = CubicSpline(grid, seen(satellite, START, grid))
    time_s, beam = looked(folder)
    held = (time_s >= _SETTLED_S) & (time_s < duration_s - 0.01)
    wanted = sky(time_s[held])
    wanted /= np.linalg.norm(wanted, axis=1)[:, None]
    off = 1e6 * np.arcsin(np.minimum(1.0, np.linalg.norm(np.cross(beam[held], wanted), axis=1)))
    elevation = np.degrees(np.arcsin(wanted[:, 2]))
    minutes = [float(np.sqrt(np.mean(off[(time_s[held] // 60.0) == k] ** 2))) for k in range(int(duration_s // 60))]
    return (
        f"{target}: {held.sum()} ticks, elevation {elevation.min():.1f} to {elevation.max():.1f} degrees; encoders off "
        f"the independent sky by {np.sqrt(np.mean(off**2)):.2f} urad rms, {off.max():.2f} urad at most; rms of each "
        f"minute: {', '.join(f'{one:.2f}' for one in minutes)}"
    )


def main() -> None:
    """See the module."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--target", choices=("pass", "geostationary"), action="append")
    parser.add_argument("--duration", type=float, default=600.0)
    parser.add_argument("--run", type=Path, help="a run that `point` left, in place of a new one")
    asked = parser.parse_args()
    for target in asked.target or ("pass", "geostationary"):
        name = f"tle:{shipped_file('scenarios', 'example.tle')}" if target == "pass" else f"geo:{STANDS_DEG}E"
        with tempfile.TemporaryDirectory() as place:
            folder = asked.run or Path(place) / "run"
            if asked.run is None:
                words = ["--target", name, "--position", f"{LATITUDE_DEG},{LONGITUDE_DEG},{HEIGHT_M:g}"]
                words += ["--at", f"{START:%Y-%m-%dT%H:%M:%SZ}", "--duration", f"{asked.duration:g}"]
                with contextlib.redirect_stdout(io.StringIO()):
                    code = run("point", [*words, "--out", str(folder), "--json"])
                if code:
                    raise SystemExit(f"point ended with {code}")
            print(said(target, folder, asked.duration), flush=True)


if __name__ == "__main__":
    main()
