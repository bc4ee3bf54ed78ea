"""The validation as a command: three files, one verdict, nothing overwritten."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from firmware_protocol.errors import BadInputError
from gimbal_hil.proof.thesis import as_text, run_thesis
from gimbal_hil.proof.thesis.step_size import step_convergence


def test_a_folder_with_a_report_is_not_overwritten(tmp_path: Path) -> None:
    (tmp_path / "report.html").write_text("kept")
    with pytest.raises(BadInputError, match="exists already; expected another --out, or --force"):
        run_thesis(tmp_path)
    assert (tmp_path / "report.html").read_text() == "kept"


def test_the_whole_antenna_on_a_moving_base_converges_at_second_order() -> None:
    found = step_convergence()
    assert all(1.8 < order < 2.2 for order in found.orders)
    assert dict(zip(found.step_s, found.error_rad, strict=True))[1e-4] < 2e-6


@pytest.mark.heavy
def test_the_whole_validation_leaves_page_text_and_numbers_that_agree(tmp_path: Path) -> None:
    told: list[float] = []
    report = run_thesis(tmp_path / "thesis", progress=lambda what, share: told.append(share))
    assert report.within_bounds and report.page == tmp_path / "thesis" / "report.html"
    assert told == sorted(told) and told[-1] < 1.0
    numbers = json.loads((tmp_path / "thesis" / "report.json").read_text())
    assert [table["table"] for table in numbers["tables"]] == [f"5.{n}" for n in (*range(2, 10), *range(12, 16))]
    agreements = [table["agreement"] for table in numbers["tables"]]
    assert agreements.count("reproduced") == 4 and agreements.count("close, within its regression bound") == 3
    assert agreements.count("not reproducible") == 3
    for found in numbers["recovered"]:
        # better than the thesis, and sure of it: the interval holds the truth
        assert found["low"] <= found["true"] <= found["high"]
        assert abs(found["value"] - found["true"]) < abs(found["thesis"] - found["true"])
    page, text = report.page.read_text(), (tmp_path / "thesis" / "report.txt").read_text()
    assert text == as_text(report) + "\n"
    for heading in (
        "Controller tables",
        "Unbalance on a moving base",
        "Slips of the thesis",
        "Friction recovered",
        "Friction over temperature",
        "Step size of the plant",
    ):
        assert heading in page
    assert 'src="http' not in page
