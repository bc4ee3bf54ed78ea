"""Waves over position in what a regression leaves: cogging and its kind, which no friction and no inertia explains.

They do not belong to the numbers that are asked for, but as residual they widen the intervals of all of them, and of
the shift between torque and motion most. Only waves that are clearly there count, and only such as pass the travel more
than once: a slower one is a spring or a weight, which a swing at one frequency cannot tell from inertia.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from gimbal_hil.knowledge.identification.averaging import Vector
from gimbal_hil.knowledge.identification.estimate import DataWarning

#: least waves over the travel, and how many tried orders lie in one wave over it
_LEAST_WAVES, _FINENESS = 2.0, 4
#: a wave counts where at most this share of the squares is left beside it, so that it is the larger part: a smaller one
#: costs two fifths of an interval's width at most, and may be what friction and its direction leave; so many at most
_LEFT, _MOST = 0.5, 3
#: orders tried at most, and how many rounds halve the distance between them
_MOST_TRIED, _ROUNDS = 1500, 12


@dataclass(frozen=True)
class PositionRipple:
    """A wave over position: `order` a turn (waves in 2 pi of position), how much of its sine and cosine there is, and
    the `centre` of the positions, about which its order is told from its phase.
    """

    order: float
    sine: float
    cosine: float
    centre: float

    @property
    def amplitude(self) -> float:
        """Its size."""
        return float(np.hypot(self.sine, self.cosine))

    def finding(self, axis: str, linear: bool) -> DataWarning:
        """What a reader must know of it."""
        size, where = (
            (f"{self.amplitude:.3g} N", f"every {2.0 * np.pi / self.order:.4g} m")
            if linear
            else (f"{self.amplitude:.3g} N m", f"{self.order:.4g} times a turn")
        )
        text = (
            f"the torque repeats over position, {size} {where}: the numbers were fitted beside it; what it is, "
            "gimbal-hil discrepancy says"
        )
        return DataWarning("repeats_over_position", text, axis)

    def columns(self, position: Vector) -> tuple[Vector, Vector, Vector]:
        """Sine and cosine at positions (n,), and what another order does: it is an unknown too."""
        angle = self.order * position
        wave = np.sin(angle), np.cos(angle)
        return *wave, (position - self.centre) * (self.sine * wave[1] - self.cosine * wave[0])

    def moved(self, solution: Vector) -> PositionRipple:
        """The wave where a fit of its columns leads, (3,)."""
        farthest = 0.1 * self.order
        order = self.order + float(np.clip(solution[2], -farthest, farthest))
        return replace(self, order=order, sine=float(solution[0]), cosine=float(solution[1]))


@dataclass(frozen=True)
class PositionSlope:
    """A torque that follows position within less than two waves over the travel: a spring or a cable, powers of the way
    from the `centre` over half the travel `reach`; or a weight, sine and cosine of the angle beside such a way. Each
    times one of `sizes`.
    """

    centre: float
    reach: float
    weight: bool = False
    sizes: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def finding(self, axis: str, linear: bool) -> DataWarning:
        """What a reader must know of it."""
        there = self.centre + self.reach * np.linspace(-1.0, 1.0, 101)
        size = float(np.ptp(np.column_stack(self.columns(there)) @ np.array(self.sizes)))
        text = (
            f"the torque follows position, by {size:.3g} {'N' if linear else 'N m'} over the travel, as under a weight "
            "or a spring: the numbers were fitted beside it, and no offset can be told from it; what it is, gimbal-hil "
            "discrepancy says"
        )
        return DataWarning("follows_position", text, axis)

    def columns(self, position: Vector) -> tuple[Vector, Vector, Vector]:
        """What each size is multiplied by at positions (n,)."""
        way = (position - self.centre) / self.reach
        return (way, np.sin(position), np.cos(position)) if self.weight else (way, way**2, way**3)

    def moved(self, solution: Vector) -> PositionSlope:
        """The same with the sizes of a fit of its columns, (3,)."""
        first, second, third = (float(size) for size in solution)
        return replace(self, sizes=(first, second, third))


def slopes_over(position: Vector, linear: bool) -> tuple[PositionSlope, ...]:
    """The slopes that are looked for over the travel of positions (n,)."""
    reach = 0.5 * float(np.ptp(position))
    kinds = (False,) if linear else (False, True)
    return tuple(PositionSlope(float(np.mean(position)), reach, weight) for weight in kinds) if reach > 0.0 else ()


def ripples_of(residual: Vector, position: Vector, fastest_order: float) -> tuple[PositionRipple, ...]:
    """Waves in a residual (n,) at positions (n,), the largest first, up to an order that the filters leave."""
    travel = float(np.ptp(position))
    if not travel > 0.0:
        return ()
    step = 2.0 * np.pi / travel / _FINENESS
    orders = np.arange(_LEAST_WAVES * 2.0 * np.pi / travel, fastest_order, step)[:_MOST_TRIED]
    found: list[PositionRipple] = []
    left = residual
    while len(found) < _MOST and len(orders):
        best = float(orders[int(np.argmin(_leaves(left, position, orders)))])
        order = _finest(left, position, best, step, float(orders[0]))
        columns = np.column_stack([np.sin(order * position), np.cos(order * position)])
        solution = np.linalg.lstsq(columns, left, rcond=None)[0]
        further = left - columns @ solution
        if further @ further > _LEFT * (left @ left):
            break
        found.append(PositionRipple(order, float(solution[0]), float(solution[1]), float(np.mean(position))))
        left = further
    return tuple(found)


def _leaves(residual: Vector, position: Vector, orders: Vector) -> Vector:
    """Squares that a wave of each order leaves, (k,), sine and cosine taken as if they were orthogonal."""
    waves = np.exp(1j * np.outer(orders, position))
    return np.asarray(residual @ residual - 2.0 * np.abs(waves @ residual) ** 2 / len(residual))


def _finest(residual: Vector, position: Vector, order: float, step: float, least: float) -> float:
    """The order near one that leaves least."""
    for _ in range(_ROUNDS):
        step *= 0.5
        near = np.array([order - step, order, order + step])
        order = max(least, float(near[int(np.argmin(_leaves(residual, position, near)))]))
    return order


OverPosition = PositionRipple | PositionSlope
