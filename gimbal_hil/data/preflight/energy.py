"""Whether a motion has the energy that its torque can have given it: seconds that are minutes are found so.

What a torque does along a way is the same in any unit of time, and the energy of the motion is not: read in a unit 60
times too short, a joint is 60 times as fast and has 3600 times the energy. A model may be off by a factor; it is not
off by a hundred.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gimbal_hil.data.preflight.impossible import Floats
from gimbal_hil.data.signals import RigidBody, SignalsTable
from sim_backend.model import AntennaModel

#: a motion has gained so many times what torque and weight did: no model is so far off
_TIMES = 100.0
#: this share of the largest energy has to be gained so
_SHARE = 0.5
#: share of the torques below which the largest of them is taken
_ALMOST_ALL = 0.98
#: speeds are taken over ways of so many encoder steps, over so many rows, of which some may be old, and over this share
#: of the rows at most
_STEPS, _ROWS, _MOST_ROWS = 20.0, 16, 0.05
#: seconds in what people log instead
_LONGER = {60.0: "minutes", 1e3: "seconds that are called milliseconds", 3600.0: "hours", 86_400.0: "days"}
#: what torque did beyond that is friction, and a model is off by a factor: by so much an energy may differ from it
_ABOUT = 30.0


@dataclass(frozen=True)
class ImpossibleEnergy:
    """In one go a joint gained `gained` (J) where torque and weight can have done `given` (J), up to row `row`."""

    axis: str
    gained: float
    given: float
    row: int

    @property
    def time_unit(self) -> str:
        """What the times would be in if they were seconds only in name; empty where no such unit explains it."""
        times = {factor: abs(np.log(self.gained / factor**2 / self.given)) for factor in _LONGER}
        likely = min(times, key=lambda factor: times[factor])
        return _LONGER[likely] if times[likely] < np.log(_ABOUT) else ""


def impossible_energy(model: AntennaModel, table: SignalsTable) -> ImpossibleEnergy | None:
    """The first axis that gains more energy than its torque and weight can have given it; None for sound logs. One that
    is not driven may be moved by a hand.
    """
    positions = np.column_stack([table.position(axis) for axis in model.axes])
    bias = RigidBody(model).along(table, positions, np.zeros_like(positions)).bias
    for index, axis in enumerate(model.axes):
        span = _rows_of_a_speed(positions[:, index], model.number(axis, "encoder.step"))
        if span is None or not np.any(table.torque(axis) != 0.0):
            continue
        way = positions[span:, index] - positions[:-span, index]
        inertia = model.number(axis, model.own_inertia_path(axis))
        energy = 0.5 * inertia * (way / (span * table.period_s)) ** 2
        # a weight that the model does not know may do as much as the largest torque, which lifted it, anywhere
        strongest = float(np.quantile(np.abs(table.torque(axis)), _ALMOST_ALL))
        strength = strongest + np.abs(bias[:, index])
        work = _means(strength[:-1] * np.abs(np.diff(positions[:, index])), span)
        found = _gained(energy, work)
        if found is not None:
            return ImpossibleEnergy(axis, *found[:2], found[2] + span // 2)
    return None


def _rows_of_a_speed(position: Floats, step: float) -> int | None:
    """Rows over which a usual way is so long that its speed is more than rounding; None where none is."""
    rows = _ROWS
    while rows <= max(1, int(_MOST_ROWS * len(position))) and rows < len(position) - 2:
        if float(np.quantile(np.abs(position[rows:] - position[:-rows]), 0.9)) > _STEPS * step:
            return rows
        rows *= 2
    return None


def _means(work: Floats, span: int) -> Floats:
    """Work between the middles of neighbouring ways over `span` rows, (n - span,)."""
    summed = np.concatenate([[0.0], np.cumsum(work)])
    return np.asarray((summed[span:] - summed[:-span]) / span)


def _gained(energy: Floats, work: Floats) -> tuple[float, float, int] | None:
    """Energy gained and work done over the stretch in which most was gained beyond it, and its last row."""
    beyond = np.diff(energy) / _TIMES - work[: len(energy) - 1]
    total = np.concatenate([[0.0], np.cumsum(beyond)])
    lowest = np.minimum.accumulate(total)
    last = int(np.argmax(total - lowest))
    if (total - lowest)[last] * _TIMES < _SHARE * float(np.max(energy)) or last == 0:
        return None
    first = int(np.argmin(total[: last + 1]))
    return float(energy[last] - energy[first]), float(max(np.sum(work[first:last]), 1e-300)), last
