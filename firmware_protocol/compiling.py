"""Numba behind two decorators, with a disk cache that cannot go stale.

`compiled` marks a function that is inlined into what calls it; `entry_point` marks one that Python calls, kept on disk
under a key made of the content of every source file it can reach (its own module and what that imports from this
project, and effect plug-ins), so an edited law is never run from an old binary. With NUMBA_DISABLE_JIT=1 the same
functions run as plain Python.
"""

from __future__ import annotations

import hashlib
import os
import re
import sys
from collections.abc import Callable
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any, TypeVar, cast

import numba

F = TypeVar("F", bound=Callable[..., object])

ROOMS = ("firmware_protocol", "sim_backend", "gimbal_hil")
_IMPORT = re.compile(r"^\s*(?:from|import)\s+((?:" + "|".join(ROOMS) + r")[.\w]*)(?:\s+import\s+(?:\(([^)]*)\)|([^\n#]*)))?", re.MULTILINE)


def compiled(function: F) -> F:
    """Compile an inner law: no cache of its own, inlined into the entry points that reach it.

    It must not allocate arrays: reference counting is off here, which halves the time of a plant step.
    """
    options: dict[str, Any] = {"error_model": "numpy", "_nrt": False, "forceinline": True}
    return cast(F, numba.njit(**options)(function))


def entry_point(function: F) -> F:
    """Compile a function that Python calls, cached under the digest of all source that it can reach."""
    setattr(numba.config, "CACHE_DIR", str(cache_directory() / source_digest(function.__module__)))  # noqa: B010 - not in its type stub
    return cast(F, numba.njit(error_model="numpy", cache=True)(function))


def cache_directory() -> Path:
    """Where compiled kernels are kept: `$GIMBAL_HIL_CACHE`, else `$XDG_CACHE_HOME/gimbal-hil`, else `~/.cache/gimbal-hil`."""
    named = os.environ.get("GIMBAL_HIL_CACHE")
    if named:
        return Path(named)
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "gimbal-hil"


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
    """Make source that module `owner` found without an import statement (effects, plug-ins) part of the digests that reach it."""
    _found_at_run_time.setdefault(owner, []).append(source)


@cache
def _source(module: str) -> bytes:
    loaded = sys.modules.get(module)
    path = getattr(loaded, "__file__", None)
    if path is None:
        try:
            spec = find_spec(module)
        except ModuleNotFoundError:
            return b""
        path = spec.origin if spec else None
    return Path(path).read_bytes() if path and path.endswith(".py") else b""


@cache
def _imported(module: str) -> tuple[str, ...]:
    names: set[str] = set()
    for base, in_brackets, in_line in _IMPORT.findall(_source(module).decode()):
        names.add(base)
        members = [member.split(" as ")[0].strip() for member in (in_brackets or in_line).split(",")]
        names.update(f"{base}.{member}" for member in members if member.isidentifier() and _is_module(f"{base}.{member}"))
    return tuple(names)


def _is_module(name: str) -> bool:
    try:
        return find_spec(name) is not None
    except (ModuleNotFoundError, ValueError):
        return False
