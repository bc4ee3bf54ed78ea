"""Which way is up for a gimbal: where its antenna looks in the axes of the inner body, z of the outer one being up."""

from __future__ import annotations

from enum import StrEnum


class Boresight(StrEnum):
    """Where an antenna looks, in the axes of its inner body: ahead along x, so that a positive inner angle lowers it
    (right hand about y), or along minus x, so that a positive one raises it.
    """

    AHEAD = "x"
    ASTERN = "-x"

    @property
    def sign(self) -> float:
        """Of the boresight along x."""
        return 1.0 if self is Boresight.AHEAD else -1.0

    @property
    def raises(self) -> str:
        """Which inner angles look up, in words."""
        return "negative" if self is Boresight.AHEAD else "positive"
