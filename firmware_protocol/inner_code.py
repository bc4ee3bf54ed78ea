"""What Numba makes of a function that only compiled functions call: code to link into them, and nothing else.

Numba would optimise such a function by itself, once more inside each function that calls it, and so on up to what
Python calls, and would turn every one of these into machine code that nobody runs. Here an inner function stays as it
was translated until the one that Python calls has them all in it: there they are optimised together and become machine
code, once (decision 0144).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from llvmlite.binding import parse_bitcode
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler


class InnerCompiler(Compiler):  # type: ignore[misc]
    """Numba's own steps, with a library that is only linked."""

    def compile_extra(self, function: Callable[..., object]) -> object:
        """See `Compiler`."""
        context = self.state.targetctx
        self.state.library = LinkedCode(context.codegen(), function.__qualname__)  # type: ignore[no-untyped-call]
        with uncounted(context):
            return super().compile_extra(function)  # type: ignore[no-untyped-call]


@contextmanager
def uncounted(context: Any) -> Iterator[None]:
    """While a function is compiled that counts no references.

    Numba translates what it has in Python itself, such as a sum, once a process: with reference counting where the
    first function that called it had that. Code with it needs Numba's library wherever it runs, so here these are kept
    apart.
    """
    counted, context.cached_internal_func = context.cached_internal_func, _UNCOUNTED
    try:
        yield
    finally:
        context.cached_internal_func = counted


_UNCOUNTED: dict[object, object] = {}


class _NoMachineCode:
    """In place of the engine that holds machine code, for a library that has none."""

    def set_env(self, name: str, environment: object) -> None:
        """Nothing here has the address of its environment to be told."""


class LinkedCode(JITCodeLibrary):  # type: ignore[misc]
    """A library that is linked into others and runs nowhere itself."""

    @classmethod
    def of(cls, codegen: Any, name: str, bitcode: bytes) -> LinkedCode:
        """What `as_bitcode` answered, as it was."""
        library = cls(codegen, name)  # type: ignore[no-untyped-call]
        library._final_module = parse_bitcode(bitcode)
        library._finalized = True
        return library

    def as_bitcode(self) -> bytes:
        """Everything that is linked in it."""
        self._ensure_finalized()  # type: ignore[no-untyped-call]
        return bytes(self._final_module.as_bitcode())

    @property
    def codegen(self) -> _NoMachineCode:
        return _NoMachineCode()

    def get_pointer_to_function(self, name: str) -> int:
        return 0

    def _optimize_final_module(self) -> None:
        pass

    def _finalize_final_module(self) -> None:
        self._finalized = True
