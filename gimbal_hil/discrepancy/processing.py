"""Processing floor: what the pipeline leaves over when the data come from the model itself.

The null model is simulated in a loop of the twin's own that tracks the measured motion (the measured torque as feed-forward), read
through its encoder, and sent through the same smoothing and the same torque balance. What remains beyond its own
noise law is due to processing alone and must not be explained by anything.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from firmware_protocol.compiling import entry_point
from gimbal_hil.discrepancy.floors import spectral_floor, wide_twin
from gimbal_hil.discrepancy.record import RATE_ERROR, record_of
from gimbal_hil.discrepancy.smoothing import Floats
from gimbal_hil.discrepancy.twin import Twin
from gimbal_hil.signals import SignalsTable
from sim_backend import layout
from sim_backend.layout import AXES, POSITION, RATE
from sim_backend.model import plant_arrays
from sim_backend.model.arrays import base_rows
from sim_backend.step import plant_tick, read_encoder

#: bandwidth and damping of the loop that keeps the simulated axis at the measured motion
_TRACKING_RAD_S, _TRACKING_DAMPING = 20.0, 0.7


@entry_point
def track(
    P: np.ndarray, K: np.ndarray, X: np.ndarray, torque: np.ndarray, q: np.ndarray, v: np.ndarray, inertia: np.ndarray, out: np.ndarray
) -> None:
    """Simulate under torque (n, 2) plus tracking of q, v (n, 2); fills out (n, 4): torque used, encoder position, two each."""
    for k in range(torque.shape[0]):
        u0, u1 = 0.0, 0.0
        for axis in range(K[AXES]):
            out[k, 2 + axis] = read_encoder(P, K, X, axis, k)
            slip, rate = q[k, axis] - X[POSITION + axis], v[k, axis] - X[RATE + axis]
            pull = inertia[axis] * _TRACKING_RAD_S * (_TRACKING_RAD_S * slip + 2.0 * _TRACKING_DAMPING * rate)
            used = torque[k, axis] + pull
            out[k, axis] = used
            if axis == 0:
                u0 = used
            else:
                u1 = used
        plant_tick(P, K, X, (u0, u1))


def simulated(twin: Twin, table: SignalsTable, which: int) -> SignalsTable:
    """The same log as the model itself would have made it."""
    record, model = twin.records[which], twin.model
    period_s = table.period_s
    step_s = period_s / max(1, round(period_s / model.file.plant_step_s))
    arrays = plant_arrays(replace(model, file=model.file.model_copy(update={"plant_step_s": step_s})), 1.0 / period_s)
    P, K, X = arrays.P, arrays.K, arrays.X
    base = [table.base(name) for name in ("roll", "pitch", "yaw")]
    if any(x is not None for x in base):
        rows = base_rows(np.column_stack([x if x is not None else np.zeros(len(table)) for x in base]), period_s)
        K[layout.BASE_KIND], K[layout.BASE_ROWS], K[layout.BASE_TABLE] = layout.BaseKind.RECORDED, len(rows), len(P)
        P[layout.BASE_ROW_S] = period_s
        P = np.concatenate([P, rows.ravel()])
    n, axes = len(table), model.axes
    q, v, inertia = np.zeros((n, 2)), np.zeros((n, 2)), np.ones(2)
    for i, axis in enumerate(axes):
        q[:, i] = table.position(axis)
        v[:-1, i] = record.motion[:, 2 + i]
        inertia[i] = model.number(axis, model.own_inertia_path(axis))
        P[layout.axis_block(i) + layout.LIMIT] = 0.0
    X[POSITION : POSITION + len(axes)] = q[0, : len(axes)]
    torque = np.zeros((n, 2))
    torque[:-1] = record.torque
    out = np.zeros((n, 4))
    track(P, K, X, torque, q, v, inertia, out)
    columns = dict(table.columns)
    for i, axis in enumerate(axes):
        columns[f"{axis}.torque"], columns[f"{axis}.position"] = out[:, i], out[:, 2 + i]
    return SignalsTable.of(axes, table.time_s, columns, None, "simulated")


def processing_floors(twin: Twin, tables: tuple[SignalsTable, ...]) -> Floats:
    """Rms per channel that the pipeline leaves of simulated data beyond their own noise; zero for rate errors, which are kinematic."""
    which = int(np.argmin([len(r.torque) for r in twin.records]))
    table = simulated(twin, tables[which], which)
    if not all(np.isfinite(table.position(axis)).all() for axis in twin.model.axes):
        return np.zeros(len(twin.channels))
    alone = Twin(twin.model, (record_of(table, twin.model, twin.records[which].bands.scored_hz, "simulated"),))
    structure = alone.structure(())
    rms = np.sqrt(np.mean(alone.residual(structure, structure.P) ** 2, axis=0))
    wide = wide_twin(alone, (table,))
    found = []
    for j, channel in enumerate(twin.channels):
        if channel.signal == RATE_ERROR:
            found.append(0.0)
            continue
        noise = spectral_floor(wide, structure, structure.P, channel, alone.records[0].bands)
        found.append(float(np.sqrt(max(0.0, rms[j] ** 2 - noise**2))))
    return np.array(found)
