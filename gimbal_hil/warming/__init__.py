"""All compiled kernels asked for once, so that no later command has to wait for one."""

from gimbal_hil.warming.beside import ask_on_two_cores
from gimbal_hil.warming.kernels import KERNELS, Kernel

__all__ = ["KERNELS", "Kernel", "ask_on_two_cores"]
