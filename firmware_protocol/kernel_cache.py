"""Where compiled kernels are kept on disk: under a digest of all the source that they can reach.

The digest stands for the place and the age of a file, by which Numba alone would tell fresh from stale: an edited law
is never run from an old binary, and the same sources in another checkout, environment or reinstalled wheel find what
was compiled before (decision 0219).
"""

from __future__ import annotations

import ast
import hashlib
import os
import stat
import sys
import tempfile
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from importlib.util import find_spec
from pathlib import Path

import numba
from numba.core.caching import CompileResultCacheImpl, FunctionCache

from firmware_protocol.errors import BadInputError

ROOMS = ("firmware_protocol", "sim_backend", "gimbal_hil")


class DigestFolder:
    """The folder of one function, as Numba asks for it."""

    def __init__(self, function: Callable[..., object]) -> None:
        self._digest = source_digest(function.__module__)
        self._folder = cache_directory() / self._digest / function.__module__
        self._line = function.__code__.co_firstlineno

    @classmethod
    def from_function(cls, function: Callable[..., object], _source: str) -> DigestFolder | None:
        """The folder, made; None where it cannot be written, and Numba then looks further."""
        place = cls(function)
        require_own(place._folder.parent)
        try:
            place.ensure_cache_path()
        except OSError:
            return None
        return place

    def ensure_cache_path(self) -> None:
        """Make the folder; OSError where it cannot be written."""
        self._folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=self._folder).close()

    def get_cache_path(self) -> str:
        """Where the function's files lie."""
        return str(self._folder)

    def get_source_stamp(self) -> str:
        """What tells fresh from stale."""
        return self._digest

    def get_disambiguator(self) -> str:
        """What tells functions of one name apart."""
        return str(self._line)


class KernelCache(FunctionCache):  # type: ignore[misc]
    """Numba's cache on disk, in the folder of the digest."""

    class _impl_class(CompileResultCacheImpl):  # type: ignore[misc]
        _locator_classes = [DigestFolder, *CompileResultCacheImpl._locator_classes]  # type: ignore[list-item]  # noqa: RUF012 - a list in Numba


def is_kept(module: str) -> bool:
    """Whether a kernel of a module, as its source is now, is on disk."""
    return any((cache_directory() / source_digest(module)).rglob("*.nbc"))


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
