"""The same work gives the same answers in this process, in local processes, and on a Dask cluster."""

from __future__ import annotations

import os
import socket
import sys
from collections.abc import Iterator
from itertools import repeat

import numpy as np
import pytest

from firmware_protocol.errors import BadInputError
from gimbal_hil.knowledge.discrepancy import Request, diagnose, verdict_of
from gimbal_hil.knowledge.executor import code_fingerprint, open_executor
from tests.benchmarks import friction_recovery
from tests.blind.cases import model_of, tables_of
from tests.blind.draw import draw
from tests.executor.cluster import local_cluster


def weigh(load: np.ndarray, factor: float) -> float:
    return float(load.sum()) * factor


def where(load: np.ndarray, factor: float) -> int:
    return os.getpid()


def fail(load: np.ndarray, factor: float) -> float:
    raise ValueError(f"no answer for {factor}")


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    pytest.importorskip("distributed", reason="the extra dask is not installed")
    with local_cluster(tmp_path_factory.mktemp("cluster")) as address:
        yield address


@pytest.mark.parametrize("workers", [1, 2])
def test_answers_come_in_the_order_of_the_items_and_see_the_shared_value(workers: int) -> None:
    with open_executor(workers) as executor:
        load = executor.share(np.arange(10.0))
        assert list(executor.map(weigh, repeat(load), [1.0, 2.0, 3.0])) == [45.0, 90.0, 135.0]


def test_a_value_may_be_shared_after_others_were_used() -> None:
    with open_executor(2) as executor:
        first = executor.share(np.ones(3))
        assert executor.submit(weigh, first, 2.0).result() == 6.0
        second = executor.share(np.ones(5))
        assert executor.submit(weigh, first, 1.0).result() + executor.submit(weigh, second, 1.0).result() == 8.0


def test_one_worker_is_this_process_and_two_are_not() -> None:
    for workers, here in ((1, True), (2, False)):
        with open_executor(workers) as executor:
            load = executor.share(np.zeros(1))
            assert (executor.submit(where, load, 0.0).result() == os.getpid()) is here


@pytest.mark.parametrize("workers", [1, 2])
def test_an_error_of_the_work_comes_back_where_its_answer_is_asked_for(workers: int) -> None:
    with open_executor(workers) as executor:
        failing = executor.submit(fail, executor.share(np.zeros(1)), 3.0)
        with pytest.raises(ValueError, match=r"no answer for 3\.0"):
            failing.result()


def test_a_missing_package_is_one_line_with_the_extra_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(BadInputError, match=r"gimbal-hil\[dask\]"):
        open_executor(dask="tcp://127.0.0.1:1")


def test_an_address_where_nothing_answers_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("distributed", reason="the extra dask is not installed")
    monkeypatch.setattr("gimbal_hil.knowledge.executor.executor._CONNECT_S", 0.3)
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        with pytest.raises(BadInputError, match="no scheduler answers"):
            open_executor(dask=f"tcp://127.0.0.1:{taken.getsockname()[1]}")


@pytest.mark.heavy
def test_a_cluster_answers_like_this_process(cluster: str) -> None:
    with open_executor(dask=cluster) as executor:
        load = executor.share(np.arange(10.0))
        assert list(executor.map(weigh, repeat(load), [1.0, 2.0])) == [45.0, 90.0]
        assert executor.submit(where, load, 0.0).result() != os.getpid()
        with pytest.raises(ValueError, match="no answer"):
            executor.submit(fail, load, 1.0).result()


@pytest.mark.heavy
def test_a_cluster_with_other_code_is_refused(cluster: str, monkeypatch: pytest.MonkeyPatch) -> None:
    answers = iter(["another"])
    monkeypatch.setattr(
        "gimbal_hil.knowledge.executor.executor.importlib.metadata.version", lambda package: next(answers, "another")
    )
    code_fingerprint.cache_clear()
    try:
        with pytest.raises(BadInputError, match="other code"):
            open_executor(dask=cluster)
    finally:
        code_fingerprint.cache_clear()


@pytest.mark.heavy
def test_a_verdict_is_the_same_to_the_last_bit_on_a_cluster(cluster: str) -> None:
    case = draw(101, ["cogging"], axis="inner", magnitude=12.0, duration_s=24.0)
    logs = tables_of(case.measured, case.axes), tables_of(case.holdout, case.axes)
    here = verdict_of(diagnose(Request(model_of(case), *logs)))
    # repr of a float tells all its bits
    assert repr(verdict_of(diagnose(Request(model_of(case), *logs), dask=cluster))) == repr(here)
    assert repr(verdict_of(diagnose(Request(model_of(case), *logs), workers=2))) == repr(here)


@pytest.mark.heavy
def test_a_campaign_is_the_same_to_the_last_bit_on_a_cluster(cluster: str) -> None:
    def campaign(workers: int, dask: str | None) -> list[str]:
        with open_executor(workers, dask) as executor:
            found = sorted(
                friction_recovery.repeats(executor, (1000, 1001), at_once=2, short=True), key=lambda r: r["seed"]
            )
        return [repr({key: value for key, value in result.items() if not key.endswith("_s")}) for result in found]

    assert campaign(1, cluster) == campaign(2, None)
