"""Configuration of mode `pointing`: when it is muted, how long gyros hold a direction, stow, which way is up."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import Field, model_validator

from firmware_protocol.documents import Strict
from gimbal_hil.loop.settings.axis import Positive
from sim_backend.boresight import Boresight


class Pointing(Strict):
    """A direction in space (mode `pointing`): when it is muted, how long gyros hold it, where the antenna is stowed."""

    mute_beyond_rad: Positive = Field(
        default=0.0087266, description="muted when the antenna looks further off than this (0.5 degrees)"
    )
    mute_below_rad: Positive = Field(
        default=0.0034907, description="no longer muted when it looks nearer than this (0.2 degrees)"
    )
    silence_s: Annotated[float, Field(gt=0.0, le=0.09)] = Field(
        default=0.05, description="muted without feedback for so long"
    )
    coast_time_s: Positive = Field(
        default=1.0,
        description="how long gyros hold a direction without attitude, after 0.1 s; then mute and stop",
    )
    stow_rad: tuple[float, float] = Field(
        default=(0.0, 0.0), description="joint positions in which the antenna is stowed, the carrying axis first"
    )
    boresight: Boresight | None = Field(
        default=None,
        description="axis of the inner body along which the antenna looks: x (a positive inner angle lowers it) or -x "
        "(raises it); without it what the model file says",
    )

    @model_validator(mode="after")
    def _hysteresis(self) -> Self:
        if self.mute_below_rad > self.mute_beyond_rad:
            raise ValueError("mute_below_rad: expected at most mute_beyond_rad")
        return self
