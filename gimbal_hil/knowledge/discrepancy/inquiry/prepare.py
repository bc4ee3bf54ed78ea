"""From logs to an inquiry: records in the scored band, floors, candidates, known numbers refitted to the data."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import compress
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.discrepancy.hypotheses import (
    Fit,
    FitRule,
    Hypothesis,
    KnownNumber,
    Weighing,
    families,
    fit,
    known_numbers,
    parameters_of,
)
from gimbal_hil.knowledge.discrepancy.inquiry.inquiry import Inquiry, State, rms, selectable, state_of, weighing_of
from gimbal_hil.knowledge.discrepancy.inquiry.policy import Policy
from gimbal_hil.knowledge.discrepancy.noise import (
    Floor,
    WideTwin,
    effective_floors,
    encoder_share,
    encoder_squares,
    floors,
    moves,
    processing_floors,
    row_scales,
    smaller,
    spectral_floors,
    wide_twin,
)
from gimbal_hil.knowledge.discrepancy.twin import (
    Bands,
    Floats,
    Record,
    Twin,
    edge_rows,
    judging_name,
    record_of,
    scored,
    scoring_reach,
    searched_name,
)
from gimbal_hil.knowledge.executor import WorkExecutor
from sim_backend.effects import CATALOGUE
from sim_backend.model import AntennaModel

#: end of the scored band, Hz, at 1 kHz; slower logs score a smaller part
BAND_HZ = 25.0
#: and which part: the band's end times the sample period, with a gyro in the logs and without
_GYRO_SHARE, _ENCODER_SHARE = 0.05, 0.08
#: an octave in which inertia leaves this many times the command's own power says nothing, if it holds this share of
#: what is left
_SAYS_NOTHING, _HEARD, _LOWEST_HZ = 1.5, 0.02, 2.0
#: a known number that moves the residual by less than so many floors within its uncertainty stays where it is
_INERT = 0.1
#: scored rows that a log must have
_LEAST_ROWS = 8

Tables = tuple[SignalsTable, ...]


@dataclass(frozen=True)
class Noise:
    """Noise of every channel, what the pipeline leaves of the model itself, and the wide records that they are read
    from.
    """

    floors: tuple[Floor, ...]
    processing: Floats
    wide: WideTwin
    #: share of every floor's squares that is the encoder's error
    from_encoder: Floats

    def under(self, twin: Twin, hypothesis: Hypothesis) -> Noise:
        """The same once a hypothesis is taken out: a cause that reaches beyond the band passes for noise there. Floors
        never rise.
        """
        structure, P = parameters_of(self.wide, hypothesis)
        spectra = spectral_floors(twin, self.wide, structure, P)
        lower = smaller(list(self.floors), floors(twin, spectra, structure, P))
        return replace(self, floors=tuple(lower))

    def at_most(self, left: Floats) -> Noise:
        """The same where an explanation leaves less than a floor, rms per channel: that floor is none."""
        lower = tuple(
            replace(floor, rms=min(floor.rms, max(float(rest), 1e-12)))
            for floor, rest in zip(self.floors, left, strict=True)
        )
        return replace(self, floors=lower)

    def undercut(self, twin: Twin, hypothesis: Hypothesis, left: Floats) -> Noise:
        """The same at most as large as what a hypothesis leaves, rms per channel, of fitted rows and hold-out.

        A hypothesis that passes less of the encoder's error (a resonance, a smaller inertia) leaves less of noise, too:
        what it keeps back is added to what it leaves.
        """
        bands = twin.records[0].bands
        kept_back = [
            encoder_squares(self.wide, *parameters_of(self.wide, Hypothesis()), channel, bands)
            - encoder_squares(self.wide, *parameters_of(self.wide, hypothesis), channel, bands)
            for channel in twin.channels
        ]
        return self.at_most(np.sqrt(left**2 + np.maximum(kept_back, 0.0)))

    def effective(self, twin: Twin) -> Floats:
        """Floor per channel: noise and what no twin can follow."""
        return effective_floors(twin, list(self.floors), self.processing)


def scored_band(tables: Tables) -> float:
    """End of the scored band that these logs can have, Hz."""
    # a gyro reads points of a rate that the held torque bends between samples; encoder positions are means and reach
    # further
    gyro = any(table.signal(axis, "rate") is not None for table in tables for axis in table.axes)
    return min(BAND_HZ, (_GYRO_SHARE if gyro else _ENCODER_SHARE) / max(table.period_s for table in tables))


def prepared(
    model: AntennaModel,
    measured: Tables,
    holdout: Tables,
    band_hz: float | None,
    names: frozenset[str],
    policy: Policy,
    executor: WorkExecutor,
    tell: Callable[[str], None],
) -> tuple[Inquiry, Noise]:
    """Twins, floors and candidates (effects of these names); the band is narrowed where the encoder's error drowns what
    is there.
    """
    tell("smoothing the logs")
    taught, widest, hz = _searched(model, measured, (*measured, *holdout), band_hz)
    asked = _long_enough(holdout, _read(holdout, model, judging_name, hz))
    twin, held, noise = _in_band(model, taught, asked, max(hz, widest))
    rows = [int(record.keep.sum()) for record in held.records]
    selecting = np.concatenate([np.arange(n) < n // 2 for n in rows])
    catalogue = tuple(f for axis in model.axes for f in families(twin, axis) if f.effect in names)
    both = selectable(twin, held, selecting)
    inquiry = Inquiry(
        twin,
        held,
        both,
        selecting,
        noise.effective(twin),
        catalogue,
        policy,
        executor,
        tell,
        taught.tables,
        (*taught.left_out, *asked.left_out),
        from_encoder=noise.from_encoder,
    )
    return inquiry, noise


def judged_alone(model: AntennaModel, table: SignalsTable) -> tuple[Twin, Noise]:
    """A log as an inquiry would read it, without a search."""
    logs, widest, hz = _searched(model, (table,), (table,), None)
    twin, _, noise = _in_band(model, logs, logs, max(hz, widest))
    return twin, noise


def _read(tables: Tables, model: AntennaModel, name: Callable[[int], str], end_hz: float) -> tuple[Record, ...]:
    return tuple(record_of(table, model, end_hz, name(i)) for i, table in enumerate(tables))


def _searched(
    model: AntennaModel, measured: Tables, all_of_them: Tables, band_hz: float | None
) -> tuple[_Logs, float, float]:
    """Logs to search in, the widest band that all of them can have, and the one that is scored, Hz."""
    widest = scored_band(all_of_them)
    hz = band_hz or widest
    records = _read(measured, model, searched_name, hz)
    if band_hz is None:
        moving = np.array([any(moves(table, axis, model) for table in measured) for axis in model.axes])
        hz = useful_band(Twin(model, records), widest, moving)
        records = records if hz == widest else _read(measured, model, searched_name, hz)
    return _long_enough(measured, records), widest, hz


class _Logs(NamedTuple):
    """Logs with their records in the scored band, and where those come from that are too short for it."""

    tables: Tables
    records: tuple[Record, ...]
    left_out: tuple[str, ...]


def _long_enough(tables: Tables, records: tuple[Record, ...]) -> _Logs:
    """Logs of which rows are left between the ends of the filters; BadInputError where there is none."""
    kept = [int(record.keep.sum()) >= _LEAST_ROWS for record in records]
    if not any(kept):
        bands = records[0].bands
        least_s = (2.0 * edge_rows(bands) + _LEAST_ROWS * bands.stride) * bands.period_s
        have = " and ".join(f"{len(table) * table.period_s:.2g} s" for table in tables)
        raise BadInputError(
            tables[0].source or "the log",
            f"is too short for a scored band that ends at {bands.scored_hz:.3g} Hz: {have} to use",
            f"more than {least_s:.2g} s, or a wider --band",
        )
    short = (table.source for table, is_kept in zip(tables, kept, strict=True) if not is_kept)
    return _Logs(tuple(compress(tables, kept)), tuple(compress(records, kept)), tuple(short))


def useful_band(twin: Twin, hz: float, moving: NDArray[np.bool_]) -> float:
    """The band up to which the motion of joints that move says anything about the command: halved while its upper
    octave says less than nothing.

    There inertia times the measured acceleration adds to the command's power instead of taking from it: position noise,
    differentiated twice, or times that jitter. A fit would shrink the inertia to be rid of it.
    """
    model, axes = twin.model, len(twin.model.axes)
    own = np.array([model.number(axis, model.own_inertia_path(axis)) for axis in model.axes])
    sent = [record.torque[:, :axes] for record in twin.records]
    left = [part - own * record.motion[:, 4 : 4 + axes] for part, record in zip(sent, twin.records, strict=True)]

    def power(parts: list[Floats], end_hz: float) -> Floats:
        bands = Bands(end_hz, twin.records[0].bands.period_s)
        edge = scoring_reach(bands) // bands.stride + 1
        rows = np.concatenate([scored(part, bands)[edge:-edge] for part in parts])
        return np.asarray(np.mean(rows**2, axis=0)) if len(rows) else np.zeros(axes)

    while 0.5 * hz >= _LOWEST_HZ:
        size = np.maximum(power(left, hz), 1e-300)
        beyond = np.maximum(power(left, hz) - power(left, 0.5 * hz), 0.0)
        command = np.maximum(power(sent, hz) - power(sent, 0.5 * hz), 0.0)
        says = float(np.sum((beyond / size)[moving])) < _SAYS_NOTHING * float(np.sum((command / size)[moving]))
        if says or not np.any(beyond[moving] > _HEARD * size[moving]):
            break
        hz *= 0.5
    return hz


def _in_band(model: AntennaModel, taught: _Logs, asked: _Logs, widest: float) -> tuple[Twin, Twin, Noise]:
    """Twins of both sets of logs in one band, and the noise there."""
    twin, held = Twin(model, taught.records), Twin(model, asked.records)
    gyros = tuple(all(r.has_gyro[i] for r in (*twin.records, *held.records)) for i in range(len(model.axes)))
    twin.gyro_everywhere = held.gyro_everywhere = gyros
    wide, structure = wide_twin(twin, taught.tables, widest), twin.structure(())
    spectra = spectral_floors(twin, wide, structure, structure.P)
    found = floors(twin, spectra, structure, structure.P)
    levels = np.array([floor.rms for floor in found])
    twin.scales = row_scales(twin, taught.tables, levels)
    held.scales = row_scales(held, asked.tables, levels)
    # rows that are noisier than others count for less between laps too
    found = smaller(found, floors(twin, spectra, structure, structure.P))
    bands = twin.records[0].bands
    share = np.array([encoder_share(wide, structure, structure.P, channel, bands) for channel in twin.channels])
    return twin, held, Noise(tuple(found), processing_floors(twin, taught.tables), wide, share)


def as_stated(inquiry: Inquiry) -> State:
    """The model as its file has it."""
    alone = Weighing((1.0,) * len(inquiry.twin.channels), 1.0)
    return state_of(inquiry, fit(inquiry.twin, Hypothesis(), inquiry.floor, alone, FitRule(0)))


def recalibrated(inquiry: Inquiry, stated: State) -> tuple[Inquiry, State]:
    """The known numbers where the data put them inside their stated uncertainty; the inquiry keeps what each of them
    does.
    """
    inquiry.tell("refitting known numbers within their uncertainty")
    weighing = weighing_of(inquiry, stated)
    all_of_them = known_numbers(inquiry.twin.model)
    if not all_of_them:
        return inquiry, stated
    first = fit(inquiry.twin, _floating(all_of_them), inquiry.floor, weighing, FitRule(1))
    kept = tuple(known for j, known in enumerate(all_of_them) if _reach(first, j, known, inquiry.twin) > _INERT)
    if not kept:
        return inquiry, stated
    found = fit(inquiry.twin, _floating(kept), inquiry.floor, weighing)
    found = fit(inquiry.twin, found.hypothesis, inquiry.floor, weighing_of(inquiry, state_of(inquiry, found)))
    return replace(inquiry, known=found.jacobian), state_of(inquiry, found)


def _floating(known: tuple[KnownNumber, ...]) -> Hypothesis:
    return Hypothesis(floating=known, y=(0.0,) * len(known))


def _reach(found: Fit, j: int, known: KnownNumber, twin: Twin) -> float:
    """Floors by which a number can move the residual within its uncertainty, on the channel where it does most."""
    return float(np.max(rms(found.jacobian[:, j].reshape(-1, len(twin.channels)) * known.trust)))


def effect_names(only: tuple[str, ...], without: tuple[str, ...]) -> frozenset[str]:
    """Names of the catalogue that are searched; BadInputError where none is left."""
    found = frozenset(only or CATALOGUE) - frozenset(without)
    if not found:
        raise BadInputError("--only and --without", "leave no effect to search", "at least one that is not left out")
    return found
