"""Frequency responses of the loops as they are built, and what margin they keep.

One axis, linear: held and delayed torque, rigid body with structural modes, friction as a damper (sliding) or as
bristle spring and damper (stuck), the gyro's lag; the sampled law of the cascade, or of the observer and the loops that
it closes. All loops of an axis are cut at once where they meet, at the torque.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gimbal_hil.control import ObservedJoint

Response = NDArray[np.complex128]
Frequencies = NDArray[np.float64]


@dataclass(frozen=True)
class AxisDynamics:
    """What the torque of one axis moves, linear about a state."""

    inertia_kg_m2: float
    damping_nm_s: float
    #: of the bristles, while the joint is stuck; 0 while it slides
    stiffness_nm: float
    delay_s: float
    #: natural frequency (rad/s, 0 for an ideal one) and damping of the gyro's lag
    gyro_rad_s: float
    gyro_damping: float
    #: antiresonances (rad/s), damping and share of the inertia that hangs on each
    modes: tuple[tuple[float, float, float], ...] = ()

    def rate(self, w: Frequencies, step_s: float) -> Response:
        """Joint rate over torque, sampled and held."""
        s = 1j * w
        hung = sum(share for _, _, share in self.modes)
        moved = np.asarray((1.0 - hung) * self.inertia_kg_m2 * s, dtype=np.complex128)
        for frequency, damping, share in self.modes:
            spring = 2.0 * damping * frequency * s + frequency**2
            moved = moved + share * self.inertia_kg_m2 * s * spring / (s**2 + spring)
        hold = (1.0 - np.exp(-s * step_s)) / (s * step_s)
        late = np.exp(-s * self.delay_s)
        return np.asarray(hold * late / (moved + self.damping_nm_s + self.stiffness_nm / s))

    def gyro(self, w: Frequencies) -> Response:
        """Reading over rate."""
        if self.gyro_rad_s == 0.0:
            return np.ones(len(w), dtype=np.complex128)
        s, n = 1j * w, self.gyro_rad_s
        return np.asarray(n**2 / (s**2 + 2.0 * self.gyro_damping * n * s + n**2))

    def varied(self, inertia: float = 1.0, later_s: float = 0.0) -> AxisDynamics:
        """The same with another inertia and more delay."""
        return replace(self, inertia_kg_m2=inertia * self.inertia_kg_m2, delay_s=self.delay_s + later_s)


@dataclass(frozen=True)
class CascadeLaw:
    """Position PI over rate PI on the raw sensors: gains in 1/s, 1/s^2, N m s/rad, N m/rad."""

    step_s: float
    position_kp: float
    position_ki: float
    rate_kp: float
    rate_ki: float

    def torque(self, w: Frequencies, axis: AxisDynamics) -> Response:
        """Torque that comes back for a torque of one: the loop's transfer, negative feedback taken off."""
        z = np.exp(1j * w * self.step_s)
        rate = self.rate_kp + self.rate_ki * self.step_s / (z - 1.0)
        position = self.position_kp + self.position_ki * self.step_s / (z - 1.0)
        moved = axis.rate(w, self.step_s)
        return np.asarray(rate * moved * (axis.gyro(w) + position / (1j * w)))


@dataclass(frozen=True)
class ObservedLaw:
    """Position and rate gain on the estimates, and the disturbance taken off: gains in 1/s and N m s/rad."""

    joint: ObservedJoint
    gains: NDArray[np.float64]
    position_kp: float
    rate_kp: float
    #: inertia that the law believes in (kg m^2), and ticks of delay
    inertia_kg_m2: float
    delay_ticks: int

    def torque(self, w: Frequencies, axis: AxisDynamics) -> Response:
        """As `CascadeLaw.torque`."""
        moved = axis.rate(w, self.joint.step_s)
        encoder, gyro = self.accelerations(w)
        return np.asarray(self.inertia_kg_m2 * (encoder * moved / (1j * w) + gyro * moved * axis.gyro(w)))

    def accelerations(self, w: Frequencies) -> tuple[Response, Response]:
        """What the law answers, as an acceleration with its sign turned, to a reading of encoder and gyro."""
        T, d, A = self.joint.step_s, self.delay_ticks, self.joint.transition()
        K, H = self.gains, np.zeros((2, 6))
        H[0, 0] = H[1, 4] = 1.0
        kept = np.eye(6) - K @ H
        B = np.zeros(6)
        B[:2] = 0.5 * T * T, T
        lag = self.joint.gyro_lag
        B[4:] = (T, 0.0) if lag[0] == 0.0 else (0.5 * T * lag[4], 0.5 * T * lag[5])
        ahead = A[:3, :3]
        stiff = self.rate_kp / self.inertia_kg_m2
        k = np.array([stiff * self.position_kp, stiff, 1.0])
        later = k @ np.linalg.matrix_power(ahead, d)
        pending = [k @ np.linalg.matrix_power(ahead, i) @ B[:3] for i in range(d)]
        z = np.exp(1j * w * T)[:, None, None]
        inverse = np.linalg.inv(np.eye(6) - kept @ A / z)
        states = inverse @ K
        by_itself = (inverse @ (kept @ B)[:, None])[:, :, 0] * (z[:, :, 0] ** (-1 - d))
        own = 1.0 + by_itself[:, :3] @ later
        for i, share in enumerate(pending):
            own = own + share * z[:, 0, 0] ** (-1 - i)
        answered = np.einsum("i,nij->nj", later, states[:, :3, :]) / own[:, None]
        return answered[:, 0], answered[:, 1]


Law = CascadeLaw | ObservedLaw


def disk_margin(loop: Response) -> float:
    """Symmetric disk margin alpha of a loop transfer that is stable when closed: 2 / max |S - T| (Seiler, Packard and
    Gahinet 2020). Gain may change between (2 - alpha) / (2 + alpha) and its inverse, phase by 2 atan(alpha / 2).
    """
    return float(np.min(2.0 * np.abs((1.0 + loop) / (1.0 - loop))))


def encirclements(loop: Response) -> float:
    """Turns of 1 + L about zero over positive frequencies, from the lowest on: nearly 0 for a stable closed loop whose
    open one is stable but for integrators.
    """
    angle = np.unwrap(np.angle(1.0 + loop))
    return float((angle[-1] - angle[0]) / (2.0 * np.pi))


def margins(alpha: float) -> tuple[float, float]:
    """Gain (factor either way) and phase (deg) that a disk margin guarantees; infinite gain from alpha 2 on."""
    gain = (2.0 + alpha) / (2.0 - alpha) if alpha < 2.0 else np.inf
    return float(gain), float(2.0 * np.degrees(np.arctan(0.5 * alpha)))


def least_margin(law: Law, cases: Sequence[AxisDynamics], w: Frequencies) -> float:
    """Least disk margin over cases."""
    return min(disk_margin(law.torque(w, case)) for case in cases)


def compliance(law: Law, axis: AxisDynamics, w: Frequencies) -> float:
    """Largest joint angle (rad) that a disturbance torque of 1 N m leaves at any frequency."""
    undelayed = replace(axis, delay_s=0.0)
    moved = undelayed.rate(w, law.joint.step_s if isinstance(law, ObservedLaw) else law.step_s) / (1j * w)
    return float(np.max(np.abs(moved / (1.0 + law.torque(w, axis)))))
