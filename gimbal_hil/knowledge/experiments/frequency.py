"""Frequency response of a loop from laps of one excitation: cross-spectra with the reference as instrument.

The reference is known and free of noise, so `S_ry / S_rr` and `S_ry / S_re` are unbiased however noisy the sensors are,
which the ratio of output to input inside a loop is not (Ljung, System Identification, 2nd ed., section 13.5). Spectra
are averaged over laps and over bands of equal width on a logarithmic axis; the coherence says how much of the output
the reference explains.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
Response = NDArray[np.complex128]
#: bands a decade, and the share of a lap that is faded in and out
BANDS_PER_DECADE, FADE = 40, 0.04
#: coherence from which on a band is read
LEAST_COHERENCE = 0.3
#: where the phase of a loop that integrates starts (between -180 and 0 degrees), and that of one that is closed
OPEN_STARTS_DEG, CLOSED_STARTS_DEG = -90.0, 0.0


@dataclass(frozen=True)
class Lap:
    """One lap: reference and measured output, each (n,), at a constant period."""

    period_s: float
    reference: Vector
    output: Vector


@dataclass(frozen=True)
class FrequencyResponse:
    """`closed` and `open` loop (complex, (m,)) and coherence of the closed one (0 to 1, (m,)) at `frequency_hz`
    (m,).
    """

    frequency_hz: Vector
    closed: Response
    open: Response
    coherence: Vector


@dataclass(frozen=True)
class Margins:
    """Where the open loop crosses unit gain and -180 degrees; None where it does not within the frequencies
    measured.
    """

    crossover_hz: float | None
    phase_margin_deg: float | None
    phase_crossover_hz: float | None
    gain_margin_db: float | None
    #: frequency up to which the closed loop follows within 3 dB
    bandwidth_hz: float | None


def frequency_response(laps: Sequence[Lap], low_hz: float, high_hz: float) -> FrequencyResponse:
    """Response between two frequencies; laps have the same period and length, means and slow drifts are taken out of
    each.
    """
    size = min(len(lap.reference) for lap in laps)
    period = laps[0].period_s
    window = _fade(size)
    frequency = np.fft.rfftfreq(size, period)
    rr, ry, yy, re = (np.zeros(len(frequency), dtype=np.complex128) for _ in range(4))
    for lap in laps:
        reference, output = lap.reference[:size], lap.output[:size]
        r = np.fft.rfft(window * (reference - np.mean(reference)))
        y = np.fft.rfft(window * (output - np.mean(output)))
        rr += np.abs(r) ** 2
        yy += np.abs(y) ** 2
        ry += np.conj(r) * y
        re += np.conj(r) * (r - y)
    count = max(4, round(BANDS_PER_DECADE * np.log10(high_hz / low_hz)))
    edges = np.geomspace(low_hz, high_hz, count + 1)
    band = np.digitize(frequency, edges) - 1
    wanted = [number for number in range(count) if np.any(band == number)]
    middle = np.array([float(np.average(frequency[band == n], weights=np.abs(rr[band == n]))) for n in wanted])
    srr, syy, sry, sre = (np.array([np.sum(s[band == n]) for n in wanted]) for s in (rr, yy, ry, re))
    coherence = np.abs(sry) ** 2 / np.maximum((srr * syy).real, 1e-300)
    return FrequencyResponse(middle, sry / srr, sry / sre, np.asarray(np.clip(coherence, 0.0, 1.0)))


def phase_deg(loop: Response, coherence: Vector, start_deg: float) -> Vector:
    """Phase without jumps, degrees, (m,), on the sheet that lies nearest to `start_deg` at the first band one can read.

    Each band is put within 180 degrees of the last one that was coherent: bands of noise follow their neighbours and
    cannot shift those behind them by a turn.
    """
    angle = np.degrees(np.angle(loop))
    good = np.flatnonzero(coherence >= LEAST_COHERENCE)
    first = int(good[0]) if len(good) else 0
    phase = np.empty(len(angle))

    def near(value: float, to: float) -> float:
        return value + 360.0 * round((to - value) / 360.0)

    last = phase[first] = near(float(angle[first]), start_deg)
    for k in range(first + 1, len(angle)):
        phase[k] = near(float(angle[k]), last)
        last = phase[k] if coherence[k] >= LEAST_COHERENCE else last
    for k in range(first - 1, -1, -1):
        phase[k] = near(float(angle[k]), phase[first])
    return phase


def margins_of(response: FrequencyResponse, least_coherence: float = LEAST_COHERENCE) -> Margins:
    """Margins of the open loop, from where the coherence is high enough to read them.

    A band holds hundreds of lines of the spectrum at high frequencies, so a low coherence still gives a good mean
    there.
    """
    good = response.coherence >= least_coherence
    frequency, loop, closed = response.frequency_hz[good], response.open[good], response.closed[good]
    if len(frequency) < 4:
        return Margins(None, None, None, None, None)
    gain_db = 20.0 * np.log10(np.abs(loop))
    phase = phase_deg(loop, response.coherence[good], OPEN_STARTS_DEG)
    crossover = _falls_through(frequency, gain_db, 0.0)
    turn = _falls_through(frequency, phase, -180.0)
    bandwidth = _falls_through(frequency, 20.0 * np.log10(np.abs(closed)), -3.0)
    return Margins(
        crossover,
        None if crossover is None else 180.0 + _at(frequency, phase, crossover),
        turn,
        None if turn is None else -_at(frequency, gain_db, turn),
        bandwidth,
    )


def _fade(size: int) -> Vector:
    """Ones with raised-cosine ends (Tukey): the lap's beginning and end would else leak over all frequencies."""
    ends = max(2, round(FADE * size))
    window = np.ones(size)
    rise = 0.5 - 0.5 * np.cos(np.pi * (np.arange(ends) + 0.5) / ends)
    window[:ends], window[-ends:] = rise, rise[::-1]
    return window


def _falls_through(frequency: Vector, values: Vector, level: float) -> float | None:
    """Last frequency at which a curve falls through a level, interpolated on a logarithmic axis."""
    falls = np.flatnonzero((values[:-1] > level) & (values[1:] <= level))
    if not len(falls):
        return None
    k = int(falls[-1] if level == 0.0 else falls[0])
    share = (values[k] - level) / (values[k] - values[k + 1])
    return float(np.exp(np.log(frequency[k]) + share * (np.log(frequency[k + 1]) - np.log(frequency[k]))))


def _at(frequency: Vector, values: Vector, place: float) -> float:
    return float(np.interp(np.log(place), np.log(frequency), values))
