"""Mean torque of a joint that moves at a constant speed over a given stretch of its travel, with an honest standard
error.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gimbal_hil.knowledge.experiments.experiment import Row, Signals

Vector = NDArray[np.float64]
#: the speed has to be steady over this share of the stretch
STEADY_SHARE = 0.8
#: a sine over 75 degrees is such a polynomial to a millionth
_SMOOTH_DEGREE = 6


@dataclass(frozen=True)
class PlateauMean:
    """Mean over a stretch of travel; `steady` says that the tests of `find_steady_window` found constant speed over
    most of it. `jitter_rad_s` is how much the speed fluctuates, rms: friction that bends with speed shows a mean of its
    own then.
    """

    rate_rad_s: float
    torque_nm: float
    standard_error_nm: float
    jitter_rad_s: float
    effective_samples: float
    samples: int
    steady: bool

    def as_row(self) -> Row:
        """For the table of an experiment."""
        return {
            "rate_rad_s": self.rate_rad_s,
            "torque_nm": self.torque_nm,
            "standard_error_nm": self.standard_error_nm,
            "jitter_rad_s": self.jitter_rad_s,
            "effective_samples": self.effective_samples,
            "samples": self.samples,
            "steady": self.steady,
        }


def plateau_mean(signals: Signals, axis: str, low_rad: float, high_rad: float) -> PlateauMean | None:
    """Mean rate and commanded torque while the joint is between two positions; None when it hardly passes there.

    Both directions have to be measured between the *same* positions: whatever depends on position alone (gravity,
    cogging, a cable) is then the same in both means and cancels in half their difference. So the torque is that at
    the samples, not the one held after them, and its mean is taken over exactly the stretch asked for, not over the
    rows that happen to lie inside: both would be late by up to a row, forward and back in opposite directions. The
    standard error counts autocorrelation and leaves out the smooth dependence on position, which is no noise.
    """
    from gimbal_hil.knowledge.identification import centred_torque, find_steady_window, mean_with_error, rate_jitter

    position = signals[f"{axis}.position"]
    inside = np.flatnonzero((position >= low_rad) & (position <= high_rad))
    if len(inside) < 50:
        return None
    rows = slice(int(inside[0]), int(inside[-1]) + 1)
    time_s, place, torque = signals["time_s"][rows], position[rows], centred_torque(signals[f"{axis}.torque"])[rows]
    duration = float(time_s[-1] - time_s[0])
    window = find_steady_window(time_s, place)
    steady = window is not None and float(time_s[window.stop - 1] - time_s[window.start]) >= STEADY_SHARE * duration
    mean, smooth = _over_stretch(place, torque, low_rad, high_rad)
    estimate = mean_with_error(torque - smooth + mean)
    return PlateauMean(
        float(place[-1] - place[0]) / duration,
        mean,
        estimate.standard_error,
        rate_jitter(time_s, place),
        estimate.effective_samples,
        len(torque),
        bool(steady),
    )


def _over_stretch(position: Vector, torque: Vector, low_rad: float, high_rad: float) -> tuple[float, Vector]:
    """Mean over the stretch of a polynomial through torque over position, gravity over a short or long stretch, and
    its values at the rows. Legendre polynomials have no mean over the stretch but the first.
    """
    x = (2.0 * position - low_rad - high_rad) / (high_rad - low_rad)
    design = np.polynomial.legendre.legvander(x, _SMOOTH_DEGREE)
    coefficients = np.linalg.lstsq(design, torque, rcond=None)[0]
    return float(coefficients[0]), np.asarray(design @ coefficients)


@dataclass(frozen=True)
class DirectionPair:
    """Both directions at one speed over one stretch: half the difference is friction, half the sum depends on position
    alone. The speed fluctuates by `jitter_rad_s`, rms.
    """

    speed_rad_s: float
    jitter_rad_s: float
    friction_nm: float
    friction_error_nm: float
    positional_nm: float
    positional_error_nm: float
    steady: bool
    passes: int


def pooled(pairs: Sequence[DirectionPair]) -> DirectionPair:
    """Pairs of one speed, each over a stretch of its own, as one: gravity differs between stretches, friction should
    not.

    The scatter of friction between pairs counts where it is larger than their own errors.
    """
    count = len(pairs)
    frictions = [pair.friction_nm for pair in pairs]
    own = float(np.sqrt(np.sum([pair.friction_error_nm**2 for pair in pairs]))) / count
    between = float(np.std(frictions, ddof=1) / np.sqrt(count)) if count > 2 else 0.0
    return DirectionPair(
        float(np.mean([pair.speed_rad_s for pair in pairs])),
        float(np.mean([pair.jitter_rad_s for pair in pairs])),
        float(np.mean(frictions)),
        max(own, between),
        float(np.mean([pair.positional_nm for pair in pairs])),
        own,
        all(pair.steady for pair in pairs),
        sum(pair.passes for pair in pairs),
    )


def pair_of(forward: Sequence[Row], backward: Sequence[Row]) -> DirectionPair | None:
    """Passes of one speed and stretch in both directions as one pair; None when a direction is missing."""
    if not forward or not backward:
        return None
    ahead, ahead_error = _pooled(forward)
    back, back_error = _pooled(backward)
    rows = [*forward, *backward]
    error = 0.5 * float(np.hypot(ahead_error, back_error))
    return DirectionPair(
        float(np.mean([abs(row["rate_rad_s"]) for row in rows])),
        float(np.mean([row["jitter_rad_s"] for row in rows])),
        0.5 * (ahead - back),
        error,
        0.5 * (ahead + back),
        error,
        all(row["steady"] for row in rows),
        len(rows),
    )


def _pooled(rows: Sequence[Row]) -> tuple[float, float]:
    """Mean over passes; the scatter between passes counts where it is larger than their own errors."""
    torques = np.array([row["torque_nm"] for row in rows])
    own = float(np.sqrt(np.sum([row["standard_error_nm"] ** 2 for row in rows]))) / len(rows)
    between = float(np.std(torques, ddof=1) / np.sqrt(len(rows))) if len(rows) > 2 else 0.0
    return float(np.mean(torques)), max(own, between)
