"""What a row is worth: the encoder's own error, carried through the whole pipeline, makes some rows noisier than others.

Where a joint creeps or stands, friction follows the modulus of a rate that is mostly the encoder's step, and the carried bristle leaks. No
spectrum and no lap shows that. So the logs are read again with another draw of the encoder's error, and the local spread of what the
pipeline leaves, beyond what it leaves in quiet rows, is added to the floor row by row.
"""

from __future__ import annotations

import numpy as np

from gimbal_hil.discrepancy.record import TORQUE, record_of
from gimbal_hil.discrepancy.smoothing import Floats
from gimbal_hil.discrepancy.twin import Twin
from gimbal_hil.signals import SignalsTable

_DRAWS = 2
#: rows over which the spread is averaged, s
_AVERAGED_S = 0.5
#: spread that every row has: this quantile of the rows is in the floor already
_QUIET_ROWS = 0.3


def jittered(table: SignalsTable, twin: Twin, rng: np.random.Generator) -> SignalsTable:
    """The same log with another draw of the encoder's rounding error."""
    columns = dict(table.columns)
    for axis in twin.model.axes:
        step = max(twin.model.number(axis, "encoder.step"), seen_step(table.position(axis)))
        columns[f"{axis}.position"] = table.position(axis) + step * (rng.random(len(table)) - 0.5)
    return SignalsTable.of(twin.model.axes, table.time_s, columns, table.repeat, "jittered")


def seen_step(position: Floats) -> float:
    """Step of the encoder that the data show: the smallest change between samples, where such changes are many; zero where they are not.

    A model may state a finer encoder than the rig has. Rounded decimals of a text file are no step: there few changes are equal.
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
    """Mean square that the encoder's error makes of every scored row, per record (rows that count, channels)."""
    rng = np.random.default_rng(seed)
    structure = twin.structure(())
    found = []
    for which, (record, table) in enumerate(zip(twin.records, tables, strict=True)):
        here = twin.unscaled(structure, structure.P, which)
        square = np.zeros_like(here)
        for _ in range(_DRAWS):
            other = record_of(jittered(table, twin, rng), twin.model, record.bands.scored_hz, "jittered", record.keep)
            moved = Twin(twin.model, (other,), twin.gyro_everywhere).unscaled(structure, structure.P, 0)
            square += (moved - here) ** 2 / _DRAWS
        found.append(square)
    return tuple(found)


def row_scales(twin: Twin, noise: tuple[Floats, ...], floor: Floats) -> tuple[Floats, ...]:
    """Noise of every scored row over the channel's floor, per record (rows that count, channels); at least one."""
    from scipy.ndimage import gaussian_filter1d

    found = []
    for record, square in zip(twin.records, noise, strict=True):
        rows = max(1.0, _AVERAGED_S / (record.bands.stride * record.bands.period_s))
        spread = gaussian_filter1d(square, 0.5 * rows, axis=0)
        excess = np.maximum(spread - np.quantile(spread, _QUIET_ROWS, axis=0), 0.0)
        excess[:, [channel.signal != TORQUE for channel in twin.channels]] = 0.0
        found.append(np.asarray(np.sqrt(1.0 + excess / floor**2)))
    return tuple(found)
