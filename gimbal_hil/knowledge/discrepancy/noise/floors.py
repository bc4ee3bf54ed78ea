"""Noise floors: what would be left over if the model were perfect.

From repeats where the log has laps: the variance within equal phase over laps. Always from above the band as well:
white torque noise and white encoder noise (which the twin turns into torque growing with frequency squared) are fitted
to the spectrum beyond the scored band and carried down into it. Laps count before the spectrum, unless they differ by
more than twice as much: then something else than noise does not repeat.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.discrepancy.noise.row_noise import jittered
from gimbal_hil.knowledge.discrepancy.twin import (
    TORQUE,
    Bands,
    Channel,
    Floats,
    Record,
    Structure,
    Twin,
    record_of,
    scored,
    scoring_gain,
    scoring_reach,
)

#: the spectrum is read from here to there, in units of the scored band
_FROM, _TO = 1.45, 2.6
#: and further down where white noise is less than this share of what is read
_TOLD = 0.3
#: rows at a log's end that are no noise, and those of a segment of its spectrum, times scored band and period: 200 and
#: 512 at 25 Hz and 1 kHz
_END, _SEGMENT, _SHORTEST = 5.0, 12.8, 512
#: blocks in which what a resonance rings up is read, s
_BLOCK_S = 2.0
#: how exactly a twin can follow another integrator: share of the Coulomb level; and where it is a rate, share of its
#: noise
_EXACTNESS, _RATE_EXACTNESS = 0.0012, 0.05


@dataclass(frozen=True)
class Floor:
    """Rms noise of one channel in the scored band, and where the number comes from."""

    rms: float
    #: from laps; None where nothing repeats
    from_repeats: float | None
    from_spectrum: float


@dataclass
class WideTwin(Twin):
    """The same logs with smoothing wide enough to see the spectrum above the scored band."""

    tables: tuple[SignalsTable, ...] = ()

    @cached_property
    def redrawn(self) -> tuple[Record, ...]:
        """The records with another draw of the encoder's error; made when they are first asked for."""
        rng, hz = np.random.default_rng(7), self.records[0].bands.scored_hz
        drawn = [jittered(table, self, rng) for table in self.tables]
        return tuple(record_of(table, self.model, hz, f"{i} redrawn") for i, table in enumerate(drawn))


def wide_twin(twin: Twin, tables: tuple[SignalsTable, ...], band_hz: float | None = None) -> WideTwin:
    """The logs of a twin again, to beyond its scored band, or beyond `band_hz` where that is wider."""
    hz = min(_TO * (band_hz or twin.records[0].bands.scored_hz), 0.2 / twin.records[0].bands.period_s)
    records = tuple(record_of(table, twin.model, hz, f"{i}") for i, table in enumerate(tables))
    return WideTwin(twin.model, records, twin.gyro_everywhere, tables=tables)


def spectral_floor(
    wide: WideTwin, structure: Structure, P: NDArray[np.float64], channel: Channel, bands: Bands
) -> float:
    """Rms in the scored band of the noise law that fits the spectrum above it, and of what a resonance rings up."""
    left = _away_from_ends(
        wide, [wide.leftover(structure, P, which)[:, channel.column] for which in range(len(wide.records))]
    )
    law = _law_in_band(wide, left, channel, bands)
    if channel.signal != TORQUE or channel.axis not in structure.ringing:
        return law
    return float(np.hypot(law, _rung_up(wide, left, structure, P, channel, bands, law)))


def encoder_share(
    wide: WideTwin, structure: Structure, P: NDArray[np.float64], channel: Channel, bands: Bands
) -> float:
    """Share of the squares of that law that is the encoder's error, which a twin turns into torque by its inertia."""
    if channel.signal != TORQUE:
        return 0.0
    left = _away_from_ends(
        wide, [wide.leftover(structure, P, which)[:, channel.column] for which in range(len(wide.records))]
    )
    white, encoder = _laws_in_band(wide, left, channel, bands)
    return encoder / max(white + encoder, 1e-300)


def _away_from_ends(wide: WideTwin, left: list[Floats]) -> list[Floats]:
    """One channel's leftovers without the rows at the logs' ends."""
    return [
        column[record.bands.stride * int(np.argmax(record.keep)) : len(column) - round(_END / _reach(record.bands))]
        for record, column in zip(wide.records, left, strict=True)
    ]


def encoder_squares(
    wide: WideTwin, structure: Structure, P: NDArray[np.float64], channel: Channel, bands: Bands
) -> float:
    """Mean square in the scored band of what an encoder of the model's step makes of its error, read from another draw
    of it.
    """
    left = _away_from_ends(
        wide, [wide.leftover(structure, P, which)[:, channel.column] for which in range(len(wide.records))]
    )
    edge = scoring_reach(bands) // bands.stride + 1
    drawn = _of_another_draw(wide, left, structure, P, channel)
    squares = np.concatenate([scored(part[:, None], bands)[edge:-edge, 0] ** 2 for part in drawn])
    # of logs that are shorter than the ends of the filters nothing is left
    return float(np.mean(squares)) if len(squares) else 0.0


def _of_another_draw(
    wide: WideTwin, left: list[Floats], structure: Structure, P: NDArray[np.float64], channel: Channel
) -> list[Floats]:
    """What another draw of the encoder's error adds to one channel's leftovers."""
    each = range(len(wide.records))
    redrawn = _away_from_ends(
        wide, [wide.leftover(structure, P, which, wide.redrawn)[:, channel.column] for which in each]
    )
    return [a - b for a, b in zip(redrawn, left, strict=True)]


def _rung_up(
    wide: WideTwin,
    left: list[Floats],
    structure: Structure,
    P: NDArray[np.float64],
    channel: Channel,
    bands: Bands,
    law: float,
) -> float:
    """Rms that a resonance in the model makes of the encoder's error around its frequency, where the law from above the
    band has no peak.

    Read from another draw of that error. Where the spectrum says that the encoder is finer than the model's step, so is
    this.
    """
    drawn = _of_another_draw(wide, left, structure, P, channel)
    if not any(np.any(part) for part in drawn):
        return 0.0
    smooth = _law_in_band(wide, drawn, channel, bands)
    length = max(1, round(_BLOCK_S / (bands.stride * bands.period_s)))
    edge = scoring_reach(bands) // bands.stride + 1
    squares = [scored(part[:, None], bands)[edge:-edge, 0] ** 2 for part in drawn]
    # the median over blocks: rows in creep, which are weighed by themselves, are not in it
    whole = np.median(
        np.concatenate([s[: len(s) // length * length].reshape(-1, length).mean(axis=1) for s in squares])
    )
    finer = min(1.0, law / max(smooth, 1e-300))
    return finer * float(np.sqrt(max(0.0, float(whole) - smooth**2)))


def over_own_noise(
    twin: Twin, tables: tuple[SignalsTable, ...], structure: Structure, P: NDArray[np.float64], floor: Floats
) -> float:
    """Largest rms, over logs, halves and channels, in units of the noise that the same rows have above the band, at
    least the floor.

    A floor is one number, read from medians. Noise whose level changes (an encoder turned evenly by nearly a simple
    fraction of steps a sample aliases its rounding error) stands above it here and there, and has its own shape above
    the band there, too.
    """
    wide, bands, ratios = wide_twin(twin, tables), twin.records[0].bands, []
    for which, record in enumerate(twin.records):
        left, inside = wide.leftover(structure, P, which), twin.scored(structure, P, which)
        halves = np.array_split(np.arange(len(inside)), 2)
        for j, channel in enumerate(twin.channels):
            for half in halves:
                first, last = (int(record.rows[half[k]]) for k in (0, -1))
                law = _law_in_band(wide, [left[first:last, channel.column]], channel, bands, "mean")
                ratios.append(float(np.sqrt(np.mean(inside[half, j] ** 2))) / max(law, float(floor[j])))
    return max(ratios)


def _law_in_band(wide: WideTwin, left: list[Floats], channel: Channel, bands: Bands, average: str = "median") -> float:
    """Rms in the scored band of the noise law that fits the spectrum above it."""
    return float(np.sqrt(sum(_laws_in_band(wide, left, channel, bands, average))))


def _laws_in_band(
    wide: WideTwin, left: list[Floats], channel: Channel, bands: Bands, average: str = "median"
) -> tuple[float, float]:
    """The same by its parts, mean squares: white noise, and the encoder's."""
    from scipy.signal import detrend, welch

    dt = bands.period_s
    power: list[Floats] = []
    f = np.zeros(1)
    # logs of one call may differ in length, their spectra not
    segment = min(max(_SHORTEST, round(_SEGMENT / _reach(bands))), *(len(part) // 4 for part in left))
    for part in left:
        # welch itself takes the trend out of one segment after the other, four times as slowly
        level = detrend(sliding_window_view(part, segment)[:: segment - segment // 2])
        f, p = welch(level.ravel(), 1.0 / dt, nperseg=segment, noverlap=0, average=average, detrend=False)
        power.append(p * len(part))
    psd = np.sum(power, axis=0) / sum(len(part) for part in left)
    if not np.median(psd) > 0.0:
        # a joint that stands, with a torque that stands
        return 0.0, 0.0
    top = wide.records[0].bands.scored_hz
    start, lowest = _FROM / _TO * top, _FROM * bands.scored_hz
    while True:
        use = (f > start) & (f < 1.25 * top)
        laws = _noise_laws(f[use], top, channel, dt)
        share = _shares(laws, psd[use])
        if 0.5 * start < lowest or share[0] * laws[0, 0] > _TOLD * float(laws[0] @ share):
            break
        # so far above a narrow band the encoder's noise hides the white one, which is what counts inside
        start *= 0.5
    grid = np.linspace(0.0, bands.scoring[1], 400)
    gain = scoring_gain(grid, bands) ** 2
    noise = _noise_laws(grid, top, channel, dt) * share
    white, encoder = (float(np.trapezoid(noise[:, j] * gain, grid)) for j in range(2))
    return white, encoder


def _shares(laws: Floats, power: Floats) -> Floats:
    """How much of each law of noise, (f, laws), fits a spectrum, every frequency by its own scatter."""
    from scipy.optimize import nnls

    weight = 1.0 / power
    share = np.zeros(laws.shape[1])
    for _ in range(4):
        # weighing by the scattered spectrum itself would favour its dips; the fitted law is the better weight
        share, _ = nnls(laws * weight[:, None], power * weight)
        weight = 1.0 / np.maximum(laws @ share, 1e-3 * float(np.median(power)))
    return share


def _reach(bands: Bands) -> float:
    """End of the scored band in samples' rates: its smallness is how far the filters reach."""
    return bands.scored_hz * bands.period_s


def _noise_laws(f: Floats, top: float, channel: Channel, period_s: float) -> Floats:
    """Power of white torque (or gyro) noise and of white encoder noise over frequency behind `smoothing`'s differences,
    (f, 2).

    Second differences that average neighbours carry the encoder's noise into torque, first differences into rate; the
    encoder's law is one at `top`. Powers of frequency instead would be a few per cent off there, and what white noise
    lies under them wrong by half.
    """
    x, end = np.pi * f * period_s, np.pi * top * period_s
    if channel.signal == TORQUE:
        return np.column_stack([np.ones(len(f)), (np.sin(x) * np.tan(x) / (np.sin(end) * np.tan(end))) ** 2])
    return np.column_stack([np.cos(x) ** 2, (np.sin(x) / np.sin(end)) ** 2])


def repeat_floor(residual: Floats, record: Record) -> Floats | None:
    """Rms within equal phase over laps, per column of a record's scored residual; None without at least two laps."""
    if record.laps is None:
        return None
    rows = record.rows
    numbers = record.laps[np.minimum(rows, len(record.laps) - 1)]
    # rows before the first lap and after the last have negative numbers
    starts = {int(lap): int(np.argmax(record.laps == lap)) for lap in np.unique(numbers) if lap >= 0}
    if len(starts) < 2:
        return None
    length = int(np.median(np.diff(sorted(starts.values()))))
    if length < 4 * record.bands.stride:
        return None
    grid = np.arange(0.0, length, record.bands.stride)
    laps = []
    for lap, start in starts.items():
        mine = numbers == lap
        if mine.sum() < 0.9 * len(grid):
            continue
        phase = rows[mine] - start
        laps.append(
            np.column_stack(
                [np.interp(grid, phase, residual[mine, c], left=np.nan, right=np.nan) for c in range(residual.shape[1])]
            )
        )
    if len(laps) < 2:
        return None
    stack = np.stack(laps)
    seen = np.all(np.isfinite(stack), axis=(0, 2))
    variance = np.var(stack[:, seen], axis=0, ddof=1)
    return np.asarray(np.sqrt(np.mean(variance, axis=0)))


def spectral_floors(twin: Twin, wide: WideTwin, structure: Structure, P: NDArray[np.float64]) -> list[float]:
    """`spectral_floor` of every channel of the twin, given what explains the data best so far."""
    return [spectral_floor(wide, structure, P, channel, twin.records[0].bands) for channel in twin.channels]


def floors(twin: Twin, spectra: list[float], structure: Structure, P: NDArray[np.float64]) -> list[Floor]:
    """One floor per channel of the twin, given the structure and parameters that explain the data best so far and their
    `spectral_floors`.
    """
    found = []
    repeats = [repeat_floor(twin.scored(structure, P, i), record) for i, record in enumerate(twin.records)]
    known = [r for r in repeats if r is not None]
    for j, spectrum in enumerate(spectra):
        laps = float(np.sqrt(np.mean([r[j] ** 2 for r in known]))) if known else None
        rms = spectrum if laps is None or laps > 2.0 * spectrum else laps
        found.append(Floor(max(rms, 1e-12), laps, spectrum))
    return found


def smaller(one: list[Floor], other: list[Floor]) -> list[Floor]:
    """Channel by channel the smaller floor."""
    return [a if a.rms <= b.rms else b for a, b in zip(one, other, strict=True)]


def effective_floors(twin: Twin, found: list[Floor], processing: Floats) -> Floats:
    """Noise and what no twin can follow, per channel."""
    out = []
    for floor, channel, process in zip(found, twin.channels, processing, strict=True):
        exactness = _RATE_EXACTNESS * floor.rms
        if channel.signal == TORQUE:
            exactness = _EXACTNESS * twin.model.number(channel.axis, "friction.coulomb")
        out.append(float(np.sqrt(floor.rms**2 + max(exactness, min(process, floor.rms)) ** 2)))
    return np.array(out)


__all__ = [
    "Floor",
    "WideTwin",
    "effective_floors",
    "encoder_share",
    "encoder_squares",
    "floors",
    "over_own_noise",
    "repeat_floor",
    "smaller",
    "spectral_floor",
    "spectral_floors",
    "wide_twin",
]
