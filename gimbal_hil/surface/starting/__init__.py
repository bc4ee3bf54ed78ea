"""A user's own antenna from a few numbers: configuration, model, plan and a page of next commands."""

from gimbal_hil.surface.starting.description import (
    AntennaDescription,
    AxisDescription,
    LinkChoice,
    parse_link,
    usual_axis,
    usual_boresight,
    usual_names,
    usual_tilt_deg,
)
from gimbal_hil.surface.starting.on_link import settings_on_link
from gimbal_hil.surface.starting.readme import first_command
from gimbal_hil.surface.starting.writing import write_antenna

__all__ = [
    "AntennaDescription",
    "AxisDescription",
    "LinkChoice",
    "first_command",
    "parse_link",
    "settings_on_link",
    "usual_axis",
    "usual_boresight",
    "usual_names",
    "usual_tilt_deg",
    "write_antenna",
]
