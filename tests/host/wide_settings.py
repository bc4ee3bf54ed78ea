"""The shipped configuration with limits that a program hardly reaches: for tests in which it is to go on."""

from __future__ import annotations

from gimbal_hil.loop.settings import DaemonSettings, settings_from_document, shipped_settings


def wide_settings() -> DaemonSettings:
    """Loops as shipped, guards wide or off."""
    document = shipped_settings().model_dump(mode="json", by_alias=True)
    for axis in document["axes"].values():
        axis["expectation"] = None
        axis["limits"] |= {"rate_rad_s": 14.0, "following_position_rad": None, "following_rate_rad_s": None}
        axis["limits"] |= {"gyro_encoder_rad_s": None, "gyro_encoder_rad": None, "stuck_gyro_ticks": None}
    return settings_from_document(document, "wide")
