"""Frequency responses of the loops as they are built, and what margin they keep.

One axis, linear: held and delayed torque, rigid body with structural modes, friction as a damper (sliding) or as
bristle spring and damper (stuck), the gyro's lag; the sampled law of the cascade, or of the observer and the loops that
it closes. All loops of an axis are cut at once where they meet, at the torque.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gimbal_hil.loop.control import ObservedJoint

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

    def with_sensing(self, gyro_rad_s: float, modes: tuple[tuple[float, float, float], ...]) -> AxisDynamics:
        """The same with another gyro and other modes."""
        return replace(self, gyro_rad_s=gyro_rad_s, modes=modes)


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

    def answers(self, w: Frequencies) -> tuple[Response, Response]:
        """Torque with its sign turned that a reading of encoder (N m/rad) and gyro (N m s/rad) asks for."""
        z = np.exp(1j * w * self.step_s)
        rate = self.rate_kp + self.rate_ki * self.step_s / (z - 1.0)
        return rate * (self.position_kp + self.position_ki * self.step_s / (z - 1.0)), rate


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
    #: what it answers as an acceleration at the frequencies in question, where somebody has it already
    answered: tuple[Response, Response] | None = None

    def torque(self, w: Frequencies, axis: AxisDynamics) -> Response:
        """As `CascadeLaw.torque`."""
        moved = axis.rate(w, self.joint.step_s)
        encoder, gyro = self.answers(w)
        return np.asarray(encoder * moved / (1j * w) + gyro * moved * axis.gyro(w))

    def answers(self, w: Frequencies) -> tuple[Response, Response]:
        """As `CascadeLaw.answers`."""
        encoder, gyro = self.answered or self.accelerations(w)
        return self.inertia_kg_m2 * encoder, self.inertia_kg_m2 * gyro

    def accelerations(self, w: Frequencies, filtered: FilterResponse | None = None) -> tuple[Response, Response]:
        """What the law answers, as an acceleration with its sign turned, to a reading of encoder and gyro; `filtered`
        is the response of its observer, where somebody has it already.
        """
        filtered = filtered or filter_response(self.joint, self.gains, w)
        stiff = self.rate_kp / self.inertia_kg_m2
        k = np.array([stiff * self.position_kp, stiff, 1.0])
        ahead, torque = self.joint.transition()[:3, :3], torque_input(self.joint)
        later = k @ np.linalg.matrix_power(ahead, self.delay_ticks)
        z = np.exp(1j * w * self.joint.step_s)
        own = 1.0 + (filtered.by_itself @ later) * z ** (-1 - self.delay_ticks)
        for i in range(self.delay_ticks):
            own = own + (k @ np.linalg.matrix_power(ahead, i) @ torque[:3]) * z ** (-1 - i)
        answered = np.einsum("i,nij->nj", later, filtered.readings) / own[:, None]
        return answered[:, 0], answered[:, 1]


@dataclass(frozen=True)
class FilterResponse:
    """What an observer makes of its inputs at frequencies (n): joint position, rate and disturbance over a reading of
    encoder and gyro (n, 3, 2), and over a torque as an acceleration, once it acts (n, 3).
    """

    readings: Response
    by_itself: Response


def filter_response(joint: ObservedJoint, gains: NDArray[np.float64], w: Frequencies) -> FilterResponse:
    """Response of the observer with these gains (6, 2)."""
    A, measured = joint.transition(), np.zeros((2, 6))
    measured[0, 0] = measured[1, 4] = 1.0
    kept = np.eye(6) - gains @ measured
    z = np.exp(1j * w * joint.step_s)[:, None, None]
    inverse = np.linalg.inv(np.eye(6) - kept @ A / z)
    readings, by_itself = inverse @ gains, inverse @ (kept @ torque_input(joint))[:, None]
    return FilterResponse(
        np.asarray(readings[:, :3], dtype=np.complex128), np.asarray(by_itself[:, :3, 0], dtype=np.complex128)
    )


def torque_input(joint: ObservedJoint) -> NDArray[np.float64]:
    """What an acceleration over a tick adds to the observer's states (6,)."""
    T, lag = joint.step_s, joint.gyro_lag
    ideal = lag[0] == 0.0
    return np.array([0.5 * T * T, T, 0.0, 0.0, *((T, 0.0) if ideal else (0.5 * T * lag[4], 0.5 * T * lag[5]))])


@dataclass(frozen=True, eq=False)
class SampledLaw:
    """Any sampled linear law: states and torque (N m) from the errors of position (rad) and inertial rate (rad/s)."""

    step_s: float
    A: NDArray[np.float64]
    B: NDArray[np.float64]
    C: NDArray[np.float64]
    D: NDArray[np.float64]
    #: what it answers at the frequencies in question, where somebody has it already
    answered: tuple[Response, Response] | None = None

    def torque(self, w: Frequencies, axis: AxisDynamics) -> Response:
        """As `CascadeLaw.torque`."""
        moved, (encoder, gyro) = axis.rate(w, self.step_s), self.answers(w)
        return np.asarray(moved * (encoder / (1j * w) + gyro * axis.gyro(w)))

    def answers(self, w: Frequencies) -> tuple[Response, Response]:
        """As `CascadeLaw.answers`."""
        if self.answered is not None:
            return self.answered
        z = np.exp(1j * w * self.step_s)[:, None, None]
        found = self.C @ np.linalg.solve(z * np.eye(len(self.A)) - self.A, self.B[None].astype(np.complex128)) + self.D
        return np.asarray(found[:, 0, 0], np.complex128), np.asarray(found[:, 0, 1], np.complex128)


Law = CascadeLaw | ObservedLaw | SampledLaw


def disk_margin(loop: Response) -> float:
    """Symmetric disk margin alpha of a loop transfer that is stable when closed: 2 / max |S - T| (Seiler, Packard and
    Gahinet 2020). Gain may change between (2 - alpha) / (2 + alpha) and its inverse, phase by 2 atan(alpha / 2).
    """
    return float(np.min(2.0 * np.abs((1.0 + loop) / (1.0 - loop))))


def encirclements(loop: Response) -> float:
    """Turns of 1 + L about zero over positive frequencies, from the lowest on. For a stable closed loop whose open one
    is stable but for integrators it is a quarter for each of these: 1 + L comes from far away, where they turned it by
    so much, to nearly 1.
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


#: where an aircraft shakes an antenna and its navigation comes too late
GUSTS_HZ = (1.0, 12.0)


@dataclass(frozen=True)
class Disturbances:
    """What moves an axis off its reference: a torque that walks (N m in a root second), a gyro that walks against joint
    and base rate (rad/s in a root second; what the navigation is wrong by is in it), one standard deviation of a
    sample of encoder (rad) and gyro (rad/s), and a torque of gusts (N m rms, even over `GUSTS_HZ`), which comes sooner
    than a navigation that is 5 to 15 ms old tells of it.
    """

    torque_walk_nm: float
    gyro_walk_rad_s: float
    encoder_noise_rad: float
    gyro_noise_rad_s: float
    gust_nm: float = 0.0


@dataclass(frozen=True)
class Errors:
    """What a law leaves of an axis' pointing, rms in rad, for each of the disturbances."""

    torque_rad: float
    gyro_walk_rad: float
    noise_rad: float
    gust_rad: float
    #: torque that the noise asks for, N m rms
    noise_nm: float

    @property
    def rms(self) -> float:
        """All together."""
        return math.hypot(self.torque_rad, self.gyro_walk_rad, self.noise_rad, self.gust_rad)


def errors(law: Law, axis: AxisDynamics, w: Frequencies, given: Disturbances) -> Errors:
    """Errors of an axis under a law that is stable on it.

    White samples have the spectrum sigma^2 T up to half the rate, a walk sigma^2 / w^2; both two-sided, integrated over
    `w`.
    """
    step_s = law.joint.step_s if isinstance(law, ObservedLaw) else law.step_s
    loop, (encoder, gyro) = law.torque(w, axis), law.answers(w)
    left = 1.0 / (1.0 + loop)
    moved = np.abs(axis.rate(w, step_s) / (1j * w) * left)
    at_once = np.abs(replace(axis, delay_s=0.0).rate(w, step_s) / (1j * w) * left)

    def rms(density: Frequencies) -> float:
        return math.sqrt(float(np.trapezoid(density, w)) / math.pi)

    noise = (given.encoder_noise_rad * np.abs(encoder)) ** 2 + (given.gyro_noise_rad_s * np.abs(gyro)) ** 2
    return Errors(
        given.torque_walk_nm * rms((at_once / w) ** 2),
        given.gyro_walk_rad_s * rms((moved * np.abs(gyro) / w) ** 2),
        rms(moved**2 * noise * step_s),
        given.gust_nm * _over_band(moved, w),
        rms(np.abs(left) ** 2 * noise * step_s),
    )


def _over_band(moved: Frequencies, w: Frequencies) -> float:
    """Error (rad rms) of a torque of 1 N m rms that is even over the band of gusts."""
    low, high = (2.0 * math.pi * end for end in GUSTS_HZ)
    inside = (w >= low) & (w <= high)
    return math.sqrt(float(np.trapezoid(moved[inside] ** 2, w[inside])) / (high - low))


def crossing_rad_s(loop: Response, w: Frequencies) -> float:
    """Highest frequency at which a loop's gain is one; 0 where it never is."""
    above = np.flatnonzero(np.abs(loop) >= 1.0)
    return float(w[above[-1]]) if len(above) else 0.0
