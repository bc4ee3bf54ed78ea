"""What a model leaves of a log when each of its numbers may be off by a factor: one channel per axis and signal.

No model of a stranger's rig is right, so a channel asks little: that torque is an inertia, a load and friction which
are the model's own within a factor of three, beside any curve over position; that the gyro follows joint and base; that
attitude and rate of the base agree. A log in other units, or with columns or signs exchanged, is off by more than that.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gimbal_hil.data.signals import RigidBody, SignalsTable, body_rates
from sim_backend.model import AntennaModel

Floats = NDArray[np.float64]

#: everything is smoothed over this long, s: flexible parts, delays and lags act faster
_SMOOTHING_S = 0.05
#: and so rows are first put together to blocks of this length, s
_BLOCK_S = 0.01
#: an axis that moves by less than this share of its longest way in any log stands still: its rates are noise
_STANDS = 1e-3
#: share of the top speed above which friction has its full size
_SLOW = 0.02
#: powers of position that a torque may follow without the model knowing it: a weight, a spring, a cable
_POWERS = (1, 2, 3)
#: keeps columns that say the same apart
_RIDGE = 1e-10
#: rates of a base below this, rad/s, are standing still
_LEAST_RATE = 1e-3


@dataclass(frozen=True)
class ChannelEquation:
    """`target` (n,) is to be made of `columns` (n, k).

    A column of `known` size (k,) counts once, within a factor; one that is not known counts between `low` and `high`
    (k,) times, in units of that factor where they are finite.
    """

    target: Floats
    columns: Floats
    known: NDArray[np.bool_]
    low: Floats
    high: Floats

    def misfit(self, factor: float, gain: float = 1.0) -> float:
        """Share of the target's scatter (rms over rms) that the columns cannot make within a factor, 0 to 1 and above.

        With a `gain` the target is that many times what was logged.
        """
        from scipy.optimize import lsq_linear

        size, norms, corner = self._reduced
        used = norms > 0.0
        if size == 0.0 or not used.any():
            return 0.0
        k = int(np.count_nonzero(used))
        unit = norms[used] / (gain * size)
        low, high = (
            np.where(self.known, 1.0 / factor, factor * self.low)[used],
            np.where(self.known, factor, factor * self.high)[used],
        )
        found = lsq_linear(corner[:k, :k], corner[:k, k], (low * unit, high * unit), method="bvls")
        return float(np.sqrt((2.0 * found.cost + corner[k, k] ** 2) / len(self.target)))

    @cached_property
    def _reduced(self) -> tuple[float, Floats, Floats]:
        """Scatter of the target, norms of the columns, and the problem in as many rows as columns that are not zero,
        each over its norm, with the target behind them.
        """
        size = float(np.std(self.target))
        norms = np.linalg.norm(self.columns, axis=0)
        used = norms > 0.0
        if size == 0.0 or not used.any():
            return size, norms, np.zeros((0, 0))
        scaled = np.column_stack([self.columns[:, used] / norms[used], self.target / size])
        gram = scaled.T @ scaled
        return size, norms, np.linalg.cholesky(gram + _RIDGE * np.diag(np.diag(gram))).T


def channels_of(model: AntennaModel, tables: tuple[SignalsTable, ...]) -> dict[str, ChannelEquation]:
    """Channels by the column that they are about, over all tables; axes that do not move or are not driven give
    none.
    """
    parts: dict[str, list[ChannelEquation]] = {}
    body = RigidBody(model)
    travels = [[float(np.ptp(table.position(axis))) for axis in model.axes] for table in tables]
    least = _STANDS * np.max(travels, axis=0)
    for table, travel in zip(tables, travels, strict=True):
        for name, channel in _of_table(model, body, table, travel > least):
            parts.setdefault(name, []).append(channel)
    return {name: _joined(channels) for name, channels in parts.items()}


def _joined(channels: list[ChannelEquation]) -> ChannelEquation:
    first = channels[0]
    target = np.concatenate([channel.target for channel in channels])
    return replace(first, target=target, columns=np.concatenate([channel.columns for channel in channels]))


def _of_table(
    model: AntennaModel, rigid: RigidBody, table: SignalsTable, moves: NDArray[np.bool_]
) -> list[tuple[str, ChannelEquation]]:
    from scipy.ndimage import gaussian_filter1d

    width = max(2.0, _SMOOTHING_S / table.period_s)
    if len(table) < 20.0 * width:
        return []
    measured = np.column_stack([table.position(axis) for axis in model.axes])
    position, slope, bend = (np.asarray(gaussian_filter1d(measured, width, axis=0, order=order)) for order in (0, 1, 2))
    rate, acceleration = slope / table.period_s, bend / table.period_s**2
    body = rigid.along(table, position, rate)
    # ends know only one side; between, one row in a width says all that smoothing left
    rows = np.arange(int(4 * width), len(table) - int(4 * width), int(width))
    inertial = body.inertial(acceleration)
    found = []
    for i, axis in enumerate(model.axes):
        if not moves[i]:
            continue
        torque = np.asarray(gaussian_filter1d(table.torque(axis), width))
        if np.any(torque != 0.0):
            coulomb = model.number(axis, "friction.coulomb")
            motion = (position[rows, i], rate[rows, i], inertial[rows, i], -body.bias[rows, i])
            found.append((f"{axis}.torque", _torque_channel(torque[rows], motion, coulomb)))
        gyro = table.signal(axis, "rate")
        if gyro is not None and np.any(gyro != 0.0):
            seen = np.asarray(gaussian_filter1d(gyro, width))
            found.append(
                (
                    f"{axis}.rate",
                    _twice_measured(seen[rows], np.asarray(gaussian_filter1d(body.rate[:, i], width))[rows]),
                )
            )
    given, attitude = [table.base(name) for name in "pqr"], [table.base(name) for name in ("roll", "pitch", "yaw")]
    if any(x is not None for x in given) and any(x is not None for x in attitude):
        for name, column, derived in zip("pqr", given, body_rates(table).T, strict=True):
            if column is not None and max(np.abs(column).max(), np.abs(derived).max()) > _LEAST_RATE:
                smooth = (np.asarray(gaussian_filter1d(x, width))[rows] for x in (column, derived))
                found.append((f"base.{name}", _twice_measured(*smooth)))
    return found


def _torque_channel(torque: Floats, motion: tuple[Floats, Floats, Floats, Floats], coulomb: float) -> ChannelEquation:
    position, rate, inertial, load = motion
    top = float(np.abs(rate).max()) or 1.0
    place = (position - position.mean()) / (float(np.ptp(position)) or 1.0)
    columns = [
        inertial,
        load,
        np.tanh(rate / (_SLOW * top)),
        rate,
        np.ones_like(rate),
        *(place**power for power in _POWERS),
    ]
    known = np.arange(len(columns)) < 2
    # friction takes out of the motion, and a model that has any knows its size; without its detail it may be more
    # viscous
    low, high = np.full(len(columns), -np.inf), np.full(len(columns), np.inf)
    low[2:4], high[2] = 0.0, coulomb if coulomb > 0.0 else np.inf
    return ChannelEquation(torque, np.column_stack(columns), known, low, high)


def _twice_measured(one: Floats, other: Floats) -> ChannelEquation:
    columns = np.column_stack([other, np.ones_like(other)])
    return ChannelEquation(one, columns, np.array([True, False]), np.full(2, -np.inf), np.full(2, np.inf))


def in_blocks(table: SignalsTable) -> SignalsTable:
    """Means of a few rows each, torque as it acts about the samples: enough for channels, which are smoothed over more
    than that.
    """
    length = max(1, round(_BLOCK_S / table.period_s))
    count = len(table) // length
    columns = {f"{axis}.torque": _centred(table.torque(axis)) for axis in table.axes}
    columns |= {
        name: values
        for name, values in table.columns.items()
        if name not in columns and not name.endswith(".torque_known")
    }

    def means(values: Floats) -> Floats:
        return np.asarray(values[: count * length].reshape(count, length).mean(axis=1))

    if count < 2:
        return table
    return SignalsTable.of(
        table.axes, means(table.time_s), {n: means(x) for n, x in columns.items()}, None, table.source
    )


def _centred(held: Floats) -> Floats:
    """A held signal at t_k: the mean of the two values that meet there."""
    return np.append(held[:1], 0.5 * (held[1:] + held[:-1]))
