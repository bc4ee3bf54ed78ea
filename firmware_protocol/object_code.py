"""A compiled law as an object file that a linker takes: machine code that needs neither Python nor Numba.

The code is what Numba makes for this process, emitted once more for the plainest processor of this architecture:
without fast-math and without fused operations the bits of the results are the same.
"""

from __future__ import annotations

import platform
import re
from collections.abc import Callable
from typing import Any

import llvmlite.binding as llvm
from numba.core.registry import CPUDispatcher

from firmware_protocol.errors import BadInputError
from firmware_protocol.inner_code import uncounted

_OPTIONS: dict[str, Any] = {
    "error_model": "numpy",
    "_nrt": False,
    "nopython": True,
    "boundscheck": None,
    "no_cpython_wrapper": True,
    "no_cfunc_wrapper": True,
}
#: the plainest processor of an architecture that is still sold
_PLAINEST = {"x86_64": "x86-64-v2", "aarch64": "generic"}


def object_code(function: Callable[..., object], types: tuple[object, ...], symbol: str) -> bytes:
    """ELF object in which `symbol` is a plain Python function compiled for arguments of these Numba types.

    It is called as Numba calls: `int symbol(result *, void **raised, arguments)`, where an array of one dimension is
    (meminfo, parent, items, item size, data, shape, stride); nonzero says that it raised. BadInputError for
    architectures other than x86-64 and 64-bit ARM.
    """
    processor = _PLAINEST.get(platform.machine())
    if processor is None:
        raise BadInputError(platform.machine(), "is an architecture nobody tried this on", " or ".join(_PLAINEST))
    kernel: Any = CPUDispatcher(function, targetoptions=_OPTIONS)
    with uncounted(kernel.targetctx):
        kernel.compile(types)
    (made,) = kernel.overloads.values()
    module = llvm.parse_assembly(_without_names(made.library.get_llvm_str()))
    module.get_function(made.fndesc.llvm_func_name).name = symbol
    machine = llvm.Target.from_default_triple().create_target_machine(cpu=processor, opt=3, reloc="pic")
    return bytes(machine.emit_object(module))


def _without_names(assembly: str) -> str:
    """Without the attributes that tie functions to the processor of this machine."""
    return re.sub(r'"target-(cpu|features)"="[^"]*"', "", assembly)
