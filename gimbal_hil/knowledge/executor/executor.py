"""Where independent work is done: in this process, in local processes, or on a Dask cluster; one interface, the same
answers.

Every executor is a `concurrent.futures.Executor` with one addition, `share`, which puts a large value where the work is
done once and answers what stands for it in the arguments of `submit` and `map`. Work is pure functions of their
arguments, so that it does not matter where they run; linear algebra runs on one thread in the command line and in
Dask's workers alike.
"""

from __future__ import annotations

import hashlib
import importlib
import importlib.metadata
import multiprocessing
import os
import signal
import sys
from abc import abstractmethod
from collections.abc import Callable
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any, TypeVar, cast

from firmware_protocol.errors import BadInputError
from firmware_protocol.kernel_cache import ROOMS
from gimbal_hil.knowledge.executor.parentage import end_with_parent

Value = TypeVar("Value")
Answer = TypeVar("Answer")

#: packages whose version may change the last bit of an answer
_NUMERIC = ("numba", "numpy", "scipy")
_CONNECT_S = 10.0


class WorkExecutor(Executor):
    """A standard executor that can also share a value with everything that it runs."""

    @abstractmethod
    def share(self, value: Value) -> Value:
        """What stands for `value` in the arguments of `submit` and `map`: sent once, not with every call."""

    def __exit__(self, *_: object) -> None:
        self.shutdown(wait=True, cancel_futures=True)


def open_executor(workers: int = 1, dask: str | None = None) -> WorkExecutor:
    """The executor for `workers` processes here, or for the Dask scheduler at `dask` (such as tcp://127.0.0.1:8786).

    Raises BadInputError when distributed is not installed, nothing answers at the address, or the cluster runs other
    code.
    """
    if dask is not None:
        return DaskCluster(dask)
    return LocalProcesses(workers) if workers > 1 else InThisProcess()


class InThisProcess(WorkExecutor):
    """Does the work at once, where it is asked for."""

    def share(self, value: Value) -> Value:
        """The value itself."""
        return value

    def submit(self, function: Callable[..., Answer], /, *arguments: object, **named: object) -> Future[Answer]:
        """A future that is done."""
        future: Future[Answer] = Future()
        try:
            future.set_result(function(*arguments, **named))
        except Exception as error:
            future.set_exception(error)
        return future


@dataclass(frozen=True)
class _Shared:
    """Stands for a value that the worker has."""

    number: int


_values_here: dict[int, object] = {}


def _install(values: dict[int, object], parent: int) -> None:
    """In a worker, before its first work. It waits on a queue whose other end it holds as well: nothing else would tell
    it to end.
    """
    end_with_parent(parent, signal.SIGKILL)
    _values_here.update(values)


def _with_values(function: Callable[..., Answer], *arguments: object, **named: object) -> Answer:
    return function(*(_values_here[a.number] if isinstance(a, _Shared) else a for a in arguments), **named)


class LocalProcesses(WorkExecutor):
    """Processes on this machine; forked, so that shared values and compiled code are inherited, not sent."""

    def __init__(self, workers: int) -> None:
        self._workers = workers
        self._values: dict[int, object] = {}
        self._pool: ProcessPoolExecutor | None = None

    def share(self, value: Value) -> Value:
        """A token; processes that already run are replaced, so share before the work begins."""
        self._close_pool()
        self._values[len(self._values)] = value
        return cast(Value, _Shared(len(self._values) - 1))

    def submit(self, function: Callable[..., Answer], /, *arguments: Any, **named: Any) -> Future[Answer]:
        """Queue one call; function and arguments must pickle."""
        if self._pool is None:
            context = multiprocessing.get_context("fork")
            orders = self._values, os.getpid()
            self._pool = ProcessPoolExecutor(self._workers, mp_context=context, initializer=_install, initargs=orders)
        return self._pool.submit(_with_values, function, *arguments, **named)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Let the processes go."""
        self._close_pool(wait, cancel_futures)

    def _close_pool(self, wait: bool = True, cancel_futures: bool = False) -> None:
        if self._pool is not None:
            self._pool.shutdown(wait, cancel_futures=cancel_futures)
            self._pool = None


class DaskCluster(WorkExecutor):
    """A Dask cluster that is already running; refused when one of its workers has other code or other numeric
    packages.
    """

    def __init__(self, address: str) -> None:
        try:
            distributed: Any = importlib.import_module("distributed")
        except ImportError:
            raise BadInputError("--dask", "distributed is not installed", "pip install 'gimbal-hil[dask]'") from None
        try:
            self._client = distributed.Client(address, timeout=_CONNECT_S, set_as_default=False)
        except (OSError, ValueError, TypeError) as error:
            raise BadInputError(
                f"--dask {address}", f"no scheduler answers ({error})", "an address such as tcp://127.0.0.1:8786"
            ) from None
        try:
            self._check_workers(address)
        except BaseException:
            self._client.close()
            raise
        self._inner = self._client.get_executor(pure=False)

    def _check_workers(self, address: str) -> None:
        found = self._client.run(code_fingerprint, on_error="return")
        if not found:
            raise BadInputError(f"--dask {address}", "the cluster has no workers", "at least one dask worker")
        for worker, fingerprint in found.items():
            if fingerprint != code_fingerprint():
                raise BadInputError(
                    f"--dask {address}", f"worker {worker} has other code than this process ({fingerprint})", "the same"
                )

    def share(self, value: Value) -> Value:
        """A future of the value, which lies on every worker."""
        return cast(Value, self._client.scatter(value, broadcast=True, hash=False))

    def submit(self, function: Callable[..., Answer], /, *arguments: object, **named: object) -> Future[Answer]:
        """Queue one call on the cluster."""
        return cast("Future[Answer]", self._inner.submit(function, *arguments, **named))

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Leave the cluster; it stays up."""
        if not cancel_futures:
            self._inner.shutdown(wait=wait)
        self._client.close()


@cache
def code_fingerprint() -> str:
    """Digest of this project's source and of the versions of Python and of the numeric packages: equal ones give equal
    answers.
    """
    digest = hashlib.sha256(repr(sys.version_info[:3]).encode())
    for package in _NUMERIC:
        digest.update(f"{package} {importlib.metadata.version(package)} ".encode())
    for room in ROOMS:
        spec = find_spec(room)
        for folder in (spec.submodule_search_locations or ()) if spec else ():
            for path in sorted(Path(folder).rglob("*.py")):
                digest.update(path.relative_to(folder).as_posix().encode() + path.read_bytes())
    return digest.hexdigest()[:16]
