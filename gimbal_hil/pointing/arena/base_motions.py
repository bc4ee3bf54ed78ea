"""Motions of an aircraft for the arena: turbulence and manoeuvres, as rows of attitude and acceleration of the pivot.

Turbulence: velocities and roll rate of gusts have the Dryden spectra of MIL-F-8785C (1980), section 3.7, with its
scale length of 533 m (1750 ft) above 610 m; realised as sums of cosines with random phases (Shinozuka and Deodatis
1991), so that attitude, rates and accelerations belong to each other exactly. The aircraft answers as linear modes with
stated numbers: plunge, short period, Dutch roll, roll with a wing leveller.
"""

from __future__ import annotations

import csv
import math
from abc import abstractmethod
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from firmware_protocol.documents import Strict
from gimbal_hil.loop.control import GRAVITY_M_S2

#: rows a second of the motion that is handed to the virtual antenna, and where the spectrum is cut
ROW_HZ, CUT_HZ = 500.0, 10.0
_SCALE_LENGTH_M = 533.4
Positive = Annotated[float, Field(gt=0.0)]
Table = NDArray[np.float64]


class AircraftMotion(Strict):
    """Base of the motions."""

    @abstractmethod
    def rows(self, duration_s: float, seed: int) -> tuple[Table, Table]:
        """Roll, pitch, yaw (n, 3), rad, and acceleration of the pivot in base axes (n, 3), m/s^2, at ROW_HZ."""

    def write(self, path: Path, duration_s: float, seed: int) -> None:
        """The motion as a file that the `base:` section of a model takes."""
        write_motion(path, *self.rows(duration_s, seed))


def write_motion(path: Path, attitude: Table, pivot: Table) -> None:
    """Attitude and acceleration of the pivot (n, 3) at ROW_HZ as a file."""
    with path.open("w", newline="") as handle:
        writer = csv.writer(handle)
        writer.writerow(("time_s", "roll", "pitch", "yaw", "ax", "ay", "az"))
        for number, row in enumerate(np.column_stack([attitude, pivot]).tolist()):
            writer.writerow((number / ROW_HZ, *row))


class Turbulence(AircraftMotion):
    """Flight through turbulence; the default numbers are those of a transport of 34 m span at 230 m/s."""

    motion: Literal["turbulence"]
    sigma_m_s: Positive = Field(description="rms of each gust velocity: 3.05 (10 ft/s) is moderate, 6.1 severe")
    airspeed_m_s: Positive = 230.0
    wing_span_m: Positive = 34.0
    #: share of a vertical (lateral) gust that becomes acceleration, 1/s
    heave_per_s: Positive = 0.42
    sway_per_s: Positive = 0.1
    #: natural frequency (rad/s) and damping of short period and Dutch roll
    short_period: tuple[Positive, Positive] = (1.5, 0.5)
    dutch_roll: tuple[Positive, Positive] = (1.2, 0.1)
    #: time constant of the roll mode (s), natural frequency of the wing leveller (rad/s)
    roll_mode_s: Positive = 0.6
    leveller_rad_s: Positive = 0.7

    def rows(self, duration_s: float, seed: int) -> tuple[Table, Table]:
        n = 1 << math.ceil(math.log2(duration_s * ROW_HZ + 2))
        step = 2.0 * math.pi * ROW_HZ / n
        w = step * np.arange(1, n // 2, dtype=np.float64)
        s = 1j * w
        draw = np.random.default_rng(seed)

        def gust(spectrum: Table) -> NDArray[np.complex128]:
            """Complex amplitudes of a gust with this one-sided spectrum over w."""
            size = np.sqrt(2.0 * spectrum * step) * (w < 2.0 * math.pi * CUT_HZ)
            return np.asarray(size * np.exp(2j * math.pi * draw.random(len(w))), np.complex128)

        def series(amplitudes: NDArray[np.complex128]) -> Table:
            whole = np.zeros(n // 2 + 1, dtype=np.complex128)
            whole[1 : n // 2] = 0.5 * n * amplitudes
            return np.asarray(np.fft.irfft(whole, n)[: math.ceil(duration_s * ROW_HZ) + 1])

        vertical, lateral = gust(self.velocity_spectrum(w)), gust(self.velocity_spectrum(w))
        roll_gust = gust(self.roll_spectrum(w))
        # what is left of a gust once the aircraft moves with it
        vertical_left, lateral_left = (
            vertical * s / (s + self.heave_per_s),
            lateral * s / (s + self.sway_per_s),
        )

        def mode(frequency: float, damping: float) -> NDArray[np.complex128]:
            return np.asarray(frequency**2 / (s**2 + 2.0 * damping * frequency * s + frequency**2), np.complex128)

        # x forward, y left, z up: a gust from below turns the nose down, one from the right turns it right
        pitch = series(mode(*self.short_period) * vertical_left / self.airspeed_m_s)
        yaw = -series(mode(*self.dutch_roll) * lateral_left / self.airspeed_m_s)
        roll = series(roll_gust / self.roll_mode_s / (s**2 + s / self.roll_mode_s + self.leveller_rad_s**2))
        pivot = np.zeros((len(roll), 3))
        pivot[:, 1], pivot[:, 2] = series(self.sway_per_s * lateral_left), series(self.heave_per_s * vertical_left)
        return np.column_stack([roll, pitch, yaw]), pivot

    def velocity_spectrum(self, w: Table) -> Table:
        """One-sided spectrum (m^2/s^2 per rad/s) of a gust across the flight path."""
        length_s = _SCALE_LENGTH_M / self.airspeed_m_s
        x = (length_s * w) ** 2
        return self.sigma_m_s**2 * length_s / math.pi * (1.0 + 3.0 * x) / (1.0 + x) ** 2

    def roll_spectrum(self, w: Table) -> Table:
        """One-sided spectrum (rad^2/s^2 per rad/s) of the gust's roll rate."""
        span, speed = self.wing_span_m, self.airspeed_m_s
        size = 0.8 * (math.pi * _SCALE_LENGTH_M / (4.0 * span)) ** (1.0 / 3.0)
        return self.sigma_m_s**2 / (speed * _SCALE_LENGTH_M) * size / (1.0 + (4.0 * span * w / (math.pi * speed)) ** 2)


class Manoeuvre(AircraftMotion):
    """A co-ordinated turn, entered and left, with a pull-up on the way; every change of least jerk."""

    motion: Literal["manoeuvre"]
    bank_rad: float = 0.5236
    airspeed_m_s: Positive = 230.0
    entry_s: Positive = 2.0
    change_s: Positive = 3.0
    hold_s: Positive = 6.0
    #: vertical acceleration at the top of the pull-up, over one hold
    pull_up_m_s2: float = 4.9

    def rows(self, duration_s: float, seed: int) -> tuple[Table, Table]:
        t = np.arange(math.ceil(duration_s * ROW_HZ) + 1) / ROW_HZ
        leave = self.entry_s + self.change_s + self.hold_s
        roll = self.bank_rad * (_eased((t - self.entry_s) / self.change_s) - _eased((t - leave) / self.change_s))
        half = 0.5 * self.hold_s
        up = self.pull_up_m_s2 * (
            _eased((t - self.entry_s - self.change_s) / half) - _eased((t - self.entry_s - self.change_s - half) / half)
        )
        # the lift that turns also carries: sideways it is tan(roll) of what carries upwards, towards the low wing
        sideways = -np.tan(roll) * (GRAVITY_M_S2 + up)
        yaw = np.cumsum(sideways / self.airspeed_m_s) / ROW_HZ
        pitch = -np.cumsum(up / self.airspeed_m_s) / ROW_HZ
        c, s = np.cos(roll), np.sin(roll)
        # level axes that turn with the heading, then the body's
        pivot = np.column_stack([np.zeros(len(t)), c * sideways + s * up, -s * sideways + c * up])
        return np.column_stack([roll, pitch, yaw]), pivot


class Swing(AircraftMotion):
    """Every angle a sine of its own: the three rates have the same amplitude."""

    motion: Literal["swing"]
    rate_rad_s: Positive
    frequency_hz: Positive

    def rows(self, duration_s: float, seed: int) -> tuple[Table, Table]:
        t = np.arange(math.ceil(duration_s * ROW_HZ) + 1) / ROW_HZ
        w = 2.0 * math.pi * self.frequency_hz
        angles = [self.rate_rad_s / w * np.sin(w * t + phase) for phase in (0.0, 2.0, 4.0)]
        return np.column_stack(angles), np.zeros((len(t), 3))


def _eased(x: Table) -> Table:
    """From 0 to 1 with least jerk while x goes from 0 to 1."""
    x = np.clip(x, 0.0, 1.0)
    return np.asarray(x**3 * (10.0 - x * (15.0 - 6.0 * x)))
