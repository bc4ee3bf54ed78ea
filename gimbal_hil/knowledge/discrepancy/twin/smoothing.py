"""Linear-phase filters that turn sampled positions into interval means of position, rate and acceleration.

Row k of a record stands for the interval [t_k, t_k+1): commanded torque is constant there, so everything else is the
*mean* over it, and no half-sample misalignment can pass for a delay (docs/reference/discrepancy.md). Encoder positions
become mean position, the difference quotient (which is the mean rate exactly) and its difference (the mean
acceleration), all behind the same low-pass; a second low-pass with a narrower band comes after the model and decides
what is scored.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


#: smoothing is flat to this many times the scored band
_WIDE = 5.0
#: and up to here at least, Hz, where the log has it: friction reverses as sharply however little of it is scored
_SHARP_HZ = 62.5
#: local power beyond the scored band must stand this far above the quietest tenth to count as motion
_FACTOR = 4.0
#: a joint rests where its rate is this share of that of the whole log
_RESTS = 0.02


@dataclass(frozen=True)
class Bands:
    """Filter edges as a function of the scored band: smoothing ends far beyond it, scoring at 0.6 to 1.4 of it."""

    scored_hz: float
    period_s: float

    @property
    def stride(self) -> int:
        """Rows per scored row: a little over twice the end of the scoring filter's edge."""
        return max(1, int(0.31 / (self.scored_hz * self.period_s)))

    @property
    def smoothing(self) -> tuple[float, float]:
        """Pass and stop edge of the smoothing filter, Hz, kept below the Nyquist frequency."""
        nyquist, wide_hz = 0.5 / self.period_s, max(_WIDE * self.scored_hz, _SHARP_HZ)
        return min(wide_hz, 0.55 * nyquist), min(1.75 * wide_hz, 0.98 * nyquist)

    @property
    def scoring(self) -> tuple[float, float]:
        """Pass and stop edge of the scoring filter, Hz."""
        return 0.6 * self.scored_hz, 1.4 * self.scored_hz


@lru_cache(maxsize=32)
def _low_pass(
    pass_hz: float, stop_hz: float, period_s: float, taps: int, shape: Callable[[Floats], Floats] | None = None
) -> Floats:
    """Zero-phase FIR kernel, its pass band multiplied by `shape` of pi f T; unit gain at zero. Even `taps` sits between
    samples.
    """
    at = (np.arange(taps) - 0.5 * (taps - 1)) * period_s
    f = np.linspace(0.0, stop_hz, 600)
    edge = np.clip((f - pass_hz) / (stop_hz - pass_hz), 0.0, 1.0)
    rest = _septic_edge(edge)
    gain = rest if shape is None else rest * shape(np.pi * f * period_s)
    kernel = np.trapezoid(gain * np.cos(2.0 * np.pi * at[:, None] * f), f, axis=1)
    return kernel / kernel.sum()


def _septic_edge(edge: Floats) -> Floats:
    """From one to zero without a kink, so that a kernel is short without a window, which would bend the pass band."""
    return np.asarray(1.0 - edge**4 * (35.0 - 84.0 * edge + 70.0 * edge**2 - 20.0 * edge**3))


def _mean_of_smooth(x: Floats) -> Floats:
    """Mean over an interval of what is smooth through it: sin x / x."""
    return np.asarray(np.sinc(x / np.pi))


def _between_bends(x: Floats) -> Floats:
    """Acceleration that is constant between samples, from second differences, which average neighbours: 1 / cos x."""
    return np.asarray(1.0 / np.cos(x))


def taps_for(edges: tuple[float, float], period_s: float) -> int:
    """Odd number of taps that the transition band needs."""
    return 2 * int(5.0 / ((edges[1] - edges[0]) * period_s)) + 1


def _filtered(x: Floats, kernel: Floats) -> Floats:
    """Convolution without delay, columns apart; ends are continued by odd reflection, over and over where the kernel is
    longer than that. Length n, or n - 1 for an even kernel.
    """
    from scipy.signal import oaconvolve

    ends = [(len(kernel) // 2,) * 2] + [(0, 0)] * (x.ndim - 1)
    long = np.pad(x, ends, mode="reflect", reflect_type="odd")
    y = oaconvolve(long, kernel.reshape(-1, *([1] * (x.ndim - 1))), mode="valid", axes=0)
    return np.ascontiguousarray(y[: len(x)] if len(kernel) % 2 else y[1 : len(x)])


def interval_means(position: Floats, bands: Bands) -> tuple[Floats, Floats, Floats]:
    """Mean position, rate and acceleration over each interval [t_k, t_k+1), k = 0 .. n-2, from positions (n, ...)."""
    edges, dt = bands.smoothing, bands.period_s
    taps = taps_for(edges, dt)
    q = _filtered(position, _low_pass(*edges, dt, taps + 1, _mean_of_smooth))
    steps = np.diff(position, axis=0) / dt
    v = _quiet_where_still(steps, _filtered(steps, _low_pass(*edges, dt, taps)), bands)
    bends = np.diff(position, n=2, axis=0) / dt**2
    a = _filtered(np.concatenate([bends[:1], bends, bends[-1:]]), _low_pass(*edges, dt, taps + 1, _between_bends))
    return q, v, a


def _quiet_where_still(steps: Floats, wide: Floats, bands: Bands) -> Floats:
    """Rate that follows break-away and reversals in full band, and only the scored band where nothing but noise is
    beyond it.

    Friction takes the modulus of the rate: encoder noise at standstill would let a bristle creep that holds in truth.
    The part beyond the scored band is weighed by how far its local power stands above noise (a local Wiener gain).
    Noise is no more than its quietest tenth, and no more than what is there at rest or than white noise of the position
    by what the smoothing removes, the larger: motion that goes on beyond a narrow band all the time is no noise.
    """
    from scipy.ndimage import gaussian_filter1d

    edges, dt = (1.3 * bands.scored_hz, 2.6 * bands.scored_hz), bands.period_s
    if edges[1] >= bands.smoothing[0]:
        return wide
    inner, outer = (_low_pass(*e, dt, taps_for(e, dt)) for e in (edges, bands.smoothing))
    narrow = _filtered(steps, inner)
    beyond = wide - narrow
    power, removed = (
        gaussian_filter1d(part**2, 0.25 / (bands.scored_hz * dt), axis=0) for part in (beyond, steps - wide)
    )
    # white noise of the position, by what the smoothing removes; of a position that a drive smoothed only rest tells
    noise = np.maximum(removed * _carried(inner, outer), _at_rest(narrow, power, bands))
    quiet = np.minimum(np.quantile(power[:: bands.stride], 0.1, axis=0), noise)
    return np.asarray(narrow + beyond * np.clip(1.0 - _FACTOR * quiet / np.maximum(power, 1e-300), 0.0, 1.0))


def _at_rest(rate: Floats, power: Floats, bands: Bands) -> Floats:
    """The quietest tenth of a power, (rows, columns), where a joint stands for some time; zero for one that never does.
    Reversals are no rest.
    """
    from scipy.ndimage import gaussian_filter1d

    local = gaussian_filter1d(rate**2, 1.0 / (bands.scored_hz * bands.period_s), axis=0)
    rests = local < _RESTS**2 * np.mean(rate**2, axis=0)
    columns = zip(power[:: bands.stride].T, rests[:: bands.stride].T, strict=True)
    return np.array([np.quantile(column[still], 0.1) if np.any(still) else 0.0 for column, still in columns])


def _carried(inner: Floats, outer: Floats) -> float:
    """Power that white position noise has between two low-passes of its differences, over that beyond the wider one."""
    between, beyond = -np.pad(inner, max(0, len(outer) - len(inner)) // 2), -outer
    between += np.pad(outer, (len(between) - len(outer)) // 2)
    beyond[len(beyond) // 2] += 1.0
    first, second = (np.sum(np.diff(part, prepend=0.0, append=0.0) ** 2) for part in (between, beyond))
    return float(first / second)


def taken_off(position: Floats, rate: Floats, bands: Bands) -> Floats:
    """What quieting took off the mean rate over each interval, from positions (n, ...) and that rate (n - 1, ...).

    The quieting is for friction, and what it takes off is modulated by the motion: it reaches into the scored band.
    What is compared with the rate of another sensor is compared without it.
    """
    edges, dt = bands.smoothing, bands.period_s
    return _filtered(np.diff(position, axis=0) / dt, _low_pass(*edges, dt, taps_for(edges, dt))) - rate


def interval_mean(samples: Floats, bands: Bands) -> Floats:
    """Mean over each interval of a smooth quantity sampled at t_k (n, ...); length n - 1."""
    edges = bands.smoothing
    return _filtered(samples, _low_pass(*edges, bands.period_s, taps_for(edges, bands.period_s) + 1, _mean_of_smooth))


def interval_mean_of_rate(samples: Floats, bands: Bands) -> Floats:
    """Mean over each interval of a joint's rate sampled at t_k (n, ...); length n - 1. Held torque bends it only at the
    samples.
    """
    edges = bands.smoothing
    return _filtered(
        0.5 * (samples[1:] + samples[:-1]), _low_pass(*edges, bands.period_s, taps_for(edges, bands.period_s))
    )


def interval_slope(samples: Floats, bands: Bands) -> Floats:
    """Mean derivative over each interval of a quantity sampled at t_k (n, ...); length n - 1."""
    edges = bands.smoothing
    return _filtered(
        np.diff(samples, axis=0) / bands.period_s, _low_pass(*edges, bands.period_s, taps_for(edges, bands.period_s))
    )


def scoring_gain(f: Floats, bands: Bands) -> Floats:
    """Gain of the low-pass that decides what is scored, at frequencies f (Hz)."""
    start, end = bands.scoring
    return _septic_edge(np.clip((f - start) / (end - start), 0.0, 1.0))


def scored(rows: Floats, bands: Bands) -> Floats:
    """Low-passed and thinned rows (n, c) -> (m, c); row j stands at j * stride. The ends hold edge effects and belong
    cut off.
    """
    from scipy.fft import irfft, next_fast_len, rfft

    n, stride = len(rows), bands.stride
    guard = scoring_reach(bands)
    m = next_fast_len((n + guard + stride - 1) // stride, real=True)
    bridge = np.linspace(0.0, 1.0, m * stride - n + 2)[1:-1, None]
    closed = np.concatenate([rows, rows[-1:] + bridge * (rows[:1] - rows[-1:])])
    spectrum = rfft(closed, axis=0)[: m // 2 + 1]
    thin = irfft(spectrum * _gains_of(m, bands)[:, None], m, axis=0) / stride
    return np.ascontiguousarray(thin[: scored_length(n, bands)])


@lru_cache(maxsize=16)
def _gains_of(rows: int, bands: Bands) -> Floats:
    """Gain of the scoring low-pass at the frequencies of so many scored rows, (rows // 2 + 1,)."""
    return scoring_gain(np.arange(rows // 2 + 1) / (rows * bands.stride * bands.period_s), bands)


def scoring_reach(bands: Bands) -> int:
    """Rows on either side that a scored row depends on."""
    return int(2.0 / ((bands.scoring[1] - bands.scoring[0]) * bands.period_s)) * 2


def scored_length(n: int, bands: Bands) -> int:
    """Number of scored rows of n intervals."""
    return (n + bands.stride - 1) // bands.stride
