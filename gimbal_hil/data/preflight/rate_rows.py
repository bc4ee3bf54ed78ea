"""Rates of a gyro that cannot be: single reads that no torque can have made, and a column that stands still or sits at
its rail while the joint goes on.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from gimbal_hil.data.preflight.impossible import AROUND, ColumnFault, Floats, Impossible, median_around, scatter_of
from gimbal_hil.data.signals import SignalsTable
from sim_backend.model import AntennaModel

#: times the change of rate in a row that the largest torque makes; times the column's own scatter about its neighbours
_ACCELERATIONS, _SCATTERS = 5.0, 12.0
#: share of the torques below which the largest is taken where no limit is stated
_ALMOST_ALL = 0.98
#: a rate that is the same to the last digit for so many rows is held; so many others tell how it follows the joint
_HELD_ROWS, _OTHERS = 10, 200
#: held rates miss those of the joint by so many times what others do, and by this share of what the joint has
_TIMES, _SHARE = 5.0, 0.1
_SMOOTHING_S = 0.01


def impossible_rates(model: AntennaModel, table: SignalsTable, axis: str) -> Iterator[Impossible]:
    """What cannot be in the rate of one axis, where it was logged; one of zeros only was not."""
    column, rate = f"{axis}.rate", table.signal(axis, "rate")
    if rate is None or len(rate) < 4 * AROUND or not np.any(rate != 0.0):
        return
    joint = _slope(table.position(axis), table.period_s)
    off = (rate - median_around(rate)) - (joint - median_around(joint))
    limit = model.number(axis, "actuator.limit")
    strongest = limit if limit > 0.0 else float(np.quantile(np.abs(table.torque(axis)), _ALMOST_ALL))
    inertia = max(model.number(axis, model.own_inertia_path(axis)), 1e-12)
    longest = _ACCELERATIONS * strongest * table.period_s / inertia
    # of a coarse column the scatter is none: its own step is that
    steps = np.abs(np.diff(rate))
    coarse = float(np.median(steps[steps > 0.0])) if np.any(steps > 0.0) else 0.0
    spikes = np.flatnonzero(np.abs(off) > longest + _SCATTERS * max(scatter_of(off), coarse))
    if len(spikes):
        yield Impossible(column, tuple(spikes.tolist()), "where the joint cannot have had such a rate")
    held = _in_runs(rate)
    others = ~held
    others[spikes] = False
    if np.count_nonzero(others) < _OTHERS or np.count_nonzero(held) < _HELD_ROWS:
        return
    missed = rate - joint
    missed = missed - float(np.median(missed[others]))
    wrong = np.abs(missed) > _TIMES * _rms(missed[others])
    if _rms(missed[held]) > max(_TIMES * _rms(missed[others]), _SHARE * _rms(joint)) and np.any(held & wrong):
        rows = np.flatnonzero(held & wrong)
        what = f"is the same as in the rows around it, {len(rows)} rows in all, while the joint goes on"
        yield Impossible(column, tuple(rows.tolist()), what, ColumnFault.STILL)


def _slope(position: Floats, period_s: float) -> Floats:
    from scipy.ndimage import gaussian_filter1d

    width = max(2.0, _SMOOTHING_S / period_s)
    beyond = min(int(5 * width), len(position) - 1)
    # turned about its ends, a position goes on with the slope that it has there
    carried_on = np.pad(position, beyond, mode="reflect", reflect_type="odd")
    slope = np.asarray(gaussian_filter1d(carried_on, width, order=1))[beyond : beyond + len(position)]
    return slope / period_s


def _in_runs(values: Floats) -> np.ndarray:
    """Which rows belong to a stretch of one value, (n,)."""
    edges = np.flatnonzero(np.concatenate([[True], np.diff(values) != 0.0, [True]]))
    return np.repeat(np.diff(edges) >= _HELD_ROWS, np.diff(edges))


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2)))
