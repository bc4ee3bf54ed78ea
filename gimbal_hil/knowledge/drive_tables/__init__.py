"""A model's ripple and friction as tables that the drives of other makes take, tried on simulated drives."""

from gimbal_hil.knowledge.drive_tables.friction import FrictionFeed, FrictionTable, friction_table
from gimbal_hil.knowledge.drive_tables.makes import MAKES
from gimbal_hil.knowledge.drive_tables.motor import DriveOfAxis, Motor
from gimbal_hil.knowledge.drive_tables.rehearsal import Rehearsed, rehearse
from gimbal_hil.knowledge.drive_tables.ripple import RippleTable, ripple_table
from gimbal_hil.knowledge.drive_tables.tables import AxisTables, drive_tables

__all__ = [
    "MAKES",
    "AxisTables",
    "DriveOfAxis",
    "FrictionFeed",
    "FrictionTable",
    "Motor",
    "Rehearsed",
    "RippleTable",
    "drive_tables",
    "friction_table",
    "rehearse",
    "ripple_table",
]
