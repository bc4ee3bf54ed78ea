"""Which loops and which virtual antenna a command without a daemon works with."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from gimbal_hil.loop.settings import DaemonSettings
    from sim_backend.model import AntennaModel


def settings_and_antenna(config: Path | None, model: str | None) -> tuple[DaemonSettings, AntennaModel]:
    """Settings of `--config`, else the shipped ones; the antenna of `--model`, else the configuration's own, else the
    one for judging controllers. Settings have its axes and know which way is up.
    """
    from gimbal_hil.knowledge.experiments import embedded_model_of
    from gimbal_hil.loop.settings import load_settings, shipped_settings
    from sim_backend.model import CONTROL_ANTENNA, model_named

    settings = load_settings(config) if config else shipped_settings()
    if model is not None or config is None:
        antenna = model_named(model or CONTROL_ANTENNA)
    else:
        antenna, _ = embedded_model_of(settings)
    return settings.for_axes(antenna.axes, antenna.where).looking(antenna), antenna
