"""Numba behind two decorators, with a disk cache that cannot go stale.

`compiled` marks a function that is inlined into what calls it; `entry_point` marks one that Python calls, kept on disk
under a key made of the content of every source file it can reach (its own module and what that imports from this
project, and effect plug-ins), so an edited law is never run from an old binary. With NUMBA_DISABLE_JIT=1 the same
functions run as plain Python.
"""

from __future__ import annotations

from collections.abc import Callable
from types import FunctionType
from typing import Any, TypeVar, cast

import numba
from numba.core.registry import CPUDispatcher

from firmware_protocol.inner_code import InnerCompiler
from firmware_protocol.kernel_cache import KernelCache
from firmware_protocol.kernel_parts import PartCache, compiler_beginning_with

F = TypeVar("F", bound=Callable[..., object])


class _Inner(CPUDispatcher):  # type: ignore[misc]
    """A function for other compiled functions: machine code that Python could call is made only when Python calls it.

    Wrapping every inner function for Python took a quarter of the time in which a kernel is compiled.
    """

    def __call__(self, *given: object) -> object:
        called = self.__dict__.get("from_python")
        if called is None:
            called = self.__dict__["from_python"] = numba.njit(**_INNER)(self.py_func)
        return called(*given)


class _Part(_Inner):
    """An inner function that is kept on disk by itself."""

    def __init__(self, function: Callable[..., object], types: tuple[Any, ...]) -> None:
        super().__init__(function, targetoptions={**_INNER, **_NOT_FROM_PYTHON}, pipeline_class=InnerCompiler)
        self._types = types
        self._cache = PartCache(function)  # type: ignore[no-untyped-call]

    def translate(self) -> None:
        """Make it for its types, unless it is on disk."""
        self.compile(self._types)

    def begin_elsewhere(self) -> None:
        """Let another process do it."""
        self._cache.begin_elsewhere(self._types, self.targetctx)


_INNER: dict[str, Any] = {"error_model": "numpy", "_nrt": False, "forceinline": True}
_NOT_FROM_PYTHON = {"nopython": True, "boundscheck": None, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}


#: types of the arguments of a `part`
INTEGERS, FLOATS, INTEGER = numba.int64[::1], numba.float64[::1], numba.int64


def compiled(function: F) -> F:
    """Compile an inner law: no cache of its own, inlined into the entry points that reach it.

    It must not allocate arrays: reference counting is off here, which halves the time of a plant step.
    """
    if getattr(numba.config, "DISABLE_JIT"):  # noqa: B009 - not in its type stub
        return function
    return cast(F, _Inner(function, targetoptions={**_INNER, **_NOT_FROM_PYTHON}, pipeline_class=InnerCompiler))


def interpreted(function: F) -> F:
    """A compiled law as plain Python, with all that it calls: for one call, which compiling would outlast."""
    if not isinstance(function, _Inner):
        return function
    law = function.py_func
    named = {name: law.__globals__[name] for name in law.__code__.co_names if name in law.__globals__}
    return cast(F, FunctionType(law.__code__, {name: interpreted(value) for name, value in named.items()}))


def part(*types: object) -> Callable[[F], F]:
    """`compiled` for arguments of these Numba types, and kept on disk by itself: a large part of several kernels."""

    def kept(function: F) -> F:
        if getattr(numba.config, "DISABLE_JIT"):  # noqa: B009 - not in its type stub
            return function
        return cast(F, _Part(function, types))

    return kept


def entry_point(function: F) -> F:
    """Compile a function that Python calls, cached under the digest of all source that it can reach."""
    return _kept(numba.njit(error_model="numpy")(function))


def assembled_entry_point(*meanwhile: Callable[..., object]) -> Callable[[F], F]:
    """`entry_point`, of which these parts are translated by processes of their own meanwhile."""

    def begin() -> None:
        for each in meanwhile:
            cast(_Part, each).begin_elsewhere()

    def assembled(function: F) -> F:
        if getattr(numba.config, "DISABLE_JIT"):  # noqa: B009 - not in its type stub
            return function
        steps = compiler_beginning_with(begin)
        return _kept(numba.njit(error_model="numpy", pipeline_class=steps)(function))

    return assembled


def _kept(kernel: Any) -> Any:
    """A kernel with a place on disk: as `cache=True` of Numba, with the folder of our own digest."""
    if not getattr(numba.config, "DISABLE_JIT"):  # noqa: B009 - not in its type stub
        kernel._cache = KernelCache(kernel.py_func)  # type: ignore[no-untyped-call]
    return kernel
