"""A frame of a CAN bus, whatever it carries: ours have eight bytes and a standard identifier, those of drives any."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class CanFrame:
    """One data frame; an FD frame may hold 64 bytes."""

    identifier: int
    data: bytes
    extended: bool = False
    fd: bool = False
