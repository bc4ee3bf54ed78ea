"""Physical bounds and contradictions: numbers that violate a bound, and data that disagree with each other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from gimbal_hil.knowledge.identification.averaging import Vector
from gimbal_hil.knowledge.identification.estimate import DataWarning
from gimbal_hil.knowledge.identification.presliding import PreslidingRun
from gimbal_hil.knowledge.identification.sliding import MapHalf, StaticFit
from gimbal_hil.knowledge.identification.stribeck import LugreFriction
from gimbal_hil.knowledge.identification.velocity_map import VelocityPoint

#: break-away is where the tangent stiffness has fallen to this share of the small-torque stiffness
_STIFFNESS_LEFT = 0.05
#: neighbouring speeds within this factor must agree within this many joint errors and this share of the torque
_NEAR_SPEED, _FAR_ERRORS, _FAR_SHARE = 1.25, 5.0, 0.12
#: speeds of a direction from which on the lowest sliding torque says where its curve has its lowest place
_FEWEST_SPEEDS = 4


@dataclass(frozen=True)
class BreakAway:
    """Signed torque at which a slow ramp left presliding."""

    label: str
    torque: float


def break_away(run: PreslidingRun, sigma0: float, encoder_step: float) -> BreakAway | None:
    """Torque at which the tangent stiffness dT/dq of a slow ramp falls for good below a twentieth of sigma0; None when
    it never does.

    Slopes are taken between points that lie at least ten encoder steps apart, so that one step of the encoder does not
    decide.
    """
    rows = _spaced_rows(run.position, 10.0 * max(encoder_step, 1e-12))
    if len(rows) < 4:
        return None
    travel, torque = np.diff(run.position[rows]), np.diff(run.friction[rows])
    soft = torque / travel < _STIFFNESS_LEFT * sigma0
    for index in range(len(soft) - 1):
        if soft[index] and soft[index + 1]:
            return BreakAway(run.label, float(run.friction[rows[index]]))
    return None


def _spaced_rows(position: Vector, spacing: float) -> np.ndarray:
    chosen, last = [0], float(position[0])
    for row, value in enumerate(position.tolist()):
        if abs(value - last) >= spacing:
            chosen.append(row)
            last = value
    return np.array(chosen)


def points_at_rest(found: Sequence[BreakAway], points: Sequence[VelocityPoint]) -> tuple[VelocityPoint, ...]:
    """Break-away as a point of the velocity map for each direction with two ramps or more, at a tenth of the slowest
    speed of `points`.
    """
    slowest = min(abs(point.rate) for point in points)
    at_rest = []
    for sign in (1.0, -1.0):
        ramps = [one for one in found if one.torque * sign > 0.0]
        if len(ramps) > 1:
            torques = np.array([one.torque for one in ramps])
            error = float(np.std(torques, ddof=1) / np.sqrt(len(ramps)))
            labels = tuple(one.label for one in ramps)
            at_rest.append(
                VelocityPoint(
                    sign * 0.1 * slowest, float(np.mean(torques)), error, 0.0, len(ramps), labels, float(len(ramps))
                )
            )
    return tuple(at_rest)


def break_away_findings(found: Sequence[BreakAway], static: StaticFit, axis: str = "") -> tuple[DataWarning, ...]:
    """A contradiction for each direction whose break-away torque lies below its Coulomb torque.

    LuGre, and every Stribeck curve, needs Ts at or above Tc. When ramps break away lower than the sliding torque
    extrapolated to rest, no parameters can describe both experiments: they are reported side by side and not fitted
    through.
    """
    findings = []
    sides = {MapHalf.POSITIVE: (1.0,), MapHalf.NEGATIVE: (-1.0,), MapHalf.BOTH: (1.0, -1.0)}[static.direction]
    coulomb = next(e for e in static.estimates if e.name == "coulomb")
    for side in sides:
        torques = np.array([abs(b.torque) for b in found if b.torque * side > 0.0])
        if len(torques) == 0:
            continue
        if _highest_mean(torques) < coulomb.interval.low:
            way = "positive" if side > 0.0 else "negative"
            text = (
                f"{way} direction: {len(torques)} ramps break away at {np.mean(torques):.4g} on average "
                f"({torques.min():.4g} to {torques.max():.4g}), but sliding needs {coulomb.fitted_text} "
                f"({coulomb.interval_text}) however slow: the two experiments contradict each other, "
                "and no friction curve is fitted through both"
            )
            findings.append(DataWarning("break_away_below_coulomb", text, axis))
    return tuple(findings)


def break_away_below_sliding(
    found: Sequence[BreakAway], points: Sequence[VelocityPoint], axis: str = ""
) -> tuple[DataWarning, ...]:
    """A contradiction for each direction whose ramps break away below every torque at which it slid, however slow or
    fast.

    Every Stribeck curve begins at Ts, so its lowest torque is at most Ts. This needs no fit, and says something where
    the plateaus do not hold one.
    """
    findings = []
    for side, way in ((1.0, "positive"), (-1.0, "negative")):
        torques = np.array([abs(b.torque) for b in found if b.torque * side > 0.0])
        sliding = [
            abs(p.torque) - 2.0 * p.standard_error for p in points if p.rate * side > 0.0 and p.torque * side > 0.0
        ]
        if len(torques) == 0 or len(sliding) < _FEWEST_SPEEDS:
            continue
        if _highest_mean(torques) < min(sliding):
            text = (
                f"{way} direction: {len(torques)} ramps break away at {np.mean(torques):.4g} on average "
                f"({torques.min():.4g} to {torques.max():.4g}), but sliding needs at least {min(sliding):.4g} at each "
                f"of {len(sliding)} "
                "speeds: the two experiments contradict each other, and no friction curve is fitted through both"
            )
            findings.append(DataWarning("break_away_below_sliding", text, axis))
    return tuple(findings)


def _highest_mean(torques: np.ndarray) -> float:
    """Upper end of the mean break-away torque; a single ramp is believed to a fifth."""
    spread = float(np.std(torques, ddof=1)) if len(torques) > 1 else 0.1 * float(torques[0])
    return float(np.mean(torques)) + 2.0 * spread / float(np.sqrt(len(torques)))


def repeatability_findings(points: Sequence[VelocityPoint], axis: str = "") -> tuple[DataWarning, ...]:
    """Neighbouring speeds of one direction whose torques differ by far more than their errors: the runs were not made
    alike.
    """
    findings = []
    for a, b in pairwise(points):
        same_way = a.rate * b.rate > 0.0
        near = same_way and max(abs(a.rate), abs(b.rate)) < _NEAR_SPEED * min(abs(a.rate), abs(b.rate))
        gap = abs(a.torque - b.torque)
        if (
            near
            and gap > _FAR_ERRORS * np.hypot(a.standard_error, b.standard_error)
            and gap > _FAR_SHARE * abs(a.torque)
        ):
            text = (
                f"at {a.rate:.4g} and {b.rate:.4g} rad/s the mean torque is {a.torque:.4g} and {b.torque:.4g}, "
                f"{gap / np.hypot(a.standard_error, b.standard_error):.0f} standard errors apart ({a.labels[0]}; "
                f"{b.labels[0]})"
            )
            findings.append(DataWarning("not_repeatable", text, axis))
    return tuple(findings)


def physical_findings(friction: LugreFriction, axis: str = "", unit: str = "N m s/rad") -> tuple[DataWarning, ...]:
    """Violated bounds of a parameter set: break-away under Coulomb, and passivity `sigma2 > sigma1 (Ts - Tc) / Tc`."""
    static = friction.static
    findings = []
    if static.breakaway < static.coulomb:
        taken = "the model takes Ts = Tc" if friction.sigma0 > 0.0 else "friction falls towards standstill"
        text = f"break-away {static.breakaway:.4g} is below Coulomb {static.coulomb:.4g}: no Stribeck bump, {taken}"
        findings.append(DataWarning("breakaway_below_coulomb_in_fit", text, axis, frozenset({"breakaway"})))
    limit = static.largest_sigma1()
    if friction.sigma1 > limit:
        text = (
            f"bristle damping {friction.sigma1:.3g} {unit} makes a LuGre model non-passive, so it can give out energy "
            f"(limit {limit:.3g} {unit}; none where the damping falls with speed)"
        )
        findings.append(DataWarning("not_passive", text, axis, frozenset({"sigma1", "viscous"})))
    return tuple(findings)
