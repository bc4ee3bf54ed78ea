"""What there is to look at while the demo computes: an earlier run of it, and it says so."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from gimbal_hil.pages.report import EARLIER_DEMO, earlier_demo
from gimbal_hil.surface.cli import app
from tests.demo.record_motion import recorded


def motion_in(page: str) -> dict[str, object]:
    (data,) = re.findall(r'<script type="application/json">(.*?)</script>', page)
    found: dict[str, object] = json.loads(data)
    return found


def test_the_page_says_that_it_was_recorded_and_its_ghost_drifts_until_the_cause_is_added() -> None:
    page = earlier_demo("there.html").render()
    assert "Recorded by an earlier run of the demo" in page and "there.html" in page
    told = motion_in(page)
    measured = np.array(told["measured"])
    without, corrected = (np.array(one["position"]) for one in told["models"])  # type: ignore[attr-defined]
    off = [float(np.degrees(np.abs(ghost[0] - measured[0]).max())) for ghost in (without, corrected)]
    assert off[0] > 20.0 and off[1] < 0.1


def test_the_recording_is_made_of_a_report(tmp_path: Path) -> None:
    report = earlier_demo("there.html").write(tmp_path / "report.html")
    (tmp_path / "again.gz").write_bytes(recorded(report))
    assert len((tmp_path / "again.gz").read_bytes()) < len(EARLIER_DEMO.read_bytes())
    assert recorded(report) == recorded(report)


def test_the_demo_tells_of_it_before_anything_is_computed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def stopped(*_: object) -> Path:
        raise KeyboardInterrupt

    monkeypatch.setattr("gimbal_hil.surface.demo.tell", stopped)
    monkeypatch.setattr("gimbal_hil.surface.warming.ask_elsewhere", lambda *_: None)
    assert app.run("demo", ["--out", str(tmp_path / "demo")]) == 130
    said = capsys.readouterr().out
    assert "meanwhile" in said and str(tmp_path / "demo" / "meanwhile.html") in said
    assert "recorded, not live" in (tmp_path / "demo" / "meanwhile.html").read_text()
