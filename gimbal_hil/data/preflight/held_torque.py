"""A torque column that got stuck, was clipped where it was logged, or was not logged any more, while the joint went on.

A torque that is the same to the last digit in many rows is nothing wrong: a drive at its limit, one that is off, a step
that was commanded. It is wrong where the joint moves in those rows as another torque would move it: nothing that a
motion needs puts them and the other rows of the same log together, and the model asks for another one too. At the ends
of a column's range the other rows say so alone: beyond a rail they ask for more, at a drive's limit for what it gives.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from gimbal_hil.data.preflight.impossible import AROUND, ColumnFault, Floats, Impossible
from gimbal_hil.data.signals import RigidBody, SignalsTable
from sim_backend.model import AntennaModel

#: so many rows of one torque are a stretch in which it is held; stretches count from this share of the rows on, and as
#: long as this share is left to tell what a motion needs
_HELD_ROWS, _LEAST_SHARE, _MOST_SHARE = 5, 0.01, 0.8
#: motion is smoothed over this long, s, and rows slower than this share of the top speed say nothing of friction
_SMOOTHING_S, _SLOW = 0.01, 0.02
#: held rows are missed by so many times what the others alone are, and by this share of their torque; the model misses
#: them by that share, and may be off by that factor in its friction
_TIMES, _MISSED, _SHARE, _FRICTION = 5.0, 0.1, 0.25, 3.0
_POWERS = (1, 2, 3)
#: of rows at a rail the others ask more in this share; at a limit that the drive has they do in half
_BEYOND = 0.75
#: a rail is the drive's own limit where it is that to this share
_AT_LIMIT = 0.01


def held_torques(model: AntennaModel, table: SignalsTable, axis: str) -> Iterator[Impossible]:
    """Rows of one torque in which the joint moves as by another."""
    held = _in_runs(table.torque(axis))
    share = float(np.mean(held))
    if len(held) < 40 * AROUND or share < _LEAST_SHARE:
        return
    position, rate, bend = _smoothed(model, table)
    torque, columns, needed, slack = _needs(model, table, axis, position, rate, bend)
    own = np.abs(rate[:, model.axes.index(axis)])
    moves = own > _SLOW * float(np.max(own))
    moves[: 4 * AROUND] = moves[-4 * AROUND :] = False
    inside, outside = held & moves, ~held & moves
    if np.count_nonzero(inside) < 4 * AROUND or np.count_nonzero(outside) < 40 * AROUND:
        return
    # of rows that are not held alone an answer for held ones would be far from what those rows had
    missed = np.abs(torque - columns @ _least_squares(columns[moves], torque[moves]))
    as_others = columns @ _least_squares(columns[outside], torque[outside])
    beside = np.abs(torque - as_others)
    short = np.maximum(np.abs(torque - needed) - slack, 0.0)
    usual, asked = _rms(beside[outside]), _rms(torque[outside])
    at_rails = inside & _at_the_ends(table.torque(axis), model.number(axis, "actuator.limit"))
    if _cut_off(torque[at_rails], as_others[at_rails], usual):
        rows = np.flatnonzero(at_rails)
        what = f"is at the end of the column's range, {len(rows)} rows in all, where the motion asks for more torque"
        yield Impossible(f"{axis}.torque", tuple(rows.tolist()), what, ColumnFault.STILL)
    elif (
        share <= _MOST_SHARE
        and _rms(missed[inside]) > max(_TIMES * usual, _MISSED * asked)
        and _rms(short[inside]) > _SHARE * asked
    ):
        rows = np.flatnonzero(inside & (missed > _TIMES * usual))
        what = (
            f"is the same as in the rows around it, {len(rows)} rows in all, where the motion asks for another torque"
        )
        yield Impossible(f"{axis}.torque", tuple(rows.tolist()), what, ColumnFault.STILL)


def _cut_off(torque: Floats, as_others: Floats, usual: float) -> bool:
    """Whether rows at a rail (n,) had more torque by what the others say of their motion: most of them, and clearly."""
    if len(torque) < 4 * AROUND:
        return False
    more = (as_others - torque) * np.sign(torque)
    clearly = max(usual, _MISSED * float(np.median(np.abs(torque))))
    return bool(np.mean(more > 0.0) > _BEYOND and np.median(more) > clearly)


def _least_squares(columns: Floats, torque: Floats) -> Floats:
    size = np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
    return np.asarray(np.linalg.lstsq(columns / size, torque, rcond=1e-9)[0] / size)


def _in_runs(torque: Floats) -> np.ndarray:
    """Which rows belong to a stretch of one value, (n,)."""
    same = np.concatenate([[False], np.diff(torque) == 0.0])
    edges = np.flatnonzero(np.diff(np.concatenate([[0], same.astype(np.int8), [0]])))
    held = np.zeros(len(torque), dtype=np.bool_)
    for first, last in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
        if last - first + 1 >= _HELD_ROWS:
            held[first - 1 : last] = True
    return held


def _at_the_ends(torque: Floats, limit: float) -> np.ndarray:
    """Which rows hold the largest or the smallest torque of a column, (n,), but for what the drive gives at most, which
    is a torque that it gave.
    """
    ends = (torque == torque.max()) | (torque == torque.min())
    return ends & ~np.isclose(np.abs(torque), limit, rtol=_AT_LIMIT)


def _smoothed(model: AntennaModel, table: SignalsTable) -> tuple[Floats, Floats, Floats]:
    """Position, rate and acceleration of all axes, (n, axes) each."""
    measured = np.column_stack([table.position(axis) for axis in model.axes])
    position, rate, bend = (_blurred(measured, table.period_s, order) / table.period_s**order for order in (0, 1, 2))
    return position, rate, bend


def _blurred(values: Floats, period_s: float, order: int = 0) -> Floats:
    from scipy.ndimage import gaussian_filter1d

    return np.asarray(gaussian_filter1d(values, max(2.0, _SMOOTHING_S / period_s), axis=0, order=order))


def _needs(
    model: AntennaModel, table: SignalsTable, axis: str, position: Floats, rate: Floats, bend: Floats
) -> tuple[Floats, Floats, Floats, Floats]:
    """Torque at the samples (n,), what it may be made of (n, k), what the rigid model asks for (n,), and by how much
    friction may be beside that (n,).
    """
    index, held = model.axes.index(axis), table.torque(axis)
    torque = _blurred(np.append(held[:1], 0.5 * (held[1:] + held[:-1])), table.period_s)
    body = RigidBody(model).along(table, position, rate)
    needed = body.inertial(bend)[:, index] - body.bias[:, index]
    own = rate[:, index]
    top = float(np.max(np.abs(own))) or 1.0
    place = (position[:, index] - position[:, index].mean()) / (float(np.ptp(position[:, index])) or 1.0)
    columns = [bend[:, index], own, np.tanh(own / (_SLOW * top)), np.ones(len(own))]
    columns += [place**power for power in _POWERS]
    level = max(model.number(axis, "friction.coulomb"), model.number(axis, "friction.breakaway"))
    slack = _FRICTION * (level + model.number(axis, "friction.viscous") * np.abs(own))
    return torque, np.column_stack(columns), needed, slack


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2)))
