"""Names of the formats; nothing heavy is loaded here, because the command line's help needs them."""

from __future__ import annotations

from enum import StrEnum


class ModelFormat(StrEnum):
    """Whose format a model is written in."""

    MJCF = "mjcf"
    URDF = "urdf"
    ISAAC = "isaac"
    BAM = "bam"
    CSV = "csv"
    FMU = "fmu"
