"""Asks for the kernels that are named, and prints the seconds of each: the second process of `ask_on_two_cores`."""

from __future__ import annotations

import sys

from gimbal_hil.warming.beside import ask, kernels_named

if __name__ == "__main__":
    ask(kernels_named(sys.argv[1:]), lambda kernel, took_s: print(took_s, flush=True))
