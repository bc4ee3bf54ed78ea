"""Classical margins, read off the response of an open loop."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Response = NDArray[np.complex128]


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
