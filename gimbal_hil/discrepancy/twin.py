"""The twin: a model with effects switched on, evaluated along measured records as left-over torque and rate error."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from gimbal_hil.discrepancy.kernel import balance
from gimbal_hil.discrepancy.record import RATE_ERROR, TORQUE, Channel, Record
from gimbal_hil.discrepancy.smoothing import Floats, scored
from sim_backend import layout
from sim_backend.effects import CATALOGUE
from sim_backend.model import AntennaModel, plant_arrays, put_friction

_FRICTION_SLOTS = 7
#: slower logs are carried in several steps a sample
_LONGEST_STEP_S = 1e-3


@dataclass
class Structure:
    """Arrays for one list of effects; parameters are poked into P."""

    P: np.ndarray
    K: np.ndarray
    X: np.ndarray
    steps: int
    #: slot in P of parameter j of appended effect i is offsets[i] + j
    offsets: tuple[int, ...]
    #: axes in which a share of the inertia hangs on a spring: there the encoder's own error rings
    ringing: frozenset[str] = frozenset()


@dataclass
class Twin:
    """Evaluates hypotheses about one model on records; keeps the arrays of structures it has met."""

    model: AntennaModel
    records: tuple[Record, ...]
    #: axes whose gyro every log of the call has; None: look at these records alone
    gyro_everywhere: tuple[bool, ...] | None = None
    #: noise of every row over its channel's floor, per record (rows that count, channels); None: all alike
    scales: tuple[Floats, ...] | None = None
    _structures: dict[tuple[tuple[str, str], ...], Structure] = field(default_factory=dict)

    @property
    def channels(self) -> tuple[Channel, ...]:
        """Torque of every axis, and rate error where every record has a gyro."""
        axes = self.model.axes
        found = [Channel(axis, TORQUE, i) for i, axis in enumerate(axes)]
        present = self.gyro_everywhere or tuple(all(r.has_gyro[i] for r in self.records) for i in range(len(axes)))
        found += [Channel(axis, RATE_ERROR, 2 + i) for i, axis in enumerate(axes) if present[i]]
        return tuple(found)

    def structure(self, effects: Sequence[tuple[str, str]]) -> Structure:
        """Arrays of the model with these (effect, axis) appended, neutral."""
        key = tuple(effects)
        if key not in self._structures:
            model = self.model
            own = len([entry for entry in model.effects if not entry.effect.is_number])
            added = [(name, axis) for name, axis in key if not CATALOGUE[name].is_number]
            for name, axis in added:
                model = model.with_effect(name, axis, {})
            names = {name for name, _ in key} | {entry.effect.name for entry in model.effects}
            period_s = self.records[0].bands.period_s
            steps = max([CATALOGUE[name].fine_steps for name in names], default=1) * max(
                1, round(period_s / _LONGEST_STEP_S)
            )
            arrays = plant_arrays(_with_step(model, period_s / steps), 1.0 / period_s)
            P, K = arrays.P, arrays.K
            for i in range(len(model.axes)):
                block = layout.axis_block(i)
                P[block + layout.GYRO_NOISE] = P[block + layout.GYRO_STEP] = P[block + layout.STOP_STIFFNESS] = 0.0
            offsets = iter(
                range(
                    layout.EFFECT_PARAMETERS + own * layout.PARAMETERS_PER_INSTANCE,
                    len(P),
                    layout.PARAMETERS_PER_INSTANCE,
                )
            )
            places = tuple(-1 if CATALOGUE[name].is_number else next(offsets) for name, _ in key)
            ringing = frozenset(entry.axis for entry in model.effects if entry.effect.rings_on_encoder_noise)
            self._structures[key] = Structure(P, K, arrays.X, steps, places, ringing)
        return self._structures[key]

    def leftover(
        self, structure: Structure, P: np.ndarray, which: int, records: tuple[Record, ...] | None = None
    ) -> Floats:
        """Unscored residual of one record, (n, 4): torque given minus needed per axis, gyro minus predicted rate per
        axis.
        """
        record = (records or self.records)[which]
        out = self._balanced(structure, P, record)[:, :4]
        out[:, 2:] = record.gyro - out[:, 2:]
        return out

    def applied(self, structure: Structure, P: np.ndarray, which: int) -> Floats:
        """Torque that the actuator gives over the intervals of one record, (n, 2)."""
        return self._balanced(structure, P, self.records[which])[:, 4:]

    def _balanced(self, structure: Structure, P: np.ndarray, record: Record) -> Floats:
        X = structure.X.copy()
        for i in range(len(self.model.axes)):
            block = layout.axis_block(i)
            put_friction(P, X, i, P[block : block + _FRICTION_SLOTS])
            X[layout.GYRO_STATE + 2 * i] = record.gyro[0, i]
            X[layout.LAGGED + i] = record.torque[0, i]
        out = np.empty((len(record.torque), 6))
        balance(P, structure.K, X, structure.steps, record.torque, record.motion, record.base, record.heat, out)
        return out

    def scored(self, structure: Structure, P: np.ndarray, which: int) -> Floats:
        """Scored residual of one record, (rows that count, channels), each row by what it is worth."""
        return self.scored_rows(self.leftover(structure, P, which), which)

    def scored_rows(self, left: Floats, which: int) -> Floats:
        """The same of a residual that has been evaluated, (n, 4)."""
        rows = self._low_passed(left, which)
        return rows if self.scales is None else np.asarray(rows / self.scales[which])

    def unscaled(self, structure: Structure, P: np.ndarray, which: int) -> Floats:
        """Scored residual of one record as it is, (rows that count, channels)."""
        return self._low_passed(self.leftover(structure, P, which), which)

    def _low_passed(self, left: Floats, which: int) -> Floats:
        record = self.records[which]
        left = left[:, [channel.column for channel in self.channels]]
        if not np.isfinite(left).all():
            # a candidate that the twin cannot carry: no row of it means anything
            return np.full((int(record.keep.sum()), left.shape[1]), np.nan)
        return np.asarray(scored(left, record.bands)[record.keep])

    def residual(self, structure: Structure, P: np.ndarray) -> Floats:
        """Scored residuals of all records, one under the other, (rows, channels)."""
        return np.concatenate([self.scored(structure, P, i) for i in range(len(self.records))])


def _with_step(model: AntennaModel, step_s: float) -> AntennaModel:
    """The model with the twin's step in place of the plant's."""
    from dataclasses import replace

    return replace(model, file=model.file.model_copy(update={"plant_step_s": step_s}))
