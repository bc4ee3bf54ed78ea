"""The rigid bodies of an arm, read from a URDF by pinocchio: torques of a motion, inertia seen by a joint."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.documents import require_regular
from firmware_protocol.errors import BadInputError

Floats = NDArray[np.float64]
_EXPECTED = "a URDF with masses and inertias of its links"


@dataclass(frozen=True)
class Arm:
    """`joints` are those that move, in the order of the columns of a motion."""

    path: Path
    joints: tuple[str, ...]
    _model: Any

    def torques(self, position: Floats, rate: Floats, acceleration: Floats) -> Floats:
        """Torques (forces) that rigid links ask for along a motion, shapes (rows, joints) in and out: the recursive
        Newton-Euler equations, gravity 9.81 m/s^2 along -z of the base, no friction.
        """
        import pinocchio

        data = self._model.createData()
        found = np.empty_like(position)
        for row, q in enumerate(self._configurations(position)):
            found[row] = pinocchio.rnea(self._model, data, q, rate[row], acceleration[row])
        return found

    def inertia(self, position: Floats, joint: str) -> float:
        """Inertia (mass) that a joint moves in one position (joints,), the others held."""
        import pinocchio

        place = self.joints.index(joint)
        found = pinocchio.crba(self._model, self._model.createData(), self._configurations(position[None, :])[0])
        return float(found[place, place])

    def _configurations(self, position: Floats) -> Floats:
        """Pinocchio's coordinates, (rows, nq): a joint without ends is the cosine and the sine of its angle."""
        columns: list[Floats] = []
        for place, joint in enumerate(list(self._model.joints)[1:]):
            angle = position[:, place]
            columns += [angle] if joint.nq == 1 else [np.cos(angle), np.sin(angle)]
        return np.stack(columns, axis=1)


def arm_of_urdf(path: Path) -> Arm:
    """The arm in a URDF file; BadInputError for a file that is none, and where pinocchio is not installed."""
    require_regular(path, _EXPECTED)
    if not path.is_file():
        raise BadInputError(str(path), "no such file", _EXPECTED)
    try:
        import pinocchio
    except ImportError:
        raise BadInputError(
            str(path), "a URDF needs the package pin, which is not installed", "pip install 'gimbal-hil[urdf]'"
        ) from None
    try:
        model = pinocchio.buildModelFromXML(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, RuntimeError, ValueError) as error:
        raise BadInputError(str(path), f"is no URDF: {' '.join(str(error).split())}", _EXPECTED) from error
    joints = tuple(model.names)[1:]
    if not joints or any(joint.nv != 1 for joint in list(model.joints)[1:]):
        raise BadInputError(
            str(path), "has no joints, or one of several degrees of freedom", "joints that turn or slide"
        )
    return Arm(path, joints, model)
