"""The ghost of a model beside the antenna: it stays where the model is right, drifts where it is not, and is played."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.signals import SignalsTable, read_signals
from gimbal_hil.knowledge.experiments import conduct, embedded_model_of
from gimbal_hil.knowledge.experiments.sequences import SequenceOptions
from gimbal_hil.knowledge.experiments.sequences.survey import survey_motion
from gimbal_hil.loop.settings import shipped_settings
from gimbal_hil.pages.report import ModelMotion, MovingAntenna, Page
from gimbal_hil.surface.demo.ghost import ghost_of, side_by_side
from tests.browser import CHROMIUM, Browser

pytestmark = pytest.mark.realtime
AXES = ("azimuth", "tilt</script>")


def test_a_ghost_stays_on_the_antenna_where_its_model_is_right_and_drifts_where_it_lacks_something(
    tmp_path: Path,
) -> None:
    settings = shipped_settings()
    model, seed = embedded_model_of(settings)
    antenna = model.with_effect("cogging", "outer", {"amplitude": 0.03, "order": 12.0, "phase": 0.7})
    experiment = survey_motion(SequenceOptions(settings.rate_hz, names=settings.axis_names), 1, 8.0)
    conduct(experiment, settings, antenna, seed, tmp_path / "run")
    measured = read_signals(tmp_path / "run", model.axes)
    right = ghost_of(measured, "outer", antenna, settings, seed, tmp_path / "right")
    wrong = ghost_of(measured, "outer", model, settings, seed, tmp_path / "wrong")
    moved = np.column_stack([measured.columns[f"{axis}.position"] for axis in model.axes])
    assert np.ptp(moved[:, 0]) > 0.1 and right.shape == wrong.shape == moved.shape
    off = [np.abs(found - moved).max(axis=0) for found in (right, wrong)]
    # the other axis follows its reference, as it did; the sensors' noise of another run is all that differs
    assert off[0][0] < 1e-3 and off[0][1] < 1e-3 and off[1][1] < 1e-3
    assert off[1][0] > 20.0 * off[0][0]
    block = side_by_side(measured, "outer", {"as it was": wrong, "corrected": right})
    assert "as it was: 0\u00b0" not in block.caption and "goes on drifting" not in block.caption
    assert len(block.time_s) == len(block.measured[0]) == len(block.models[1].position[1]) < len(measured) / 10
    assert "goes on drifting" in side_by_side(measured, "outer", {"as it was": wrong}).caption


def test_a_log_without_a_reference_has_no_ghost(tmp_path: Path) -> None:
    settings = shipped_settings()
    model, seed = embedded_model_of(settings)
    names = [f"{axis}.{signal}" for axis in model.axes for signal in ("torque", "position")]
    bare = SignalsTable.of(model.axes, np.arange(10) * 1e-3, {name: np.ones(10) for name in names})
    with pytest.raises(BadInputError, match=r"no inner\.position_ref"):
        ghost_of(bare, "outer", model, settings, seed, tmp_path / "ghost")


@pytest.mark.skipif(CHROMIUM is None, reason="there is no Chromium here")
def test_a_motion_is_played_with_the_first_model_then_the_last_and_a_hand_may_choose(tmp_path: Path) -> None:
    time_s = np.linspace(0.0, 30.0, 301)
    still, drift = np.zeros(301), np.radians(time_s)
    models = [
        ModelMotion("as it was", [drift.tolist(), still.tolist()]),
        ModelMotion("<b>better", [still.tolist()] * 2),
    ]
    motion = MovingAntenna("A ghost", AXES, time_s.tolist(), [still.tolist()] * 2, models, "what one sees")
    page = Page("A title", "", [motion]).write(tmp_path / "page.html")
    said, slider = "document.querySelector('.motion output').textContent", "document.querySelector('.motion input')"
    with Browser(390, 800) as browser:
        browser.open(page.as_uri(), f"{said}.includes('azimuth')")
        browser.until(f"Number({slider}.value) > 3")
        assert (
            browser.value(f"{said}.includes('as it was')")
            and browser.value("document.querySelectorAll('b').length") == 0
        )
        assert browser.value("document.documentElement.scrollWidth") <= 390
        # it stops where a hand puts it, and tells how far off it is there
        for at, told in (
            (10, "10.0 s, as it was: ghost minus antenna azimuth 10.00"),
            (20, "20.0 s, <b>better: ghost minus"),
        ):
            browser.value(f"{slider}.value = {at}; {slider}.oninput(); 1")
            assert browser.value(said).startswith(told)
        browser.value("document.querySelectorAll('.motion button')[1].click(); 1")
        browser.until(f"{said}.includes('as it was: ghost minus antenna azimuth 20.00')")
        pressed = browser.value(
            "[...document.querySelectorAll('.motion button')].map(b => b.getAttribute('aria-pressed'))"
        )
        assert pressed == [None, "true", "false"]
        assert browser.value("document.querySelector('.motion canvas').getAttribute('aria-label')").startswith(
            "A ghost. 20.0 s"
        )
        assert not browser.problems


def test_a_page_without_a_motion_carries_no_drawing_of_the_antenna() -> None:
    assert "antenna_view" not in Page("A title", "", []).render()
