"""Parallel work: the same function on many items, in processes that share the twins, or on a Dask cluster."""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable, Sequence
from concurrent.futures import Executor, ProcessPoolExecutor
from typing import Any, TypeVar

from gimbal_hil.discrepancy.families import Family
from gimbal_hil.discrepancy.fit import Fit, refit
from gimbal_hil.discrepancy.hypothesis import Hypothesis
from gimbal_hil.discrepancy.screening import Response, respond
from gimbal_hil.discrepancy.smoothing import Floats
from gimbal_hil.discrepancy.twin import Twin

Item = TypeVar("Item")
Answer = TypeVar("Answer")
_shared: dict[str, Twin] = {}


def _install(twin: Twin) -> None:
    _shared["twin"] = twin


def _with_shared(call: tuple[Callable[..., Any], Any]) -> Any:
    function, item = call
    return function(_shared["twin"], item)


def respond_one(twin: Twin, work: tuple[Fit, Floats, Family]) -> list[Response]:
    """Responses of one family beside a fit."""
    return respond(twin, *work)


def refine_one(twin: Twin, work: tuple[Hypothesis, Floats, float, Floats | None]) -> Fit:
    """One hypothesis at its best coordinates."""
    hypothesis, floor, spread, known = work
    return refit(twin, hypothesis, floor, rounds=3, spread=spread, known=known)


class Workers:
    """Maps functions of (twin, item); with one worker everything stays in this process."""

    def __init__(self, twin: Twin, count: int = 1, dask: str | None = None) -> None:
        self._twin = twin
        self._pool: Executor | None = None
        self._client: Any = None
        if dask is not None:
            from distributed import Client

            self._client = Client(dask)
            self._remote_twin = self._client.scatter(twin, broadcast=True)
        elif count > 1:
            # forked, so that records and compiled code are shared and not sent
            context = multiprocessing.get_context("fork")
            self._pool = ProcessPoolExecutor(count, mp_context=context, initializer=_install, initargs=(twin,))

    def map(self, function: Callable[[Twin, Item], Answer], items: Sequence[Item]) -> list[Answer]:
        """Answers in the order of the items."""
        if self._client is not None:
            return list(self._client.gather([self._client.submit(function, self._remote_twin, item, pure=False) for item in items]))
        if self._pool is not None:
            return list(self._pool.map(_with_shared, [(function, item) for item in items]))
        return [function(self._twin, item) for item in items]

    def close(self) -> None:
        """Let the processes or the cluster go."""
        if self._pool is not None:
            self._pool.shutdown(cancel_futures=True)
        if self._client is not None:
            self._client.close()

    def __enter__(self) -> Workers:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
