"""Measured rigs of other people as a stranger would bring them: signals tables (CSV) and a first model (YAML) in a
folder.

What the data are and what is known of them stands in the SOURCE.md beside them. A test that asks for a rig whose data
are not there is skipped; `GIMBAL_HIL_DATA` says where they are.
"""

from tests.rigs.bam import write_bam
from tests.rigs.data import data_folder
from tests.rigs.dd2dof import write_dd2dof
from tests.rigs.emps import write_emps
from tests.rigs.odrive import write_odrive
from tests.rigs.rig import Rig

__all__ = ["Rig", "data_folder", "write_bam", "write_dd2dof", "write_emps", "write_odrive"]
