"""Compiles every kernel once, so that no later command has to wait for one."""

from gimbal_hil.surface.warming.kernels import KERNELS, Kernel, ask_elsewhere

__all__ = ["KERNELS", "Kernel", "ask_elsewhere"]
