"""The loop closed: experiment, diagnose, correct, until the model is at the noise floor or nothing more can be said."""

from gimbal_hil.improvement.loop import Ending, Improvement, improve

__all__ = ["Ending", "Improvement", "improve"]
