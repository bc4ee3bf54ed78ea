"""For scripts and notebooks: runs, the virtual antenna, identification and the search, with results as objects.

`from gimbal_hil import Run, Antenna, identify, find_discrepancy` gives the same; nothing is loaded before it is used.
"""

from gimbal_hil.surface.library.antenna import Antenna
from gimbal_hil.surface.library.arm_joint import joint_of_arm
from gimbal_hil.surface.library.changing import Changes, changes_between, find_changes
from gimbal_hil.surface.library.finding import Finding, Question, find_discrepancy, question_of
from gimbal_hil.surface.library.foreseeing import foresee
from gimbal_hil.surface.library.friction import Friction, identify
from gimbal_hil.surface.library.picture import Picture
from gimbal_hil.surface.library.run import Run
from gimbal_hil.surface.library.search_scope import SearchScope
from gimbal_hil.surface.library.sources import Source

__all__ = [
    "Antenna",
    "Changes",
    "Finding",
    "Friction",
    "Picture",
    "Question",
    "Run",
    "SearchScope",
    "Source",
    "changes_between",
    "find_changes",
    "find_discrepancy",
    "foresee",
    "identify",
    "joint_of_arm",
    "question_of",
]
