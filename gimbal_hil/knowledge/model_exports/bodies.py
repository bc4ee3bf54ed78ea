"""Bodies of a model as other simulators want them: the tensor about the centre of mass."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim_backend.model import AntennaModel, ModelKind

#: kg: what a body weighs that states no mass, small against everything and large enough for a solver
_NO_MASS_KG = 1e-6


@dataclass(frozen=True)
class Body:
    """Mass in kg, centre of mass (3,) in m from the pivot, tensor (3, 3) in kg m2 about the centre of mass."""

    mass_kg: float
    cog_m: NDArray[np.float64]
    tensor_kg_m2: NDArray[np.float64]

    @property
    def six(self) -> tuple[float, ...]:
        """xx, yy, zz, xy, xz, yz of the tensor."""
        return tuple(float(self.tensor_kg_m2[i, j]) for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)))


def body_of(model: AntennaModel, axis: str) -> Body:
    """The body that an axis carries. A model states tensors about the pivot (Steiner's rule takes them to the centre
    of mass); a single rotary axis states the moment about its axis alone, and gets the same about the two others.
    """
    mass = model.number(axis, "body.mass") or _NO_MASS_KG
    cog = np.array([model.number(axis, f"body.cog.{k}") for k in "xyz"])
    if model.kind is ModelKind.LINEAR:
        return Body(mass, np.zeros(3), np.eye(3) * mass * 1e-4)
    off = mass * (cog @ cog * np.eye(3) - np.outer(cog, cog))
    xx, yy, zz, xy, xz, yz = (model.number(axis, f"body.inertia.{k}") for k in ("xx", "yy", "zz", "xy", "xz", "yz"))
    if model.kind is ModelKind.ROTARY:
        return Body(mass, cog, np.eye(3) * (zz - off[2, 2]))
    return Body(mass, cog, np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) - off)


def direction_of(model: AntennaModel, axis: str) -> str:
    """The axis of a joint in its body: azimuth about z, elevation about y, one rotary axis about z, a slide along x."""
    if model.kind is ModelKind.LINEAR:
        return "1 0 0"
    return "0 1 0" if model.kind is ModelKind.GIMBAL and model.axes.index(axis) == 1 else "0 0 1"


def gravity_of(model: AntennaModel) -> str:
    """Gravity in the base's axes, m/s^2: down for a gimbal; against y or the slide for one that leans."""
    g = model.file.gravity_m_s2
    if model.kind is ModelKind.GIMBAL:
        return f"0 0 {-g:.17g}"
    along = -g * model.file.incline_sine
    return f"{along:.17g} 0 0" if model.kind is ModelKind.LINEAR else f"0 {along:.17g} 0"
