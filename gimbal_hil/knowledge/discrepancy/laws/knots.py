"""Knots of a curve, and the columns that give the effect of its values on the residual."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gimbal_hil.knowledge.discrepancy.laws.shape import LawShape, direction, variables
from gimbal_hil.knowledge.discrepancy.twin import TORQUE, Floats, Record, Twin, scored, scoring_reach
from sim_backend.model import ActsOn, Over

#: knots over rates lie closer where they are small: the last is this far along a hyperbolic sine
_CLOSER = 3.0
#: of the rows this share lies outside the knots at either end: a single row is no end
_ENDS = 0.00005
#: places at which a curve's bend is looked at, and the part of knots that is spread evenly, beside one of the bend's
_GRID, _EVEN = 2000, 0.3
Knots = tuple[tuple[float, ...], ...]


@dataclass(frozen=True)
class RangeSeen:
    """A shape's variables along all records, (n,) each per record, and directions where it has one."""

    shape: LawShape
    columns: list[tuple[Floats, ...]]
    directions: list[Floats]
    #: of every record, how much of it its first half of rows that count sees
    halves: tuple[int, ...] = ()

    @classmethod
    def of(cls, shape: LawShape, records: tuple[Record, ...], axis: int) -> RangeSeen:
        """Along these records."""
        turned = shape.by_direction or shape.acts_on is ActsOn.FRICTION
        return cls(
            shape,
            variables(shape, records, axis),
            [direction(shape, record, axis) for record in records] if turned else [],
            tuple(_half(record) for record in records),
        )

    def selecting(self, which: int, fitted: int) -> list[Floats]:
        """A variable along the first `fitted` records and the first half of the others, which may select."""
        along = [columns[which] for columns in self.columns]
        return along[:fitted] + [one[:n] for one, n in zip(along[fitted:], self.halves[fitted:], strict=True)]

    def range_of(self, which: int, fitted: int) -> tuple[float, float]:
        """What of a variable was seen in what may select."""
        low, high = np.quantile(np.concatenate(self.selecting(which, fitted)), [_ENDS, 1.0 - _ENDS])
        return float(low), float(high)


def _half(record: Record) -> int:
    rows = record.rows
    return int(rows[len(rows) // 2]) + scoring_reach(record.bands)


def knots_of(over: Over, low: float, high: float, count: int) -> tuple[float, ...]:
    """So many knots from low to high."""
    along = np.linspace(0.0, 1.0, count)
    if over in (Over.SPEED, Over.RECENT_SPEED, Over.LOAD):
        return tuple(low + (high - low) * np.sinh(_CLOSER * along) / np.sinh(_CLOSER))
    if over in (Over.RATE, Over.TORQUE):
        side = np.sinh(_CLOSER * (2.0 * along - 1.0)) / np.sinh(_CLOSER)
        return tuple(0.5 * (low + high) + 0.5 * (high - low) * side)
    return tuple(np.linspace(low, high, count))


def knots_where_it_bends(knots: tuple[float, ...], curves: list[Floats], count: int) -> tuple[float, ...]:
    """So many knots over the same range, closer where curves through these ones bend: as the cube root of how much,
    beside a part that is spread evenly.
    """
    from scipy.interpolate import CubicSpline

    x = np.linspace(knots[0], knots[-1], _GRID)
    bends = sum(np.abs(CubicSpline(knots, values, bc_type="natural")(x, 2)) for values in curves)
    dense = np.cbrt(bends)
    dense = dense / max(float(np.mean(dense)), 1e-300) + _EVEN
    along = np.concatenate([[0.0], np.cumsum(0.5 * (dense[1:] + dense[:-1]))])
    return tuple(float(at) for at in np.interp(np.linspace(0.0, along[-1], count), along, x))


def basis(x: Floats, knots: tuple[float, ...]) -> Floats:
    """What one at each knot and zero at the others makes of x, (n, knots); outside the knots as at the last one."""
    from scipy.interpolate import CubicSpline

    x = np.clip(x, knots[0], knots[-1])
    if len(knots) == 2:
        t = (x - knots[0]) / (knots[1] - knots[0])
        return np.column_stack([1.0 - t, t])
    return np.asarray(CubicSpline(knots, np.eye(len(knots)), bc_type="natural")(x))


def bends_of(shape: LawShape, knots: Knots, factor: Factor | None = None) -> Floats:
    """By how much a law bends at its knots, (places, values), in the unit of its values."""
    if factor is not None:
        return _bends(knots[1 - factor.which])
    if len(knots) == 2:
        first, second = (np.eye(len(part)) for part in knots)
        return np.vstack([np.kron(_bends(knots[0]), second), np.kron(first, _bends(knots[1]))])
    one = _bends(knots[0])
    return np.asarray(np.kron(np.eye(2), one)) if shape.by_direction else one


def _bends(knots: tuple[float, ...]) -> Floats:
    """Of neighbours that are three: slope after less slope before, times the shorter way."""
    found = np.zeros((max(len(knots) - 2, 0), len(knots)))
    for k, (a, b, c) in enumerate(zip(knots, knots[1:], knots[2:], strict=False)):
        before, after = min(b - a, c - b) / (b - a), min(b - a, c - b) / (c - b)
        found[k, k : k + 3] = before, -before - after, after
    return found


def _straight(x: Floats, knots: tuple[float, ...]) -> Floats:
    return np.column_stack([np.interp(x, knots, unit) for unit in np.eye(len(knots))])


@dataclass(frozen=True)
class Factor:
    """One of two variables by its place, and what a product of two curves answers at its knots."""

    which: int
    values: Floats

    def spread(self, other: Floats) -> Floats:
        """Values of the surface whose other curve has these, the second variable's fastest."""
        both = (self.values, other) if self.which == 0 else (other, self.values)
        return np.outer(*both).ravel()


def columns_of(
    twin: Twin, records: tuple[Record, ...], seen: RangeSeen, knots: Knots, floor: float, factor: Factor | None = None
) -> Floats:
    """What one at each knot does to the torque residual of the shape's axis, in floors, (rows that count, values); with
    a factor at each knot of the other variable.
    """
    shape, found = seen.shape, []
    channel = next(j for j, c in enumerate(twin.channels) if (c.axis, c.signal) == (shape.axis, TORQUE))
    stiffness, damping = (twin.model.number(shape.axis, f"friction.{name}") for name in ("sigma0", "sigma1"))
    lead_s = damping / stiffness if stiffness > 0.0 else 0.0
    for which, record in enumerate(records):
        each = seen.columns[which]
        if len(each) == 2:
            parts = [_straight(x, part) for x, part in zip(each, knots, strict=True)]
            if factor is None:
                wide = (parts[0][:, :, None] * parts[1][:, None, :]).reshape(len(parts[0]), -1)
            else:
                wide = (parts[factor.which] @ factor.values)[:, None] * parts[1 - factor.which]
        else:
            wide = basis(each[0], knots[0])
        if shape.by_direction:
            turned = seen.directions[which][:, None]
            wide = np.hstack([0.5 * (1.0 + turned) * wide, 0.5 * (1.0 - turned) * wide])
        elif shape.acts_on is ActsOn.FRICTION:
            # a level that changes moves the bristles, and their damping answers to that
            moved = lead_s * np.asarray(np.gradient(wide, record.bands.period_s, axis=0))
            wide = -seen.directions[which][:, None] * (wide + moved)
        rows = scored(wide, record.bands)[record.keep]
        found.append(rows if twin.scales is None else rows / twin.scales[which][:, channel : channel + 1])
    return np.concatenate(found) / floor
