"""Numbers that an antenna can have: friction that holds, bodies that exist, every number within the catalogue's
bounds.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from gimbal_hil.knowledge.discrepancy.twin.number_slots import read_number, write_number
from sim_backend import layout
from sim_backend.model import AntennaModel, ModelKind

#: where a body that would not exist is led back to what the model states: halvings of the way
_HALVINGS = 40
#: what a moment may be short of by rounding, as a share of the largest: the model's own check allows as much
_SLACK = 1e-10

Bounds = Mapping[tuple[str, str], tuple[float, float]]


def keep_within(model: AntennaModel, P: NDArray[np.float64], bounds: Bounds) -> None:
    """Hold numbers ((axis, path) -> low, high) within their bounds, whatever several causes made of them together."""
    for (axis, path), (low, high) in bounds.items():
        value = read_number(model, P, axis, path)
        if not low <= value <= high:
            write_number(model, P, axis, path, min(max(value, low), high))


def keep_physical(model: AntennaModel, P: NDArray[np.float64], stated: NDArray[np.float64]) -> None:
    """Friction and bodies that exist; `stated` are the parameters as the model has them, where they do."""
    for i in range(len(model.axes)):
        _keep_friction(P, layout.axis_block(i))
        if model.kind is ModelKind.GIMBAL:
            first = (layout.INERTIA_OUTER, layout.INERTIA_INNER)[i]
            _keep_body(P[first : first + 6], stated[first : first + 6])


def _keep_friction(P: NDArray[np.float64], block: int) -> None:
    if P[block + layout.TC] > 0.0 or P[block + layout.TS] > 0.0:
        P[block + layout.TC] = max(P[block + layout.TC], 1e-9)
        # a map without a bristle may also dip towards standstill; a bristle then had nothing to break away from
        least = 0.05 * P[block + layout.TC]
        P[block + layout.TS] = max(P[block + layout.TS], least)
    P[block + layout.SIGMA2] = max(P[block + layout.SIGMA2], 0.0)


def _keep_body(tensor: NDArray[np.float64], stated: NDArray[np.float64]) -> None:
    """Lead an inertia tensor (xx, yy, zz, xy, xz, yz) back towards the stated one until a body can have it: a convex
    set.
    """
    if np.array_equal(tensor, stated) or _exists(tensor):
        return
    wanted, kept = tensor.copy(), 0.0
    for k in range(1, _HALVINGS + 1):
        trial = kept + 0.5**k
        if _exists(stated + trial * (wanted - stated)):
            kept = trial
    tensor[:] = stated + kept * (wanted - stated)


def _exists(tensor: NDArray[np.float64]) -> bool:
    """Whether some distribution of mass has these moments: all positive, none above the sum of the others."""
    xx, yy, zz, xy, xz, yz = tensor
    moments = np.linalg.eigvalsh(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]))
    slack = _SLACK * float(moments[2])
    return bool(moments[0] > 0.0 and moments[0] + moments[1] >= moments[2] - slack)
