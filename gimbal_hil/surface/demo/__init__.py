"""The whole workflow on the virtual antenna, in a few stages and one page."""

from gimbal_hil.surface.demo.story import STAGES, Stage, tell

__all__ = ["STAGES", "Stage", "tell"]
