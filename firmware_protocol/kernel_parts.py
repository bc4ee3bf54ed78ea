"""Parts of kernels that are kept on disk by themselves: translated once for all kernels that have them in them, and by
another process meanwhile where there is a processor for it.

Three fifths of the time in which a kernel is compiled go into translating it, in Python and on one processor. The host
and the antenna take about as long as each other, and neither needs the other before they are linked (decision 0144).
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from typing import Any

from numba.core.compiler import Compiler, CompileResult

from firmware_protocol.inner_code import LinkedCode
from firmware_protocol.interpreter import apart_from_the_users_folder
from firmware_protocol.kernel_cache import KernelCache


class PartCache(KernelCache):
    """The cache of a kernel, for a function that is only linked; `elsewhere` is a process that is filling it."""

    elsewhere: subprocess.Popen[bytes] | None = None

    class _impl_class(KernelCache._impl_class):
        def reduce(self, found: Any) -> tuple[object, ...]:
            """What is kept: code to link, and what Numba says of it."""
            found.fndesc.typemap = found.fndesc.calltypes = None  # large, and of no use to those that call it
            library = found.library
            return library.name, library.as_bitcode(), found.fndesc, found.environment, found.signature

        def rebuild(self, target: Any, kept: tuple[Any, ...]) -> CompileResult:
            """See `CompileResultCacheImpl`."""
            name, bitcode, described, environment, signature = kept
            library = LinkedCode.of(target.codegen(), name, bitcode)
            empty: dict[str, Any] = dict.fromkeys(CompileResult._fields)
            return CompileResult(
                **empty
                | {
                    "target_context": target,
                    "typing_context": target.typing_context,
                    "library": library,
                    "environment": environment,
                    "entry_point": target.get_executable(library, described, environment),
                    "fndesc": described,
                    "signature": signature,
                    "objectmode": False,
                    "lifted": (),
                    "reload_init": (),
                    "referenced_envs": (),
                }
            )

    def load_overload(self, types: Any, target: Any) -> CompileResult | None:
        """See `Cache`; waits for what is on its way."""
        if self.elsewhere is not None:
            self.elsewhere.wait()
            self.elsewhere = None
        return super().load_overload(types, target)  # type: ignore[no-untyped-call]

    def begin_elsewhere(self, types: tuple[object, ...], target: Any) -> None:
        """Have the function translated for arguments of these types by another process, unless that was done."""
        if (os.cpu_count() or 1) < 2 or self.load_overload(types, target) is not None:
            return
        module, name = self._py_func.__module__, self._py_func.__name__
        program = f"from {module} import {name} as part; part.translate()"
        nowhere = subprocess.DEVNULL
        words = [sys.executable, "-c", program]
        with apart_from_the_users_folder():
            self.elsewhere = subprocess.Popen(words, stdin=nowhere, stdout=nowhere, stderr=nowhere)


def compiler_beginning_with(begin: Callable[[], None]) -> type[Compiler]:
    """Numba's own steps, and something to be begun before them; not called for what is on disk."""

    class BeginningCompiler(Compiler):  # type: ignore[misc]
        def compile_extra(self, function: Callable[..., object]) -> object:
            begin()
            return super().compile_extra(function)  # type: ignore[no-untyped-call]

    return BeginningCompiler
