"""A verdict is the same to the bit, whatever does the work: this process, two more, or a Dask cluster."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from gimbal_hil.knowledge.discrepancy import Request, diagnose, verdict_of
from tests.blind.cases import model_of, tables_of
from tests.blind.draw import draw
from tests.executor.cluster import local_cluster


@pytest.mark.heavy
def test_verdicts_are_equal_to_the_bit(tmp_path: Path) -> None:
    pytest.importorskip("distributed", reason="the extra dask is not installed")
    case = draw(101, ["cogging"], axis="inner", magnitude=12.0, duration_s=24.0)
    request = Request(model_of(case), tables_of(case.measured, case.axes), tables_of(case.holdout, case.axes))

    def verdict(**who: Any) -> dict[str, Any]:
        return verdict_of(diagnose(request, **who)).document

    alone = verdict(workers=1)
    assert alone["effects"]
    assert verdict(workers=2) == alone
    with local_cluster(tmp_path) as address:
        assert verdict(dask=address) == alone
