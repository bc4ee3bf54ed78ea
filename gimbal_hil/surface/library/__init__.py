"""For scripts and notebooks: runs, the virtual antenna, identification and the search, with results as objects.

`from gimbal_hil import Run, Antenna, identify, find_discrepancy` gives the same; nothing is loaded before it is used.
"""

from gimbal_hil.surface.library.antenna import Antenna
from gimbal_hil.surface.library.finding import Finding, Question, find_discrepancy, question_of
from gimbal_hil.surface.library.foreseeing import foresee
from gimbal_hil.surface.library.friction import Friction, identify
from gimbal_hil.surface.library.picture import Picture
from gimbal_hil.surface.library.run import Run
from gimbal_hil.surface.library.sources import Source

__all__ = [
    "Antenna",
    "Finding",
    "Friction",
    "Picture",
    "Question",
    "Run",
    "Source",
    "find_discrepancy",
    "foresee",
    "identify",
    "question_of",
]
