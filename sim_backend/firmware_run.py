"""Whose firmware answers in front of the plant; in a module of its own, because nothing is compiled to say so."""

from __future__ import annotations

from enum import StrEnum


class FirmwareRun(StrEnum):
    """The firmware of a virtual antenna, and how it is run."""

    #: the Python device, compiled with the plant
    VIRTUAL = "virtual"
    #: the C device as a library of this machine
    LIBRARY = "c"
    #: the C device as Cortex-M4 machine code in this process
    MACHINE_CODE = "cortex-m"
    #: the image of a whole board in QEMU, its UART spoken to
    BOARD = "qemu"
