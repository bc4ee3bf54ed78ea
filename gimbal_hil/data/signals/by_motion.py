"""Which columns of a file without names are time, position and torque of a joint: those that move as these do.

A torque is what the acceleration of a joint, its speed and the way it goes need together. A rate alone is made by the
speed, an acceleration by the acceleration: of neither both are needed.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import chain, permutations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

#: more columns are not tried in pairs; motion is smoothed over this long, s
_MOST, _SMOOTHING_S = 12, 0.03
#: periods of a log, s, and words of the unit of time in which one is
_SHORTEST_S, _LONGEST_S = 2e-5, 0.1
_UNITS = (("", 1.0), (":ms", 1e-3), (":us", 1e-6), (":ns", 1e-9))
#: a pair explains its torque when no more than this share of its rms is left, half of what any other pair leaves, and
#: leaves so many times more without its inertia, or without its friction, and this share of the torque
_LEFT, _HALF, _NEEDED, _SEEN = 0.4, 0.5, 1.5, 0.05
_SLOW = 0.02


def words_by_motion(columns: Mapping[str, Floats], axis: str) -> tuple[str, ...]:
    """Words for `--column`, position and torque in SI; none where no columns, or several, move so."""
    whole = {name: values for name, values in columns.items() if len(values) > 100 and np.all(np.isfinite(values))}
    word, period_s, of_time = next(chain(_clocks(whole), _clocks_in_parts(whole)), ("", 0.0, ()))
    moving = [name for name, values in whole.items() if np.ptp(values) > 0.0 and name not in of_time]
    if not word or not 2 <= len(moving) <= _MOST:
        return ()
    motions = {name: _motion(whole[name], period_s) for name in moving}
    torques = {name: _torque(whole[name], period_s) for name in moving}
    left = {(q, u): _left(motions[q], torques[u]) for q, u in permutations(moving, 2)}
    (position, torque), least = min(left.items(), key=lambda item: item[1])
    others = [one for pair, one in left.items() if pair != (position, torque)]
    if least > _LEFT or least > _HALF * min(others):
        return ()
    return f"time_s={word}", f"{axis}.position={position}", f"{axis}.torque={torque}"


def _clocks(whole: Mapping[str, Floats]) -> Iterator[tuple[str, float, tuple[str, ...]]]:
    """What `--column` says of a column that is the time, its period in seconds, and its name."""
    for name, values in whole.items():
        for unit, period_s in _clock(values):
            yield f"{name}{unit}", period_s, (name,)


def _clocks_in_parts(whole: Mapping[str, Floats]) -> Iterator[tuple[str, float, tuple[str, ...]]]:
    """The same of whole seconds in one column and the rest of a second in another, as ROS has them."""
    counts = {name: values for name, values in whole.items() if np.all(values == np.round(values))}
    for (name, seconds), (other, rest) in permutations(counts.items(), 2):
        for unit, size in _UNITS[1:]:
            if np.ptp(seconds) > 0.0 and rest.min() >= 0.0 and 0.5 <= size * rest.max() < 1.0:
                found = _clock(seconds - seconds[0] + size * rest)
                if found and found[0][0] == "":
                    yield f"{name}+{other}{unit}", found[0][1], (name, other)


def _clock(values: Floats) -> list[tuple[str, float]]:
    """The word for the unit of a column that rises evenly, and its period in seconds; none of a count of rows."""
    steps = np.diff(values)
    period = float(np.median(steps))
    if steps.min() <= 0.0 or np.ptp(steps) >= 0.5 * period or period == 1.0:
        return []
    found = [(unit, period * size) for unit, size in _UNITS if _SHORTEST_S <= period * size <= _LONGEST_S]
    return found[:1]


def _rows(count: int, period_s: float) -> tuple[float, slice]:
    """Width of the smoothing, rows, and the rows that are compared."""
    width = max(2.0, _SMOOTHING_S / period_s)
    edge = int(4 * width)
    return width, slice(edge, count - edge, max(1, int(width / 2)))


def _motion(position: Floats, period_s: float) -> tuple[Floats, ...]:
    """A column as a position: smoothed, its slope and its bend."""
    from scipy.ndimage import gaussian_filter1d

    width, rows = _rows(len(position), period_s)
    return tuple(gaussian_filter1d(position, width, order=order)[rows] for order in (0, 1, 2))


def _torque(torque: Floats, period_s: float) -> Floats:
    """A column as a torque that is held from row to row, smoothed as positions are."""
    from scipy.ndimage import gaussian_filter1d

    width, rows = _rows(len(torque), period_s)
    return np.asarray(gaussian_filter1d(np.append(torque[:1], 0.5 * (torque[1:] + torque[:-1])), width)[rows])


def _left(motion: tuple[Floats, ...], target: Floats) -> float:
    """Share of the torque's rms that inertia, friction and a curve over position leave; infinite where it is not made
    by both of the first two.
    """
    smooth, slope, bend = motion
    if len(target) < 40 or not np.ptp(slope) > 0.0 or not np.ptp(target) > 0.0:
        return float("inf")
    place = (smooth - smooth.mean()) / np.ptp(smooth)
    sign = np.tanh(slope / (_SLOW * float(np.max(np.abs(slope)))))
    columns = np.column_stack([bend, slope, sign, np.ones_like(slope), place, place**2, place**3])
    columns /= np.linalg.norm(columns, axis=0)
    solution, _, _, _ = np.linalg.lstsq(columns, target, rcond=1e-9)

    def without(*some: int) -> float:
        kept = [k for k in range(columns.shape[1]) if k not in some]
        rest = target - columns[:, kept] @ np.linalg.lstsq(columns[:, kept], target, rcond=1e-9)[0]
        return float(np.std(rest) / np.std(target))

    left = without()
    needed = max(_NEEDED * left, _SEEN)
    made_by_both = without(0) > needed and without(1, 2) > needed
    return left if solution[0] > 0.0 and solution[2] >= 0.0 and made_by_both else float("inf")
