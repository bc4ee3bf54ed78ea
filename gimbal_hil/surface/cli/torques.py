"""Options that give a torque for an axis, `AXIS=TORQUE`."""

from __future__ import annotations

import math
from collections.abc import Sequence

from firmware_protocol.errors import BadInputError


def torques_by_axis(words: Sequence[str] | None, axes: Sequence[str], option: str = "--breakaway") -> dict[str, float]:
    """The torques (N m; N on a linear axis) by axis; BadInputError names the word that is none."""
    torques = {}
    for word in words or ():
        axis, _, number = word.partition("=")
        if axis not in axes:
            raise BadInputError(option, f"no axis {axis!r}", " or ".join(f"{name}=TORQUE" for name in axes))
        try:
            torques[axis] = float(number)
        except ValueError:
            torques[axis] = math.nan
        if not (math.isfinite(torques[axis]) and torques[axis] > 0.0):
            raise BadInputError(option, f"{number!r} is no torque", f"a positive number, as in {axis}=0.25")
    return torques
