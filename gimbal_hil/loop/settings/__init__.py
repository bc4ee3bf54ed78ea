"""Configuration of the daemon: validated once when it is read, then typed."""

from gimbal_hil.loop.settings.adjusting import (
    AdjustableNumber,
    Adjustments,
    adjustable_numbers,
    adjusted,
    adjustments_from,
    merged,
    require_adjustable,
    require_braking,
)
from gimbal_hil.loop.settings.axis import WIRE_TURNS, AxisSettings, JointObserver, Limits
from gimbal_hil.loop.settings.configuration import host_configuration
from gimbal_hil.loop.settings.daemon import (
    AxisNames,
    DaemonSettings,
    FirstTestChoice,
    load_settings,
    settings_from_document,
    with_changes,
)
from gimbal_hil.loop.settings.learning import learned_text
from gimbal_hil.loop.settings.link import EmbeddedAntenna
from gimbal_hil.loop.settings.model_control import delay_ticks, observed_joint
from gimbal_hil.loop.settings.shipped import shipped_settings, shipped_settings_path

__all__ = [
    "WIRE_TURNS",
    "AdjustableNumber",
    "Adjustments",
    "AxisNames",
    "AxisSettings",
    "DaemonSettings",
    "EmbeddedAntenna",
    "FirstTestChoice",
    "JointObserver",
    "Limits",
    "adjustable_numbers",
    "adjusted",
    "adjustments_from",
    "delay_ticks",
    "host_configuration",
    "learned_text",
    "load_settings",
    "merged",
    "observed_joint",
    "require_adjustable",
    "require_braking",
    "settings_from_document",
    "shipped_settings",
    "shipped_settings_path",
    "with_changes",
]
