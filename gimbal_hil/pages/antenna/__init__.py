"""The antenna in three dimensions: the scripts that draw it on a canvas, for the live page and for reports."""

from gimbal_hil.pages.antenna.script import ANTENNA_SCRIPT, MOTION_SCRIPT

__all__ = ["ANTENNA_SCRIPT", "MOTION_SCRIPT"]
