"""Configuration of the daemon: validated once at the door, typed inside."""

from gimbal_hil.settings.axis import WIRE_TURNS, AxisSettings
from gimbal_hil.settings.configuration import host_configuration
from gimbal_hil.settings.daemon import AxisNames, DaemonSettings, FirstTestChoice, load_settings, settings_from_document
from gimbal_hil.settings.link import EmbeddedAntenna
from gimbal_hil.settings.shipped import shipped_settings, shipped_settings_path

__all__ = [
    "WIRE_TURNS",
    "AxisNames",
    "AxisSettings",
    "DaemonSettings",
    "EmbeddedAntenna",
    "FirstTestChoice",
    "host_configuration",
    "load_settings",
    "settings_from_document",
    "shipped_settings",
    "shipped_settings_path",
]
