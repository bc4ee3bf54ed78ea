"""Collects from logs what each estimator needs: plateaus, presliding runs, stretches of torque-driven motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.identification.axis_response import AxisRecord
from gimbal_hil.knowledge.identification.presliding import PreslidingRun
from gimbal_hil.knowledge.identification.rigid_load import axis_load
from gimbal_hil.knowledge.identification.segments import Stretch, TorqueSource
from gimbal_hil.knowledge.identification.steadiness import find_steady_window
from gimbal_hil.knowledge.identification.velocity_map import Plateau
from sim_backend.model import AntennaModel

#: a plateau travels at least this many encoder steps and lasts this long
_PLATEAU_STEPS, _PLATEAU_S = 100.0, 0.5
#: a log that nobody says a reference of holds plateaus when at least this share of the time in which it moves is
#: steady (constant speeds of measured rigs 0.3 to 1, logs of sines 0.01 to 0.13); it moves where it travels more than
#: so many encoder steps in this time, s
_STEADY_SHARE, _MOVES_STEPS, _MOVES_S = 0.25, 4.0, 0.25
#: a loop that is asked for another speed has settled after this time, s
_LOOP_SETTLING_S = 0.5
#: torque that changes by less than this share of break-away a row is slow enough for the static presliding curve
_SLOW_SHARE = 0.02
#: at the start of a torque-driven stretch the joint moves less than this many encoder steps in 50 ms
_REST_STEPS, _REST_S = 4.0, 0.05
#: or no further than this many times what the model's bristles bend under the torque in that time
_REST_BENDS = 4.0
#: a reference speed that stays within this share of itself is one speed
_SAME_REFERENCE = 0.02
#: standard deviations of noise between its tenth and its ninetieth percentile, with room
_NOISE_SPREAD = 3.0


@dataclass(frozen=True)
class Log:
    """One signals table and how it is cut, per axis.

    Of the axes in `time_stated` somebody said when the torque of a row was in force.
    """

    name: str
    table: SignalsTable
    stretches: dict[str, tuple[Stretch, ...]]
    time_stated: frozenset[str] = frozenset()


@dataclass(frozen=True)
class Evidence:
    """Everything of one axis. `inertia` is the mean over the stretches used (None when there is none)."""

    axis: str
    plateaus: tuple[Plateau, ...]
    presliding: tuple[PreslidingRun, ...]
    records: tuple[AxisRecord, ...]
    inertia: float | None


def collect(logs: Sequence[Log], model: AntennaModel, axis: str) -> Evidence:
    """Sort every stretch of every log into what it is good for.

    Loop-driven stretches that travel far enough are tried as plateaus (the steadiness test decides). Torque-driven
    stretches that start at rest are records for the output error; those with slow torque are presliding runs too.
    """
    plateaus: list[Plateau] = []
    presliding: list[PreslidingRun] = []
    records: list[AxisRecord] = []
    inertias: list[float] = []
    step = max(model.number(axis, "encoder.step"), 1e-12)
    slow = _SLOW_SHARE * model.number(axis, "friction.breakaway")
    stiffness = model.number(axis, "friction.sigma0")
    for log in logs:
        steady: list[Plateau] = []
        for stretch in log.stretches[axis]:
            start = _end_of_rest(log.table, stretch, axis) if stretch.drive is TorqueSource.TORQUE else stretch.start
            position = log.table.position(axis)[start : stretch.stop]
            duration = len(position) * log.table.period_s
            if stretch.drive is TorqueSource.OFF or len(position) < 40:
                continue
            far = abs(float(position[-1] - position[0])) > _PLATEAU_STEPS * step and duration > _PLATEAU_S
            command = log.table.torque(axis)[start : stretch.stop]
            torque_driven = stretch.drive is TorqueSource.TORQUE and _at_rest(
                position, command, log.table.period_s, step, stiffness
            )
            if not torque_driven and not (
                stretch.drive is TorqueSource.LOOP and far and _asks_for_one_speed(log.table, stretch, axis)
            ):
                continue
            part = log.table.rows(start, stretch.stop)
            load = axis_load(part, model, axis)
            inertias.append(load.inertia)
            label = f"{log.name}: {stretch.label}"
            if not torque_driven:
                steady.append(Plateau(label, part.time_s, position, load.friction, load.inertia, _LOOP_SETTLING_S))
                continue
            records.append(AxisRecord(label, part.period_s, load.drive, position))
            if float(np.max(np.abs(np.diff(load.drive)))) < slow:
                presliding.append(PreslidingRun(label, part.time_s, position, load.friction))
        if log.table.signal(axis, "rate_ref") is not None or _is_of_plateaus(log.table, axis, steady, step):
            plateaus += steady
    inertia = float(np.mean(inertias)) if inertias else None
    return Evidence(axis, tuple(plateaus), tuple(presliding), tuple(records), inertia)


def _is_of_plateaus(table: SignalsTable, axis: str, plateaus: Sequence[Plateau], step: float) -> bool:
    """Whether a log without a reference is one of constant speeds: those make a good part of its motion. The crests of
    a swing are steady for a moment too, and what accelerates there looks like a torque that follows the position.
    """
    windows = [find_steady_window(plateau.time_s, plateau.position) for plateau in plateaus]
    steady_s = sum(window.stop - window.start for window in windows if window is not None) * table.period_s
    rows = max(2, int(round(_MOVES_S / table.period_s)))
    moves = np.abs(np.diff(table.position(axis)[::rows])) > _MOVES_STEPS * step
    return steady_s >= _STEADY_SHARE * float(np.count_nonzero(moves)) * rows * table.period_s


def _end_of_rest(table: SignalsTable, stretch: Stretch, axis: str) -> int:
    """First row to use: a torque that rests before it changes has the joint in balance only at the end of that rest."""
    command = table.torque(axis)[stretch.start : stretch.stop]
    changed = np.flatnonzero(command != command[0])
    rest = int(changed[0]) if len(changed) else 0
    return stretch.start + max(0, rest - max(2, int(round(_REST_S / table.period_s))))


def _asks_for_one_speed(table: SignalsTable, stretch: Stretch, axis: str) -> bool:
    """Whether the loop was to follow one constant speed, as far as its reference is known: moves and holds give no
    plateau.
    """
    reference = table.signal(axis, "rate_ref")
    if reference is None:
        return True
    asked = reference[stretch.start : stretch.stop]
    low, middle, high = np.percentile(asked, (10.0, 50.0, 90.0))
    # what changes from row to row is noise of the log and no other speed
    noise = _NOISE_SPREAD * float(np.std(np.diff(asked))) / np.sqrt(2.0)
    return bool(abs(middle) > 0.0 and high - low <= _SAME_REFERENCE * abs(middle) + noise)


def _at_rest(position: np.ndarray, torque: np.ndarray, period_s: float, step: float, stiffness: float) -> bool:
    """Whether the joint stands at first, or bends with a torque that changes from the first row on as bristles of that
    stiffness do.
    """
    rows = max(2, int(round(_REST_S / period_s)))
    bend = _REST_BENDS * float(np.ptp(torque[:rows])) / stiffness if stiffness > 0.0 else 0.0
    return bool(np.ptp(position[:rows]) <= max(_REST_STEPS * step, bend))
