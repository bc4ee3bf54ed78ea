"""Processing floor: what the pipeline leaves over of data that the model itself could have made.

Along the measured motion the commanded torque is replaced by the one with which the model balances exactly; the
positions are read through the model's encoder step again. That log goes through the whole pipeline anew, and what it
leaves beyond the noise of the encoder is due to smoothing, holding and quantising alone: nothing may be named for it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.discrepancy.noise.floors import spectral_floor, wide_twin
from gimbal_hil.knowledge.discrepancy.twin import RATE_ERROR, Floats, Twin, record_of


def balanced(twin: Twin, table: SignalsTable, which: int) -> SignalsTable:
    """The same motion with the torque that the model needs for it, positions to the encoder's step."""
    # a standing bristle that is led towards the measured torque would carry what the model lacks into its own data
    record, structure = replace(twin.records[which], motion=_unled(twin.records[which].motion)), twin.structure(())
    left = twin.evaluated(structure, structure.P, record).leftover
    columns = dict(table.columns)
    n = len(record.torque)
    for i, axis in enumerate(twin.model.axes):
        torque = np.empty(len(table))
        torque[:n] = record.torque[:, i] - left[:, i]
        torque[n:] = torque[n - 1]
        # positions whose interval means are those of the record: the running integral of the mean rate
        position = np.empty(len(table))
        position[1 : n + 1] = table.position(axis)[0] + np.cumsum(record.motion[:, 2 + i]) * table.period_s
        position[0] = table.position(axis)[0]
        step = twin.model.number(axis, "encoder.step")
        columns[f"{axis}.torque"] = torque
        # what was known of it is in that torque
        columns.pop(f"{axis}.torque_known", None)
        columns[f"{axis}.position"] = np.round(position / step) * step if step > 0.0 else position
    return SignalsTable.of(twin.model.axes, table.time_s, columns, None, "balanced")


def _unled(motion: Floats) -> Floats:
    """Columns of `Record.motion` with no bristle led."""
    found = motion.copy()
    found[:, 6:] = 0.0
    return found


def processing_floors(twin: Twin, tables: tuple[SignalsTable, ...]) -> Floats:
    """Rms per channel that the pipeline leaves of balanced data beyond their own noise; zero for rate errors, which are
    kinematic.
    """
    which = int(np.argmin([len(r.torque) for r in twin.records]))
    table = balanced(twin, tables[which], which)
    alone = Twin(
        twin.model,
        (record_of(table, twin.model, twin.records[which].bands.scored_hz, "balanced"),),
        twin.gyro_everywhere,
    )
    structure = alone.structure(())
    rms = np.sqrt(np.mean(alone.residual(structure, structure.P) ** 2, axis=0))
    wide = wide_twin(alone, (table,))
    found = []
    for j, channel in enumerate(twin.channels):
        noise = (
            0.0
            if channel.signal == RATE_ERROR
            else spectral_floor(wide, structure, structure.P, channel, alone.records[0].bands)
        )
        found.append(0.0 if channel.signal == RATE_ERROR else float(np.sqrt(max(0.0, rms[j] ** 2 - noise**2))))
    return np.array(found)
