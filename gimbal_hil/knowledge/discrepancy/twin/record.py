"""A log as the twin takes it: interval means of motion and base, commanded torque, which scored rows count, and
laps.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gimbal_hil.data.signals import SignalsTable, body_rates
from gimbal_hil.knowledge.discrepancy.twin.smoothing import (
    Bands,
    Floats,
    interval_mean,
    interval_mean_of_rate,
    interval_means,
    interval_slope,
    scored_length,
    scoring_reach,
    taken_off,
    taps_for,
)
from sim_backend.model import AntennaModel

#: channels in the order of every residual: torque per axis, then gyro minus encoder rate per axis
TORQUE, RATE_ERROR = "torque", "rate_error"
#: travel, in bristle deflections at break-away, after which the bristle has forgotten how the log began
_FORGOTTEN = 8.0
_AMBIENT_DEGC = 20.0
#: a joint stands when within this time it moves by less than this share of the bristle's deflection at break-away
_STANDING_S, _STANDING_SHARE = 0.4, 0.3
#: time constant with which a standing bristle is led to what holds the joint
_LED_S = 0.06


def searched_name(which: int) -> str:
    """Name of one of the logs that are fitted."""
    return f"measured {which}"


def judging_name(which: int) -> str:
    """Name of one of the logs that judge."""
    return f"hold-out {which}"


@dataclass(frozen=True)
class Channel:
    """One residual: which axis, and which signal (torque, or rate_error = gyro minus encoder rate)."""

    axis: str
    signal: str
    #: column of the twin's output
    column: int

    def unit(self, linear: bool) -> str:
        """Unit of the residual, on a linear axis or a rotary one."""
        if self.signal == RATE_ERROR:
            return "m/s" if linear else "rad/s"
        return "N" if linear else "N m"


@dataclass(frozen=True)
class Record:
    """One log of n intervals, ready for the twin."""

    name: str
    bands: Bands
    axes: tuple[str, ...]
    #: commanded torque per axis, (n, 2), N m
    torque: Floats
    #: interval means q, q, v, v, a, a, then the share by which a standing bristle is led per axis (see `_led`), (n, 8)
    motion: Floats
    #: gravity less the pivot's acceleration, rate and angular acceleration of the base in base axes, (n, 9)
    base: Floats
    #: joint temperature per axis, (n, 2), degC
    heat: Floats
    #: interval mean of the gyro rate per axis less `quieted`, as the motion's rate is, (n, 2); zero where there is none
    gyro: Floats
    #: what quieting took off the motion's rate, (n, 2), see `smoothing.taken_off`; zero where there is no gyro
    quieted: Floats
    has_gyro: tuple[bool, ...]
    #: scored rows that count, (m,)
    keep: NDArray[np.bool_]
    #: lap number per interval, or None
    laps: NDArray[np.int64] | None
    moving_base: bool
    has_temperature: bool
    #: seconds of every scored row, (m,)
    time_s: Floats
    source: str = ""

    @property
    def seconds(self) -> float:
        """How long it lasts."""
        return len(self.torque) * self.bands.period_s

    @property
    def rows(self) -> NDArray[np.int64]:
        """Interval index of every scored row that counts."""
        return np.flatnonzero(self.keep) * self.bands.stride

    def at_scored(self, values: Floats) -> Floats:
        """A per-interval quantity at the scored rows that count."""
        return np.asarray(values[np.minimum(self.rows, len(values) - 1)])


def record_of(
    table: SignalsTable, model: AntennaModel, scored_hz: float, name: str, keep: NDArray[np.bool_] | None = None
) -> Record:
    """Prepare a signals table for a model's axes; `scored_hz` ends the scored band, `keep` are the rows if they are
    known.
    """
    bands = Bands(scored_hz, table.period_s)
    axes = model.axes
    n = len(table) - 1
    position = np.zeros((len(table), 2))
    torque, heat, gyro = np.zeros((n, 2)), np.full((n, 2), _AMBIENT_DEGC), np.zeros((n, 2))
    has_gyro = []
    warm = False
    for i, axis in enumerate(axes):
        position[:, i] = table.position(axis)
        torque[:, i] = table.torque(axis)[:n]
        temperature = table.signal(axis, "temperature")
        if temperature is not None and np.isfinite(temperature).all():
            heat[:, i] = temperature[:n]
            warm = warm or float(np.ptp(temperature)) > 1.0
        rate = table.signal(axis, "rate")
        has_gyro.append(rate is not None and bool(np.any(rate != 0.0)))
        if rate is not None and has_gyro[-1]:
            gyro[:, i] = interval_mean_of_rate(rate, bands)
    motion = _motion_of(position, model, bands)
    quieted = _quieted(position, motion, has_gyro, bands)
    base, moving = _base(table, model, bands, n)
    stride = bands.stride
    rows = stride * np.arange(scored_length(n, bands))
    keep = _kept(rows, np.abs(motion[:, 2:4]), torque, model, bands, n) if keep is None else keep
    laps = table.repeat[:n] if table.repeat is not None and len(np.unique(table.repeat)) > 1 else None
    return Record(
        name, bands, axes, torque, motion, base, heat, gyro - quieted, quieted, tuple(has_gyro),
        keep, laps,
        moving, warm, table.time_s[rows] - table.time_s[0], table.source,
    )  # fmt: skip


def reread(record: Record, table: SignalsTable, model: AntennaModel, name: str) -> Record:
    """A record as it would be if the encoders had read the positions of `table` instead, the same rows counting."""
    position = np.zeros((len(table), 2))
    for i, axis in enumerate(record.axes):
        position[:, i] = table.position(axis)
    motion = _motion_of(position, model, record.bands)
    quieted = _quieted(position, motion, record.has_gyro, record.bands)
    return replace(record, name=name, motion=motion, gyro=record.gyro + record.quieted - quieted, quieted=quieted)


def _quieted(position: Floats, motion: Floats, has_gyro: Sequence[bool], bands: Bands) -> Floats:
    out = np.zeros((len(motion), 2))
    out[:, : len(has_gyro)] = taken_off(position, motion[:, 2:4], bands)[:, : len(has_gyro)] * has_gyro
    return out


def _motion_of(position: Floats, model: AntennaModel, bands: Bands) -> Floats:
    """Columns of `Record.motion` from positions (n + 1, 2)."""
    q, v, a = interval_means(position, bands)
    return np.column_stack([q, v, a, _led(q, model, bands)])


def _base(table: SignalsTable, model: AntennaModel, bands: Bands, n: int) -> tuple[Floats, bool]:
    """Gravity less the pivot's acceleration, rate and angular acceleration in base axes, (n, 9); absent columns mean
    level and fixed.
    """
    g = model.file.gravity_m_s2
    angles = [table.base(name) for name in ("roll", "pitch", "yaw")]
    rates = [table.base(name) for name in ("p", "q", "r")]
    count = len(table)
    attitude = np.column_stack([x if x is not None else np.zeros(count) for x in angles])
    if any(x is not None for x in rates):
        body = np.column_stack([x if x is not None else np.zeros(count) for x in rates])
    else:
        body = body_rates(table)
    out = np.zeros((n, 9))
    roll, pitch = interval_mean(attitude[:, 0], bands), interval_mean(attitude[:, 1], bands)
    out[:, 0], out[:, 1], out[:, 2] = (
        g * np.sin(pitch),
        -g * np.cos(pitch) * np.sin(roll),
        -g * np.cos(pitch) * np.cos(roll),
    )
    pushed = [table.base(name) for name in ("ax", "ay", "az")]
    for i, acceleration in enumerate(pushed):
        if acceleration is not None:
            out[:, i] -= interval_mean(acceleration, bands)
    moving = bool(np.ptp(body, axis=0).max() > 1e-4 or np.abs(body).max() > 1e-4)
    if moving:
        out[:, 3:6] = interval_mean(body, bands)
        out[:, 6:9] = interval_slope(body, bands)
    return out, moving


def _led(position: Floats, model: AntennaModel, bands: Bands) -> Floats:
    """Share of the left-over torque by which a bristle is led each interval, (n, 2): nothing in motion, quickly where a
    joint stands.

    At standstill friction is whatever holds the joint, up to break-away, so torque says nothing there; but a bristle
    carried along a rate that is mostly encoder noise creeps (its equation takes the modulus), and would be wrong when
    the joint moves on. Presliding moves the joint by more.
    """
    from scipy.ndimage import maximum_filter1d, minimum_filter1d

    out = np.zeros_like(position)
    window = 2 * max(1, round(0.5 * _STANDING_S / bands.period_s)) + 1
    for i, axis in enumerate(model.axes):
        sigma0 = model.number(axis, "friction.sigma0")
        if sigma0 > 0.0:
            reach = maximum_filter1d(position[:, i], window) - minimum_filter1d(position[:, i], window)
            standing = reach < _STANDING_SHARE * model.number(axis, "friction.breakaway") / sigma0
            out[standing, i] = min(1.0, bands.period_s / _LED_S)
    return out


def edge_rows(bands: Bands) -> float:
    """Rows at either end of a log that hold what filters make of its end."""
    return 1.2 * (scoring_reach(bands) // 2 + taps_for(bands.smoothing, bands.period_s) // 2)


def _kept(
    rows: NDArray[np.int64], speed: Floats, torque: Floats, model: AntennaModel, bands: Bands, n: int
) -> NDArray[np.bool_]:
    """Rows away from the ends, and after the bristles have forgotten the unknown state in which the log began."""
    start = edge = edge_rows(bands)
    for i, axis in enumerate(model.axes):
        sigma0 = model.number(axis, "friction.sigma0")
        if sigma0 > 0.0:
            travelled = np.cumsum(speed[:, i]) * bands.period_s
            beyond = np.flatnonzero(travelled > _FORGOTTEN * model.number(axis, "friction.breakaway") / sigma0)
            if len(beyond) and beyond[0] < 0.25 * n:
                start = max(start, beyond[0] + 0.5 * edge)
    return np.asarray((rows >= start) & (rows < n - edge))
