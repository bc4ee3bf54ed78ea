"""Where the antenna is: embedded in this process, or behind a link."""

from __future__ import annotations

from pydantic import Field

from gimbal_hil.settings.axis import Strict


class Embedded(Strict):
    """The virtual antenna in this process: a model file (or the name of a shipped one) and the seed of its noise."""

    model: str = "thesis"
    seed: int = Field(default=1, ge=0, lt=2**31)


class EmbeddedAntenna(Strict):
    """`link: {embedded: {model: ..., seed: ...}}`."""

    embedded: Embedded = Embedded()

    @property
    def can_bitrate(self) -> int | None:
        """Bit rate of the CAN bus that limits the tick rate; None, since there is none."""
        return None


LinkSettings = EmbeddedAntenna
