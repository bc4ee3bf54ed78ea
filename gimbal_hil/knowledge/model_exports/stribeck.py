"""A Stribeck bump of any shape as the nearest one of a given shape."""

from __future__ import annotations

import numpy as np
from scipy.optimize import minimize_scalar

#: the bump's speeds over which the two are compared, from where it is whole to where nothing is left of it
_RATIOS = np.linspace(0.0, 6.0, 601)


def nearest_velocity(velocity: float, shape: float, wanted: float = 2.0) -> float:
    """Stribeck velocity with which exp(-(v/v_s)^wanted) is nearest to exp(-(v/velocity)^shape), in the mean of squares
    over speed.
    """
    if shape == wanted:
        return velocity
    bump = np.exp(-(_RATIOS**shape))
    found = minimize_scalar(
        lambda ratio: float(np.sum((np.exp(-((_RATIOS / ratio) ** wanted)) - bump) ** 2)),
        bounds=(0.05, 6.0),
        method="bounded",
    )
    return velocity * float(found.x)
