"""What a row is worth: the encoder's own error, carried through the whole pipeline, makes some rows noisier than
others.

Where a joint creeps or stands, friction follows the modulus of a rate that is mostly the encoder's step, and the
carried bristle leaks. No spectrum and no lap shows that. And where a joint crawls over single steps, or turns evenly by
nearly a simple fraction of steps a sample, the rounding error is no white noise but a sawtooth with harmonics inside
the scored band. So the logs are read again with other draws of the encoder's error, and the local spread of what the
pipeline leaves, beyond that of quiet rows, is added to the floor row by row. Where a joint stands and its bristle is
finer than the encoder, friction is whatever holds it: any torque up to break-away. And where a model states no bristle,
it says nothing of how friction turns over at a reversal, nor of a joint that creeps.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.discrepancy.twin import TORQUE, Floats, Twin, reread, scored
from sim_backend.effects import CREEPS_M_S, CREEPS_RAD_S, GIVES_M, GIVES_RAD, SLIDES_M, SLIDES_RAD
from sim_backend.model import AntennaModel

_DRAWS = 3
#: motion is even when it follows a cubic over this long, s, to within so many steps of the encoder
_EVEN_S, _QUICK_STEPS = 0.25, 1.5
#: rows over which the spread is averaged, s
_AVERAGED_S = 0.5
#: a joint stands where it is seen within so many steps for so long, s; and moves where it is seen beyond so many; its
#: rate, by which it creeps, is that over so long, s
_STANDS, _STANDS_S, _FLICKER, _CREEPS_S = 2.0, 0.5, 5.0, 0.1
#: time within which friction turns over at a reversal where the model does not say how, s
_TURNS_S = 0.02
#: spread that every row has: this quantile of the rows is in the floor already
_QUIET_ROWS = 0.3


def jittered(table: SignalsTable, twin: Twin, rng: np.random.Generator) -> SignalsTable:
    """The same log with another draw of the encoder's rounding error: that of marks which stand elsewhere; white where
    motion is quick.
    """
    columns = dict(table.columns)
    for axis in twin.model.axes:
        position = table.position(axis)
        step = encoder_step(table, axis, twin.model)
        if step > 0.0:
            even = _even_motion(position, table.period_s)
            shifted = even + step * rng.random()
            rounding = np.round(shifted / step) * step - shifted
            white = step * (rng.random(len(position)) - 0.5)
            columns[f"{axis}.position"] = position + np.where(
                np.abs(position - even) > _QUICK_STEPS * step, white, rounding
            )
    return SignalsTable.of(twin.model.axes, table.time_s, columns, table.repeat, "jittered")


def _even_motion(position: Floats, period_s: float) -> Floats:
    """Where a joint is between an encoder's marks: straight lines through the middle of every change, cubic over a
    quarter of a second.
    """
    from scipy.signal import savgol_filter

    at = np.flatnonzero(np.diff(position) != 0.0)
    if len(at) == 0:
        return position
    between = np.interp(np.arange(len(position)), at + 0.5, 0.5 * (position[at] + position[at + 1]))
    window = min(2 * int(0.5 * _EVEN_S / period_s) + 1, (len(position) - 1) // 2 * 2 + 1)
    return np.asarray(savgol_filter(between, window, 3)) if window > 3 else np.asarray(between)


def encoder_step(table: SignalsTable, axis: str, model: AntennaModel) -> float:
    """Step of an axis' encoder: the model's, or a coarser one that the data show."""
    return max(model.number(axis, "encoder.step"), seen_step(table.position(axis)))


def moves(table: SignalsTable, axis: str, model: AntennaModel) -> bool:
    """Whether a joint moves by more than an encoder that flickers between a few marks."""
    return float(np.ptp(table.position(axis))) > _FLICKER * encoder_step(table, axis, model)


def seen_step(position: Floats) -> float:
    """Step of the encoder that the data show: the smallest change between samples, where such changes are many; zero
    where they are not.

    A model may state a finer encoder than the rig has. Rounded decimals of a text file are no step: there few changes
    are equal.
    """
    changes = np.abs(np.diff(position))
    changes = changes[changes > 0.0]
    if len(changes) == 0:
        return 0.0
    least = float(changes.min())
    multiple = changes / least
    regular = np.abs(multiple - np.round(multiple)) < 0.1
    return least if float(np.mean(regular[multiple < 5.0])) > 0.9 and float(np.mean(multiple < 5.0)) > 0.01 else 0.0


def encoder_noise(twin: Twin, tables: tuple[SignalsTable, ...], seed: int = 5) -> tuple[Floats, ...]:
    """Mean square that the encoder's error makes around every scored row, per record (rows that count, channels)."""
    rng = np.random.default_rng(seed)
    draws = [
        [_drawn(twin, which, jittered(table, twin, rng)) for _ in range(_DRAWS)] for which, table in enumerate(tables)
    ]
    return tuple(np.asarray(np.mean(squares, axis=0)) for squares in draws)


def held_squares(twin: Twin, which: int, table: SignalsTable) -> Floats:
    """Squares of what friction may be where a joint stands, per scored row of one record (rows that count, channels).

    Of a joint that never moves nobody knows how its bristle came to stand, however fine the encoder is.
    """
    from scipy.ndimage import maximum_filter1d, minimum_filter1d

    model, record = twin.model, twin.records[which]
    found = np.zeros((int(record.keep.sum()), len(twin.channels)))
    window = 2 * round(0.5 * _STANDS_S / table.period_s) + 1
    for j, channel in enumerate(twin.channels):
        step, stiffness = encoder_step(table, channel.axis, model), model.number(channel.axis, "friction.sigma0")
        level = model.number(channel.axis, "friction.breakaway")
        if channel.signal != TORQUE:
            continue
        if not moves(table, channel.axis, model):
            found[:, j] = level**2
        if step == 0.0 or (stiffness > 0.0 and level / stiffness > step):
            continue
        position = table.position(channel.axis)
        seen = maximum_filter1d(position, window) - minimum_filter1d(position, window)
        found[record.at_scored(seen < (_STANDS + 0.5) * step), j] = level**2
    return found


def unsaid_squares(twin: Twin, which: int) -> Floats:
    """Squares of what friction may be where a model that states no bristle says nothing of it, per scored row of one
    record (rows that count, channels).

    At a reversal friction is any torque between its two levels for some time. And where a joint creeps it may hang on
    its bristle, at any torque up to break-away.
    """
    from scipy.ndimage import gaussian_filter1d

    model, record = twin.model, twin.records[which]
    found = np.zeros((int(record.keep.sum()), len(twin.channels)))
    late = max(1, round(_TURNS_S / record.bands.period_s))
    for j, channel in enumerate(twin.channels):
        if channel.signal != TORQUE or model.number(channel.axis, "friction.sigma0") > 0.0:
            continue
        axis = model.axes.index(channel.axis)
        position, rate = record.motion[:, axis], record.motion[:, 2 + axis]
        friction = model.number(channel.axis, "friction.coulomb") * np.sign(rate)
        before = np.concatenate([friction[:1].repeat(late), friction[:-late]])
        held = model.number(channel.axis, "friction.breakaway") * creeps(
            position, record.bands.period_s, model.is_linear
        )
        turns, holds = scored(np.column_stack([friction - before, held]), record.bands)[record.keep].T
        turned = gaussian_filter1d(turns**2, 0.5 * _TURNS_S / (record.bands.stride * record.bands.period_s))
        found[:, j] = np.maximum(turned, holds**2)
    return found


def creeps(position: Floats, period_s: float, is_linear: bool) -> NDArray[np.bool_]:
    """Where a joint is slow and stays within a way that joints give before they slide, so that it may not slide, (n,).

    One that is slow over a longer way slides slowly. One that never slides shows nothing else than how it gives.
    """
    from scipy.ndimage import uniform_filter1d

    slides, gives, creeps_at = (SLIDES_M, GIVES_M, CREEPS_M_S) if is_linear else (SLIDES_RAD, GIVES_RAD, CREEPS_RAD_S)
    if np.ptp(position) <= slides:
        return np.zeros(len(position), bool)
    rate = uniform_filter1d(np.gradient(position, period_s), max(1, round(_CREEPS_S / period_s)))
    slow = np.abs(rate) < creeps_at
    stretch = np.cumsum(np.diff(slow, prepend=slow[:1]))
    first = np.flatnonzero(np.diff(stretch, prepend=-1))
    way = np.maximum.reduceat(position, first) - np.minimum.reduceat(position, first)
    return np.asarray(slow & (way[stretch] < gives))


def other_readings(twin: Twin, tables: tuple[SignalsTable, ...], seed: int = 11) -> tuple[Twin, ...]:
    """Twins of the same logs, the same rows counting, with other draws of the encoder's error."""
    rng = np.random.default_rng(seed)
    logs = list(zip(tables, twin.records, strict=True))
    drawn = [
        tuple(reread(record, jittered(table, twin, rng), twin.model, "another draw") for table, record in logs)
        for _ in range(_DRAWS)
    ]
    return tuple(Twin(twin.model, records, twin.gyro_everywhere, twin.scales) for records in drawn)


def _drawn(twin: Twin, which: int, table: SignalsTable) -> Floats:
    """Squares by which a record's scored rows differ when its log is read with another draw, averaged over neighbouring
    rows.
    """
    from scipy.ndimage import gaussian_filter1d

    record, structure = twin.records[which], twin.structure(())
    other = reread(record, table, twin.model, "another draw")
    moved = Twin(twin.model, (other,), twin.gyro_everywhere).unscaled(structure, structure.P, 0)
    rows = max(1.0, _AVERAGED_S / (record.bands.stride * record.bands.period_s))
    return np.asarray(
        gaussian_filter1d((moved - twin.unscaled(structure, structure.P, which)) ** 2, 0.5 * rows, axis=0)
    )


def row_scales(twin: Twin, tables: tuple[SignalsTable, ...], floor: Floats) -> tuple[Floats, ...]:
    """Noise of every scored row over the channel's floor, per record (rows that count, channels); at least one."""
    noise = encoder_noise(twin, tables)
    quiet = [np.quantile(spread, _QUIET_ROWS, axis=0) for spread in noise]
    found = []
    for which, (spread, least) in enumerate(zip(noise, quiet, strict=True)):
        unsaid = np.maximum(held_squares(twin, which, tables[which]), unsaid_squares(twin, which))
        found.append(np.sqrt(1.0 + (np.maximum(spread - least, 0.0) + unsaid) / floor**2))
    return tuple(found)
