"""Figures of a held direction, and the page that tells them."""

from __future__ import annotations

import json
import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gimbal_hil.loop.settings import shipped_settings_path
from gimbal_hil.pointing.following import HeldTarget, HeldTrace, MuteChange, pointing_figures, write_page
from gimbal_hil.surface.cli.app import run

BEYOND = math.radians(0.5)
A_STAR = HeldTarget("a star", "here", "about")


def trace_of(error: np.ndarray, muted: np.ndarray) -> HeldTrace:
    tick = np.arange(1000, 1000 + len(error))
    joints = np.column_stack([error, error])
    unknown, on_target = np.full(len(error), np.nan), np.zeros(len(error))
    return HeldTrace(tick, (tick - 1000) * 1e-3, error, unknown, joints, joints, on_target, muted)


def test_errors_count_while_the_antenna_is_not_muted_and_settled_ones_from_5_s_on() -> None:
    error = np.concatenate([np.full(1000, 0.1), np.full(5000, 300e-6), np.full(4000, 20e-6)])
    muted = np.arange(10000) < 1000
    error[8000:8010], muted[8002:8100] = 0.02, True
    changes = [MuteChange(1000 + at, "tracking", on, 0.0) for at, on in ((0, True), (1000, False), (8002, True))]
    changes.append(MuteChange(9100, "tracking", False, 0.0))
    found = pointing_figures(trace_of(error, muted), changes, BEYOND)
    assert found.acquired_after_s == pytest.approx(1.0)
    assert found.muted_after_acquisition_s == pytest.approx(0.098) and found.mutes_after_acquisition == 1
    assert found.beyond_without_mute_s == found.longest_beyond_without_mute_s == pytest.approx(0.002)
    assert found.peak_urad == found.settled_peak_urad == pytest.approx(2e4)
    quiet = pointing_figures(trace_of(np.where(error > 0.01, 20e-6, error), muted), changes, BEYOND)
    assert quiet.settled_rms_urad == pytest.approx(20.0) and quiet.rms_urad > 100.0


def test_the_page_has_every_name_once_so_that_its_figures_are_found_and_drawn(tmp_path: Path) -> None:
    trace = trace_of(np.full(8000, 20e-6), np.zeros(8000, np.bool_))
    figures = pointing_figures(trace, [], BEYOND)
    page = write_page(tmp_path / "page.html", A_STAR, trace, figures, [], BEYOND).read_text()
    names = re.findall(r'\sid="([^"]+)"', page)
    assert {"packed:figures", "packed:library"} <= set(names) and len(names) == len(set(names))


def test_a_reference_that_left_the_target_is_told_in_red_whatever_the_error_against_it(tmp_path: Path) -> None:
    trace = trace_of(np.full(8000, 20e-6), np.zeros(8000, np.bool_))
    off = replace(trace, reference_off=np.where(np.arange(8000) > 4000, 0.15, 0.0))
    figures = pointing_figures(off, [], BEYOND)
    assert not figures.followed_the_target and pointing_figures(trace, [], BEYOND).followed_the_target
    page = write_page(
        tmp_path / "page.html", HeldTarget("a pass", "here", "about"), off, figures, [], BEYOND
    ).read_text()
    assert 'class="callout bad"' in page and "8.59 degrees off" in page


def test_a_target_that_was_never_acquired_is_told_in_red_without_numbers_that_are_none(tmp_path: Path) -> None:
    trace = trace_of(np.full(8000, 0.3), np.ones(8000, np.bool_))
    figures = pointing_figures(trace, [], BEYOND)
    page = write_page(tmp_path / "page.html", A_STAR, trace, figures, [], BEYOND).read_text()
    assert 'class="callout bad"' in page and "nan µrad" not in page


def test_the_true_error_is_told_first_and_loops_that_do_not_extrapolate_are_told_of_tuning(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["--target", "azel:120,35", "--base", "swing", "--duration", "9", "--out", str(tmp_path / "out")]
    assert run("point", words) == 0
    said, found = capsys.readouterr().out, json.loads((tmp_path / "out" / "pointing.json").read_text())
    true, seen = found["settled_true_rms_urad"], found["settled_rms_urad"]
    # an attitude that is 5 ms old and told a hundred times a second is not seen by the host
    assert true > 2.0 * seen
    peak = found["settled_true_peak_urad"]
    rms_deg, peak_deg = (f"{math.degrees(1e-6 * one):.2g}°" for one in (true, peak))
    told = f"within {true:.1f} µrad ({rms_deg}) rms and {peak:.0f} µrad ({peak_deg}) at most of true error (as host"
    assert told in said and "e+03" not in (tmp_path / "out" / "report.html").read_text()
    assert "gimbal-hil tune --for pointing" in said
    assert run("point", [*words, "--config", str(_extrapolating(tmp_path)), "--force"]) == 0
    assert "tune --for pointing" not in capsys.readouterr().out


def _extrapolating(folder: Path) -> Path:
    """The shipped configuration, the base's motion extrapolated."""
    file = folder / "antenna.yaml"
    file.write_text(shipped_settings_path().read_text() + "\nmodel_control: {model: thesis, extrapolate_base: true}\n")
    return file


@pytest.mark.heavy
def test_a_moving_target_is_followed_past_the_first_minute(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    tle = Path(__file__).parents[2] / "config" / "scenarios" / "example.tle"
    words = ["--target", f"tle:{tle}", "--position", "48.35,11.79,10700", "--at", "2026-11-22T12:06:30Z"]
    assert run("point", [*words, "--duration", "75", "--out", str(tmp_path / "out"), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    # a target that began anew after a minute is degrees off by then
    assert found["reference_off_urad"] < 10.0 and found["settled_true_peak_urad"] < 100.0
