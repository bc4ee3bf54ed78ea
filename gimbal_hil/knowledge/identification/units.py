"""What an axis is measured in."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Units:
    """What an axis is measured in: `torque` and `angle`, and the word for the torque."""

    torque: str
    angle: str
    word: str

    @property
    def rate(self) -> str:
        """Unit of the joint rate."""
        return f"{self.angle}/s"


ROTARY, LINEAR = Units("N m", "rad", "torque"), Units("N", "m", "force")
