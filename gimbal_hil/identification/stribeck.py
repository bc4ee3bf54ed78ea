"""The steady friction curve of the LuGre model, `F(v) = Tc + (Ts - Tc) exp(-(v / vs)^delta) + sigma2 v`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gimbal_hil.identification.averaging import Vector


@dataclass(frozen=True)
class StaticFriction:
    """Parameters of the steady curve: torques in N m (N on a linear axis), speeds in rad/s (m/s).

    `breakaway` is Ts, `coulomb` Tc, `stribeck_velocity` vs, `viscous` sigma2, `shape` delta of thesis eq. 4.2 with the erratum
    `exp(-(|v|/vs)^delta)`.
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

    def largest_sigma1(self) -> float:
        """Largest micro-damping sigma1 with which the model stays passive, `sigma2 Tc / (Ts - Tc)`, infinite without a Stribeck bump."""
        bump = self.breakaway - self.coulomb
        return self.viscous * self.coulomb / bump if bump > 0.0 else float("inf")


def stribeck_bump(speed: Vector, stribeck_velocity: float, shape: float) -> Vector:
    """`exp(-(|v| / vs)^delta)`, 1 at rest and 0 far above the Stribeck velocity."""
    ratio = np.maximum(np.abs(speed) / stribeck_velocity, 1e-300)
    return np.asarray(np.exp(-np.minimum(ratio**shape, 700.0)))
