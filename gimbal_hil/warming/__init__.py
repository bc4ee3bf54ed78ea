"""Compiles every kernel once, so that no later command has to wait for one."""

from gimbal_hil.warming.kernels import KERNELS, Kernel, ask_elsewhere

__all__ = ["KERNELS", "Kernel", "ask_elsewhere"]
