"""Numba behind two decorators, with a disk cache that cannot go stale.

`compiled` marks a function that is inlined into what calls it; `entry_point` marks one that Python calls, kept on disk
under a key made of the content of every source file it can reach (its own module and what that imports from this
project, and effect plug-ins), so an edited law is never run from an old binary. With NUMBA_DISABLE_JIT=1 the same
functions run as plain Python.
"""

from __future__ import annotations

import ast
import hashlib
import os
import stat
import sys
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from types import FunctionType
from typing import Any, TypeVar, cast

import numba
from numba.core.registry import CPUDispatcher

from firmware_protocol.errors import BadInputError
from firmware_protocol.inner_code import InnerCompiler
from firmware_protocol.kernel_parts import PartCache, compiler_beginning_with

F = TypeVar("F", bound=Callable[..., object])

ROOMS = ("firmware_protocol", "sim_backend", "gimbal_hil")


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
        _keep_in_digest_of(function)
        return cast(F, _Part(function, types))

    return kept


def entry_point(function: F) -> F:
    """Compile a function that Python calls, cached under the digest of all source that it can reach."""
    _keep_in_digest_of(function)
    return cast(F, numba.njit(error_model="numpy", cache=True)(function))


def assembled_entry_point(*meanwhile: Callable[..., object]) -> Callable[[F], F]:
    """`entry_point`, of which these parts are translated by processes of their own meanwhile."""

    def begin() -> None:
        for each in meanwhile:
            cast(_Part, each).begin_elsewhere()

    def assembled(function: F) -> F:
        if getattr(numba.config, "DISABLE_JIT"):  # noqa: B009 - not in its type stub
            return function
        _keep_in_digest_of(function)
        steps = compiler_beginning_with(begin)
        return cast(F, numba.njit(error_model="numpy", cache=True, pipeline_class=steps)(function))

    return assembled


def is_kept(module: str) -> bool:
    """Whether a kernel of a module, as its source is now, is on disk."""
    return any((cache_directory() / source_digest(module)).rglob("*.nbc"))


def _keep_in_digest_of(function: Callable[..., object]) -> None:
    """Numba takes the folder of a cache when that is made."""
    folder = cache_directory() / source_digest(function.__module__)
    require_own(folder)
    setattr(numba.config, "CACHE_DIR", str(folder))  # noqa: B010 - not in its type stub


def cache_directory() -> Path:
    """Where compiled kernels are kept: `$GIMBAL_HIL_CACHE`, else `$XDG_CACHE_HOME/gimbal-hil`, else
    `~/.cache/gimbal-hil`.
    """
    named = os.environ.get("GIMBAL_HIL_CACHE")
    if named:
        return Path(named)
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "gimbal-hil"


@cache
def require_own(folder: Path) -> None:
    """What lies in the cache is machine code and will be run: BadInputError where somebody else could have written it.

    A folder that is not there yet is made so that nobody else can look into it.
    """
    if not hasattr(os, "getuid"):
        return
    with suppress(OSError):
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    if not folder.exists():
        return
    closed = folder.stat().st_mode & 0o077 == 0
    for path in (folder.parent, folder, *(() if closed else folder.rglob("*"))):
        found = path.lstat()
        if found.st_uid not in (os.getuid(), 0) or (found.st_mode & 0o022 and not stat.S_ISLNK(found.st_mode)):
            expected = f"a cache that only you can write: chmod -R go-w {folder.parent}, or remove it"
            raise BadInputError(str(path), "holds compiled code that somebody else could have written", expected)


def source_digest(module: str) -> str:
    """Digest of a module's source and of every module of this project that it imports, however indirectly."""
    reached: set[str] = set()
    pending = [module]
    while pending:
        name = pending.pop()
        if name not in reached:
            reached.add(name)
            pending.extend(_imported(name))
    digest = hashlib.sha256(f"{numba.__version__} {sys.version_info[:2]}".encode())
    for name in sorted(reached):
        digest.update(_source(name))
        for source in _found_at_run_time.get(name, ()):
            digest.update(source)
    return digest.hexdigest()[:16]


_found_at_run_time: dict[str, list[bytes]] = {}


def include_source(owner: str, source: bytes) -> None:
    """Make source that module `owner` found without an import statement (effects, plug-ins) part of the digests that
    reach it.
    """
    _found_at_run_time.setdefault(owner, []).append(source)


@cache
def _file(module: str) -> Path | None:
    """Where a module of this project lies. Nothing is imported to find out: faces would run while they are being
    read.
    """
    room, *inner = module.split(".")
    if room not in ROOMS:
        loaded = getattr(sys.modules.get(module), "__file__", None)
        return Path(loaded) if loaded else None
    spec = find_spec(room)
    for folder in spec.submodule_search_locations or () if spec else ():
        place = Path(folder, *inner)
        for path in (place / "__init__.py", place.with_suffix(".py")):
            if path.is_file():
                return path
    return None


@cache
def _source(module: str) -> bytes:
    path = _file(module)
    return path.read_bytes() if path else b""


@cache
def _imports(module: str) -> tuple[tuple[str, str], ...]:
    """(module, name) of everything that a module imports from this project, wherever in it; the name is empty for a
    plain import.
    """
    found: list[tuple[str, str]] = []
    for node in ast.walk(ast.parse(_source(module))):
        if isinstance(node, ast.Import):
            found += [(alias.name, "") for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            found += [(node.module, alias.name) for alias in node.names]
    return tuple(one for one in found if one[0].split(".")[0] in ROOMS)


@cache
def _imported(module: str) -> frozenset[str]:
    return frozenset(_home(base, name) for base, name in _imports(module))


def _home(module: str, name: str) -> str:
    """The module that a name comes from: faces are looked through, so that a kernel depends on the laws it uses and on
    no others.
    """
    if name and _file(f"{module}.{name}"):
        return f"{module}.{name}"
    path = _file(module)
    if name and path is not None and path.name == "__init__.py":
        for base, given in _imports(module):
            if given == name:
                return _home(base, given)
    return module
