"""The antenna in three dimensions: the script that draws it on a canvas, for the live page and for reports."""

from gimbal_hil.pages.antenna.script import ANTENNA_SCRIPT

__all__ = ["ANTENNA_SCRIPT"]
