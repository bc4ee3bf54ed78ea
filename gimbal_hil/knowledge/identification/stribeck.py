"""LuGre friction as identification sees it: all seven numbers, and `F(v) = Tc + (Ts - Tc) exp(-(v / vs)^delta) + sigma2
v`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from gimbal_hil.knowledge.identification.averaging import Vector

#: order of the seven parameters wherever they stand in one array
LUGRE_NAMES = ("breakaway", "coulomb", "stribeck_velocity", "viscous", "shape", "sigma0", "sigma1")
LUGRE_UNITS = ("N m", "N m", "rad/s", "N m s/rad", "1", "N m/rad", "N m s/rad")


@dataclass(frozen=True)
class StaticFriction:
    """Parameters of the steady curve: torques in N m (N on a linear axis), speeds in rad/s (m/s).

    `breakaway` is Ts, `coulomb` Tc, `stribeck_velocity` vs, `viscous` sigma2, `shape` delta of thesis eq. 4.2 with the
    erratum `exp(-(|v|/vs)^delta)`.
    """

    breakaway: float
    coulomb: float
    stribeck_velocity: float
    viscous: float
    shape: float

    def torque(self, speed: Vector) -> Vector:
        """Friction torque at positive speeds, shape (n,), opposing the motion."""
        bump = stribeck_bump(speed, self.stribeck_velocity, self.shape)
        return np.asarray(self.coulomb + (self.breakaway - self.coulomb) * bump + self.viscous * speed)

    def torque_with_jitter(self, speed: Vector, jitter: Vector) -> Vector:
        """Mean friction torque at positive mean speeds that fluctuate by `jitter` (rms, both (n,)), faster than
        bristles settle.

        In the mean `0 = v - sigma0 z E[|v| / g(|v|)]`: the bristles bend by `v / E[|v| / g]` instead of `g(v)`, a
        little less. The mean is taken with three Gauss-Hermite nodes.
        """
        bent = np.zeros_like(speed)
        for node, weight in ((-np.sqrt(3.0), 1.0 / 6.0), (0.0, 2.0 / 3.0), (np.sqrt(3.0), 1.0 / 6.0)):
            moved = np.abs(speed + node * jitter)
            bent += weight * moved / (self.torque(moved) - self.viscous * moved)
        return np.asarray(speed / bent + self.viscous * speed)

    def largest_sigma1(self) -> float:
        """Largest micro-damping sigma1 with which the model stays passive, `sigma2 Tc / (Ts - Tc)`, infinite without a
        Stribeck bump.
        """
        bump = self.breakaway - self.coulomb
        return self.viscous * self.coulomb / bump if bump > 0.0 else float("inf")


def stribeck_bump(speed: Vector, stribeck_velocity: float, shape: float) -> Vector:
    """`exp(-(|v| / vs)^delta)`, 1 at rest and 0 far above the Stribeck velocity."""
    ratio = np.maximum(np.abs(speed) / stribeck_velocity, 1e-300)
    return np.asarray(np.exp(-np.minimum(ratio**shape, 700.0)))


@dataclass(frozen=True)
class LugreFriction:
    """All seven LuGre parameters: the steady curve, bristle stiffness (N m/rad) and bristle damping (N m s/rad)."""

    static: StaticFriction
    sigma0: float
    sigma1: float

    def values(self) -> Vector:
        """The seven numbers in the order of LUGRE_NAMES."""
        s = self.static
        return np.array([s.breakaway, s.coulomb, s.stribeck_velocity, s.viscous, s.shape, self.sigma0, self.sigma1])

    def with_values(self, names: tuple[str, ...], values: Vector) -> LugreFriction:
        """The same friction with some numbers replaced."""
        known = dict(zip(names, (float(v) for v in values), strict=True))
        static = {name: known[name] for name in LUGRE_NAMES[:5] if name in known}
        return LugreFriction(
            replace(self.static, **static), known.get("sigma0", self.sigma0), known.get("sigma1", self.sigma1)
        )
