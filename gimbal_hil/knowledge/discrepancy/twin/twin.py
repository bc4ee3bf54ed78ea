"""The twin: a model with effects switched on, evaluated along measured records as left-over torque and rate error."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gimbal_hil.knowledge.discrepancy.twin.kernel import EVERY_PART, Part, balance
from gimbal_hil.knowledge.discrepancy.twin.parts import Instances, changed_parts
from gimbal_hil.knowledge.discrepancy.twin.record import RATE_ERROR, TORQUE, Channel, Record
from gimbal_hil.knowledge.discrepancy.twin.smoothing import Floats, scored, scored_length
from sim_backend import layout
from sim_backend.effects import CATALOGUE
from sim_backend.model import AntennaModel, plant_arrays, put_friction

_FRICTION_SLOTS = 7
#: size of a small change of the command over its rms
_DITHER = 1e-3
#: share of it that is rounding
_ROUNDING = 1e-6
#: evaluations of a record that are kept at hand
_AT_HAND = 4
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
    #: every effect that adds physics, those of the model first
    instances: Instances = ()


@dataclass(frozen=True)
class Evaluation:
    """What a twin leaves of one record: rows (6, n) as `balance` fills them, and their columns low-passed once asked
    for.
    """

    record: Record
    structure: Structure
    P: Floats
    rows: Floats
    thin: dict[int, Floats]

    @property
    def leftover(self) -> Floats:
        """Torque given minus needed per axis, gyro minus predicted rate per axis, (n, 4)."""
        found = self.rows[:4].T.copy()
        found[:, 2:] = self.record.gyro - found[:, 2:]
        return found

    def thinned(self, column: int) -> Floats:
        """One column of the left-over, low-passed and thinned, (rows,)."""
        if column not in self.thin:
            left = self.rows[column] if column < 2 else self.record.gyro[:, column - 2] - self.rows[column]
            bands = self.record.bands
            finite = bool(np.isfinite(left).all())
            self.thin[column] = (
                scored(left[:, None], bands)[:, 0] if finite else np.full(scored_length(len(left), bands), np.nan)
            )
        return self.thin[column]


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
    #: the last evaluations of every record; records with a dithered command, and the dither low-passed
    _kept: list[tuple[Record, list[Evaluation]]] = field(default_factory=list, init=False, repr=False)
    _dithered: dict[int, tuple[Record, Floats]] = field(default_factory=dict, init=False, repr=False)

    @property
    def channels(self) -> tuple[Channel, ...]:
        """Torque of every axis, and rate error where every record has a gyro."""
        axes = self.model.axes
        found = [Channel(axis, TORQUE, i) for i, axis in enumerate(axes)]
        present = self.gyro_everywhere or tuple(all(r.has_gyro[i] for r in self.records) for i in range(len(axes)))
        found += [Channel(axis, RATE_ERROR, 2 + i) for i, axis in enumerate(axes) if present[i]]
        return tuple(found)

    def structure(self, effects: Sequence[tuple[str, str]]) -> Structure:
        """Arrays of the model with these (effect, axis) appended, neutral; of what the model states itself and moves in
        place, that instance.
        """
        key = tuple(effects)
        if key not in self._structures:
            model = self.model
            own = len([entry for entry in model.effects if not entry.effect.is_number])
            places: list[int | None] = []
            for name, axis in key:
                at = None if CATALOGUE[name].is_number else self.model.own_instance(name, axis)
                if at is None and not CATALOGUE[name].is_number:
                    model, at, own = model.with_effect(name, axis, {}), own, own + 1
                places.append(at)
            present = [CATALOGUE[name] for name, _ in key] + [entry.effect for entry in model.effects]
            period_s = self.records[0].bands.period_s
            steps = max([effect.fine_steps for effect in present], default=1) * max(
                1, round(period_s / _LONGEST_STEP_S)
            )
            arrays = plant_arrays(_with_step(model, period_s / steps), 1.0 / period_s)
            P, K = arrays.P, arrays.K
            for i in range(len(model.axes)):
                block = layout.axis_block(i)
                P[block + layout.GYRO_NOISE] = P[block + layout.GYRO_STEP] = P[block + layout.STOP_STIFFNESS] = 0.0
            instances = range(layout.EFFECT_PARAMETERS, len(P), layout.PARAMETERS_PER_INSTANCE)
            offsets = tuple(-1 if at is None else instances[at] for at in places)
            ringing = frozenset(entry.axis for entry in model.effects if entry.effect.rings_on_encoder_noise)
            hooks = tuple(
                (entry.effect.name, model.axes.index(entry.axis))
                for entry in model.effects
                if not entry.effect.is_number
            )
            self._structures[key] = Structure(P, K, arrays.X, steps, offsets, ringing, hooks)
        return self._structures[key]

    def evaluated(self, structure: Structure, P: Floats, record: Record) -> Evaluation:
        """One record with these numbers. What does not differ from an evaluation that is still at hand is taken from
        there, to the bit.
        """
        kept = next((kept for own, kept in self._kept if own is record), None)
        if kept is None:
            if not any(record is own for own in (*self.records, *(moved for moved, _ in self._dithered.values()))):
                return self._evaluate(structure, P, record, EVERY_PART, None)
            kept = []
            self._kept.append((record, kept))
        alike = [one for one in kept if one.structure.steps == structure.steps]
        parts = [changed_parts((one.structure.instances, structure.instances), (one.P, P)) for one in alike]
        best = min(range(len(parts)), key=lambda i: parts[i].bit_count(), default=None)
        base = None if best is None else alike[best]
        if base is not None and best is not None:
            # the one that helped stays at hand longest
            kept[:] = [base, *(one for one in kept if one is not base)]
            if not parts[best]:
                return base
        one = self._evaluate(structure, P, record, EVERY_PART if best is None else parts[best], base)
        kept[1:1] = [one]
        del kept[_AT_HAND:]
        return one

    def _evaluate(
        self, structure: Structure, P: Floats, record: Record, parts: Part, base: Evaluation | None
    ) -> Evaluation:
        X = structure.X.copy()
        for i in range(len(self.model.axes)):
            block = layout.axis_block(i)
            put_friction(P, X, i, P[block : block + _FRICTION_SLOTS])
            X[layout.GYRO_STATE + 2 * i] = record.gyro[0, i]
            X[layout.LAGGED + i] = record.torque[0, i]
        rows = np.zeros((6, len(record.torque))) if base is None else base.rows.copy()
        balance(
            P, structure.K, X, structure.steps, record.torque, record.motion, record.base, record.heat, int(parts), rows
        )
        same = [column for column, part in enumerate(Part) if not part & parts]
        thin = {} if base is None else {column: base.thin[column] for column in same if column in base.thin}
        return Evaluation(record, structure, P, rows, thin)

    def leftover(
        self, structure: Structure, P: np.ndarray, which: int, records: tuple[Record, ...] | None = None
    ) -> Floats:
        """Unscored residual of one record, (n, 4): torque given minus needed per axis, gyro minus predicted rate per
        axis.
        """
        return self.evaluated(structure, P, (records or self.records)[which]).leftover

    def applied(self, structure: Structure, P: np.ndarray, which: int) -> Floats:
        """Torque that the actuator gives over the intervals of one record, (n, 2)."""
        return self.evaluated(structure, P, self.records[which]).rows[4:].T

    def dithered(self, which: int) -> Record:
        """A record with a small random change of its command."""
        return self._with_dither(which)[0]

    def dither(self, which: int) -> Floats:
        """That change, low-passed and thinned, (rows, axes)."""
        return self._with_dither(which)[1]

    def passes(self, structure: Structure, P: np.ndarray) -> bool:
        """Whether a small change of the command reaches the joint as it does through the model as it stands, in the log
        with the widest range of commands.
        """
        own = self.structure(())
        return self._alike(self._came(structure, P), self._came(own, own.P))

    @cached_property
    def cuts_command(self) -> bool:
        """Whether effects that the model has keep a part of such a change from the joint."""
        own, record = self.structure(()), self.records[self._widest]
        change = np.where(_free(record), (self.dithered(self._widest).torque - record.torque).T, 0.0)
        return bool(own.instances) and not self._alike(self._came(own, own.P), change)

    @cached_property
    def _widest(self) -> int:
        return int(np.argmax([np.ptp(record.torque) for record in self.records]))

    def _came(self, structure: Structure, P: np.ndarray) -> Floats:
        """What of a small change of the command reaches the joint, (2, n)."""
        record = self.records[self._widest]
        changed, left = (self.evaluated(structure, P, one).rows[:2] for one in (self.dithered(self._widest), record))
        return np.where(_free(record), changed - left, 0.0)

    @staticmethod
    def _alike(one: Floats, other: Floats) -> bool:
        return bool(np.all(np.abs(one - other) <= _ROUNDING * np.max(np.abs(other))))

    def _with_dither(self, which: int) -> tuple[Record, Floats]:
        if which not in self._dithered:
            record = self.records[which]
            size = _DITHER * np.sqrt(np.mean(record.torque**2, axis=0))
            dither = size * np.random.default_rng(17).standard_normal(record.torque.shape)
            self._dithered[which] = replace(record, torque=record.torque + dither), scored(dither, record.bands)
        return self._dithered[which]

    def scored(self, structure: Structure, P: np.ndarray, which: int) -> Floats:
        """Scored residual of one record, (rows that count, channels), each row by what it is worth."""
        return self.scored_rows(self.evaluated(structure, P, self.records[which]), which)

    def scored_rows(self, one: Evaluation, which: int) -> Floats:
        """The same of a record that has been evaluated."""
        rows = self.thinned(one)[self.records[which].keep]
        return rows if self.scales is None else np.asarray(rows / self.scales[which])

    def unscaled(self, structure: Structure, P: np.ndarray, which: int) -> Floats:
        """Scored residual of one record as it is, (rows that count, channels)."""
        return self.thinned(self.evaluated(structure, P, self.records[which]))[self.records[which].keep]

    def thinned(self, one: Evaluation) -> Floats:
        """Low-passed residual of an evaluation, (rows, channels); where the twin cannot carry the candidate, no row
        means anything.
        """
        found = np.column_stack([one.thinned(channel.column) for channel in self.channels])
        return found if np.isfinite(found).all() else np.full_like(found, np.nan)

    def residual(self, structure: Structure, P: np.ndarray) -> Floats:
        """Scored residuals of all records, one under the other, (rows, channels)."""
        return np.concatenate([self.scored(structure, P, i) for i in range(len(self.records))])

    def __getstate__(self) -> dict[str, object]:
        """Without what is at hand: it is large, and made again where the work is done."""
        return self.__dict__ | {"_kept": [], "_dithered": {}}


def _free(record: Record) -> NDArray[np.bool_]:
    """Where no standing bristle is led to what holds the joint, whatever that is, (2, n); everywhere on an axis that
    does nothing but stand.
    """
    free = record.motion[:, 6:].T == 0.0
    return np.asarray(free | ~free.any(axis=1)[:, None])


def _with_step(model: AntennaModel, step_s: float) -> AntennaModel:
    """The model with the twin's step in place of the plant's."""
    return replace(model, file=model.file.model_copy(update={"plant_step_s": step_s}))
