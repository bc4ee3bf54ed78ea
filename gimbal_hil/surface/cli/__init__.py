"""The command line: one file a command, nothing heavy imported before it is needed."""

from gimbal_hil.surface.cli.app import main

__all__ = ["main"]
