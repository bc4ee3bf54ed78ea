"""Frequency responses of the loops as they are built: sampled law, held torque, delay, gyro lag, rigid axis with
friction.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Response = NDArray[np.complex128]


@dataclass(frozen=True)
class Axis:
    """One axis as the loop sees it; friction linearised: viscous while sliding, bristle spring and damper while
    stuck.
    """

    inertia: float
    damping: float
    stiffness: float = 0.0


def gyro(w: NDArray[np.float64], bandwidth_hz: float, damping: float = 0.7) -> Response:
    """Second-order lag."""
    s, w0 = 1j * w, 2 * np.pi * bandwidth_hz
    return w0**2 / (s**2 + 2 * damping * w0 * s + w0**2)


def pi(w: NDArray[np.float64], kp: float, ki: float, step_s: float) -> Response:
    """The sampled PI: integral after the output."""
    return kp + ki * step_s / (np.exp(1j * w * step_s) - 1.0)


def torque_to_rate(w: NDArray[np.float64], axis: Axis, step_s: float, delay_ticks: float) -> Response:
    """Held torque, delayed, to the axis' rate."""
    s = 1j * w
    hold = (1.0 - np.exp(-s * step_s)) / (s * step_s)
    return hold * np.exp(-s * step_s * delay_ticks) / (axis.inertia * s + axis.damping + axis.stiffness / s)


def phase_margin_deg(w: NDArray[np.float64], loop: Response) -> tuple[float, float]:
    """Least phase margin over all crossings of unit gain, and the highest such frequency (rad/s); infinite without
    one.
    """
    size = np.abs(loop)
    at = np.flatnonzero((size[:-1] - 1.0) * (size[1:] - 1.0) <= 0.0)
    if not len(at):
        return np.inf, 0.0
    margins = 180.0 + np.degrees(np.angle(loop[at]))
    margins = np.where(margins > 180.0, margins - 360.0, margins)
    return float(np.min(np.abs(margins))), float(w[at[-1]])


def gain_margin_db(w: NDArray[np.float64], loop: Response) -> float:
    """Gain by which the loop may grow before it reaches -1."""
    crosses = np.flatnonzero((loop.imag[:-1] * loop.imag[1:] < 0) & (loop.real[:-1] < 0) & (w[:-1] > 1.0))
    sizes = np.abs(loop[crosses])
    sizes = sizes[sizes < 1.0]
    return float(-20 * np.log10(sizes.max())) if len(sizes) else np.inf
