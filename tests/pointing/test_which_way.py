"""Which way is up, what can be reached, and whether the time of day is right."""

from __future__ import annotations

import importlib.util
import math
import time
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol.errors import BadInputError
from gimbal_hil.loop.settings import DaemonSettings, settings_from_document, shipped_settings
from gimbal_hil.loop.timing import clock_sync, clock_sync_of
from gimbal_hil.pointing.arena import boresight
from gimbal_hil.pointing.following import (
    STANDING,
    BaseTruth,
    TickClock,
    in_base,
    joints_needed,
    joints_seen,
    require_reach,
    target_of,
    truth_of,
    way_of,
)
from sim_backend.boresight import Boresight
from sim_backend.model import shipped_model

PICTURES = Path(__file__).resolve().parents[2] / "docs" / "pictures"
START = datetime(2026, 11, 22, 12, tzinfo=UTC)
azimuths, elevations = st.floats(-360.0, 360.0), st.floats(0.1, 89.0)


def sky(azimuth_deg: float, elevation_deg: float) -> np.ndarray:
    """North, west, up of a direction."""
    a, e = math.radians(azimuth_deg), math.radians(elevation_deg)
    return np.array([math.cos(e) * math.cos(a), -math.cos(e) * math.sin(a), math.sin(e)])


@given(azimuth=azimuths, elevation=elevations)
def test_the_antenna_looks_at_the_target_whichever_way_its_joint_counts(azimuth: float, elevation: float) -> None:
    target = target_of(f"azel:{azimuth},{elevation}", None, START)
    for looks in Boresight:
        joints = joints_seen(target, np.zeros(1), looks)
        np.testing.assert_allclose(looks.sign * boresight(joints)[0], sky(azimuth, elevation), atol=1e-12)
        assert (joints[0, 1] > 0.0) == (looks.raises == "positive")


@given(azimuth=azimuths, elevation=elevations, angles=st.tuples(*(st.floats(-1.0, 1.0),) * 3))
def test_an_aircraft_under_an_antenna_that_looks_astern_is_the_same_aircraft(
    azimuth: float, elevation: float, angles: tuple[float, float, float]
) -> None:
    # ahead on an attitude, or astern on the same one turned by half a turn about its z: one direction in space
    roll, pitch, yaw = angles
    target = target_of(f"azel:{azimuth},{elevation}", None, START)
    needed = []
    for looks, attitude in ((Boresight.AHEAD, angles), (Boresight.ASTERN, (-roll, -pitch, yaw + math.pi))):
        base = BaseTruth(np.zeros(1), np.array([attitude]))
        needed.append(joints_needed(way_of(target, 1.0, looks), 1.0, base)[1][0])
    assert needed[1][1] == pytest.approx(-needed[0][1], abs=1e-9)
    if abs(abs(needed[0][1]) - math.pi / 2.0) > 1e-3:
        assert math.remainder(needed[1][0] - needed[0][0], 2.0 * math.pi) == pytest.approx(0.0, abs=1e-7)


def test_a_named_motion_has_the_aircraft_ahead_of_the_antenna() -> None:
    ahead, astern = (truth_of("turbulence", 2.0, 1, looks) for looks in Boresight)
    x = np.tile([1.0, 0.0, 0.0], (len(ahead.time_s), 1))
    np.testing.assert_allclose(in_base(x, ahead.attitude), in_base(x, astern.attitude) * (-1.0, -1.0, 1.0), atol=1e-12)


def reach(text: str, base: BaseTruth = STANDING, **limits: float) -> None:
    settings = shipped_settings()
    axes = {
        name: axis.model_copy(
            update={
                "limits": axis.limits.model_copy(update={key[6:]: x for key, x in limits.items() if key[:5] == name})
            }
        )
        for name, axis in settings.axes.items()
    }
    target = target_of(text, None, START)
    require_reach(way_of(target, 10.0), 10.0, settings.model_copy(update={"axes": axes}), base, text)


def test_what_a_joint_cannot_look_at_is_refused_by_name_with_its_reach() -> None:
    low = {"inner_position_low_rad": 0.0, "inner_position_high_rad": 1.57}
    with pytest.raises(BadInputError, match=r"needs inner at -30\.0 degrees.*boresight: x.*0\.0 to 90\.0 degrees"):
        reach("azel:90,30", **low)
    # on its back the same antenna looks up with positive angles
    reach("azel:90,30", BaseTruth(np.zeros(1), np.array([[math.pi, 0.0, 0.0]])), **low)
    narrow = {"outer_position_low_rad": -0.5, "outer_position_high_rad": 0.5}
    reach("azel:-20,30", **narrow)
    reach("azel:340,30", **narrow)
    with pytest.raises(BadInputError, match=r"needs outer at -90\.0 degrees after 0\.0 s.*-28\.6 to 28\.6 degrees"):
        reach("azel:90,30", **narrow)


def test_a_base_that_rolls_out_of_reach_is_told_with_the_time() -> None:
    rolling = BaseTruth(np.array([0.0, 10.0]), np.array([[0.0, 0.0, 0.0], [0.0, 0.5, 0.0]]))
    with pytest.raises(BadInputError, match=r"needs inner at .* after [3-6]\.\d s"):
        reach("azel:0,30", rolling, inner_position_low_rad=-0.7, inner_position_high_rad=0.7)


def with_boresight(said: str | None, model: Path) -> DaemonSettings:
    document = shipped_settings().model_dump(mode="json", by_alias=True)
    document["link"] = {"embedded": {"model": str(model)}}
    document["pointing"]["boresight"] = said
    return settings_from_document(document, "here")


def test_a_run_keeps_which_way_is_up_and_a_contradiction_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "model.yaml"
    file.write_text(shipped_model("thesis").to_yaml() + "boresight: -x\n")
    assert with_boresight(None, file).with_model().pointing.boresight is Boresight.ASTERN
    assert with_boresight("-x", file).with_model().pointing.boresight is Boresight.ASTERN
    with pytest.raises(BadInputError, match=r"pointing\.boresight.*model\.yaml says -x"):
        with_boresight("x", file).with_model()


def test_the_picture_is_what_its_script_draws() -> None:
    script = PICTURES / "which_way_is_up.py"
    spec = importlib.util.spec_from_file_location("which_way_is_up", script)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    drawn = module.drawing()
    assert script.with_name("which-way-is-up.svg").read_text() == drawn
    # joints in degrees from the formulas of the page
    assert all(words in drawn for words in ("outer -60", "inner -30", "outer +120", "inner +30"))


def test_the_kernel_says_whether_a_clock_is_held_and_the_age_follows_from_its_bound() -> None:
    held = clock_sync_of(0, 0x2001, 12_000)
    assert held.synchronised and held.error_bound_s == pytest.approx(0.012) and held.age_s == pytest.approx(24.0)
    assert "24 s ago" in held.in_words()
    assert not clock_sync_of(5, 0x2001, 12_000).synchronised
    assert not clock_sync_of(0, 0x0040, 16_000_000).synchronised
    assert not clock_sync_of(-1, 0, 0).known and "not known" in clock_sync_of(-1, 0, 0).in_words()
    assert clock_sync().in_words()


def test_a_clock_that_is_set_is_noticed_and_one_that_is_steered_is_not(monkeypatch: pytest.MonkeyPatch) -> None:
    real = time.time
    clock = TickClock(0.0, 1e-3, 0.0, real() - time.monotonic())
    for ahead, noticed in ((0.0, False), (0.005, False), (5.0, True), (-0.2, True)):
        monkeypatch.setattr(time, "time", lambda ahead=ahead: real() + ahead)
        assert (clock.stepped_s() != 0.0) == noticed
    assert clock.stepped_s() == pytest.approx(-0.2, abs=0.02)
