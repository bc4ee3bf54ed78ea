"""The antenna in three dimensions on the live page: what it is told, what it draws, keys, screen reader, phone."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from firmware_protocol import schema
from firmware_protocol.enumerations import DriveState
from gimbal_hil.data.runs import TICK_ROW
from gimbal_hil.loop.host import GUARD_CAUSES, HostState, word_of
from gimbal_hil.loop.settings import shipped_settings
from gimbal_hil.pages.antenna import ANTENNA_SCRIPT
from gimbal_hil.realtime.dashboard.page import PAGE
from gimbal_hil.realtime.dashboard.server import live
from gimbal_hil.realtime.service.service import limits_in_force
from gimbal_hil.realtime.telemetry import LiveView, told_state, trouble_of
from gimbal_hil.realtime.telemetry.records import Exchange
from tests.browser import CHROMIUM, Browser

pytestmark = pytest.mark.realtime
in_a_browser = pytest.mark.skipif(CHROMIUM is None, reason="there is no Chromium here")
AXES = ("azimuth", "tilt")
LIMITS = {
    "azimuth": {"position_low_rad": None, "position_high_rad": None, "cable_wrap_turns": 2.0, "torque_nm": 15.5},
    "tilt": {"position_low_rad": -1.0, "position_high_rad": 0.5, "cable_wrap_turns": None, "torque_nm": 6.6},
}
#: 20 s of a trace at 50 Hz that arrives in pieces as the page asks, once it is told to move
MOVING = """
window.moving = false; window.asked = 0;
const began = performance.now() / 1000, there = n => window.moving ? n / 50 : 0;
window.fetch = async address => ({json: async () => {
  const found = structuredClone(window.told), trace = found.trace, since = Number(String(address).split("=")[1]);
  window.asked += 1;
  for (let n = Math.floor(Math.max(since, 0) * 50) + 1; n / 50 < performance.now() / 1000 - began + 1; n++)
    for (const [name, column] of Object.entries(trace))
      column.push(name === "time_s" ? n / 50 : name === "position_azimuth" ? there(n)
        : name.startsWith("position_ref") ? .4
        : name === "torque_tilt" ? -1.5 : name.startsWith("base") || name === "muted" ? null : 0);
  return found;
}});
"""
#: how many dots of the canvas are not empty, and a sum that another picture changes
DOTS = """(c => { const d = c.getContext("2d").getImageData(0, 0, c.width, c.height).data; let n = 0, sum = 0;
for (let k = 0; k < d.length; k += 4) if (d[k + 3]) { n += 1; sum = (sum * 31 + d[k] + 7 * d[k + 1] + k) % 1000003; }
return [n / (c.width * c.height), sum]; })(document.querySelector("#antenna"))"""


def told() -> dict[str, Any]:
    view = LiveView(1_000_000, AXES, limits=lambda: LIMITS)
    document = live(view, -1.0)
    document["status"]["link"] = "ok"
    document["status"]["position_rad"] = {"azimuth": math.pi / 6, "tilt": -0.2}
    document["status"]["rate_rad_s"] = {"azimuth": 0.0, "tilt": 0.1}
    document["status"]["observer"]["state"] = "off"
    document["recording"] = {"lamp": "ok", "free_mb": None, "problem": None}
    return document


@pytest.fixture
def browser(tmp_path: Path) -> Iterator[Browser]:
    file = tmp_path / "page.html"
    script = f"<script>window.told = {json.dumps(told())};{MOVING}</script>"
    file.write_text(PAGE.replace("<script>", script + "<script>", 1))
    with Browser() as browser:
        browser.open(file.as_uri(), "seen && seen.count.frames > 2")
        yield browser


@in_a_browser
def test_the_antenna_is_drawn_follows_the_trace_and_is_told_to_a_screen_reader(browser: Browser) -> None:
    browser.until(f"{DOTS}[0] > .05")
    browser.until("document.querySelector('#antenna').getAttribute('aria-label').includes('azimuth at 30.000')")
    said = browser.value("document.querySelector('#axes').textContent")
    assert "no stop, cable 2 turns either way" in said and "-57.3\u00b0 to 28.6\u00b0" in said
    assert "30.000\u00b0 0.52360 rad" in said and "of 6.6 N m" in said and "5.73\u00b0/s" in said
    # once the trace moves the picture does, more often than the page asks for news
    still = browser.value(DOTS)
    browser.value("window.moving = true; 1")
    browser.until(f"{DOTS}[1] !== {still[1]}")
    frames, asked = browser.value("[seen.count.frames, window.asked]")
    browser.until(f"window.asked > {asked} + 10")
    assert browser.value("seen.count.frames") - frames > browser.value("window.asked") - asked
    # between two points of the trace it is between them
    shown = browser.value("[state_at(trace.time_s.at(-1) - .03).axes[0].at, trace.position_azimuth.slice(-3)]")
    assert shown[1][0] < shown[0] < shown[1][1]
    assert not browser.problems


#: mean height over the middle of the canvas of what has the colour of the boresight, the second axis standing somewhere
HEIGHT = """(() => { const c = document.querySelector("#antenna").cloneNode(); document.body.append(c);
c.style.cssText = "width: 600px; height: 600px; position: fixed; top: 0; left: 0";
const view = antenna_view(c, name => name === "measured" ? "#ff00ff" : "#808080", ["azimuth", "tilt"]);
const axis = at => ({at, second: null, torque: null, most: null, low: -1.5, high: 1.5});
view.show({heard: true, boresight: %s, base: null, axes: [axis(0), axis(%f)]});
const d = c.getContext("2d").getImageData(0, 0, c.width, c.height).data; let n = 0, sum = 0;
for (let k = 0; k < d.length; k += 4) if (d[k] > 240 && d[k + 1] < 20 && d[k + 2] > 240) {
  n += 1; sum += Math.floor(k / 4 / c.width); }
c.remove(); return c.height / 2 - sum / n; })()"""


@in_a_browser
def test_a_positive_second_angle_raises_an_antenna_that_looks_along_minus_x(browser: Browser) -> None:
    def height(boresight: str, at: float) -> float:
        return float(browser.value(HEIGHT % (json.dumps(boresight), at)))

    assert height("-x", 0.7) > height("-x", 0.0) > height("-x", -0.7)
    assert height("x", 0.7) < height("x", 0.0) < height("x", -0.7)
    # and both look the same way where they are level
    assert height("-x", 0.0) == height("x", 0.0)
    assert not browser.problems


@in_a_browser
def test_keys_turn_the_view_only_while_it_has_the_focus_and_it_rests_out_of_view(browser: Browser) -> None:
    before = browser.value(DOTS)
    browser.press("ArrowLeft", 37)
    assert browser.value(DOTS) == before
    browser.value("document.querySelector('#antenna').focus({preventScroll: true}); 1")
    browser.press("ArrowLeft", 37)
    turned = browser.value(DOTS)
    assert turned != before
    browser.press("+")
    assert browser.value(DOTS) != turned
    browser.press("Home", 36)
    assert browser.value(DOTS) == before
    # what else keys do here stays
    browser.press("a")
    assert browser.value("document.querySelector('#arm').getAttribute('aria-pressed')") == "true"
    # on a phone nothing is wider than the screen
    browser.resize(390, 800)
    browser.until("document.documentElement.scrollWidth <= 390")
    browser.until(f"{DOTS}[0] > .05")
    browser.value("document.querySelector('#captures').scrollIntoView(); 1")
    browser.until(
        "new Promise(done => { const n = seen.count.frames; setTimeout(() => done(seen.count.frames === n), 500) })"
    )
    browser.value("scrollTo(0, 0); 1")
    frames = browser.value("seen.count.frames")
    browser.until(f"seen.count.frames > {frames}")
    assert not browser.problems


def test_page_and_drawing_are_small_and_are_one_document() -> None:
    assert "antenna_view" in ANTENNA_SCRIPT and ANTENNA_SCRIPT in PAGE and "/*" not in PAGE.split("<script>")[1]
    assert len(PAGE.encode()) < 300_000


def test_the_view_tells_limits_in_force_and_the_attitude_of_a_base_that_is_heard() -> None:
    settings = shipped_settings()
    limits = limits_in_force(settings)
    assert limits["inner"] == {
        "position_low_rad": -2.0, "position_high_rad": 2.0, "cable_wrap_turns": None, "torque_nm": 6.6,
    }  # fmt: skip
    assert limits["outer"]["position_low_rad"] is None and limits["outer"]["cable_wrap_turns"] == 2.0
    view = LiveView(1_000_000, limits=lambda: limits)
    assert view.status()["limits"] == limits and view.status()["boresight"] == "x"
    row = np.zeros(1, TICK_ROW)
    view.take([Exchange(row.tobytes(), b"", b"")])
    assert np.isnan(view.trace(-1.0)["base_roll"]).all()
    row["time_ns"] = 1_000_000_000
    view.take(
        [
            Exchange(
                row.tobytes(),
                record_of("base_attitude", roll=0.1, pitch=-0.2) + record_of("base_heading", yaw=1.0),
                b"",
            )
        ]
    )
    base = [view.trace(0.5)[name][0] for name in ("base_roll", "base_pitch", "base_yaw")]
    assert base == pytest.approx([0.1, -0.2, 1.0], abs=1e-4)


def record_of(name: str, **values: float) -> bytes:
    """A frame's record with these fields; an onlooker checks no CRC."""
    message = schema.BY_NAME[name]
    word = 0
    for field in message.fields:
        raw = round(values.get(field.name, 0.0) / field.step)
        word |= (raw & ((1 << field.bits) - 1)) << message.start(field.name)
    return message.can_id.to_bytes(2, "little") + word.to_bytes(8, "little")


def test_a_stop_is_told_in_the_words_of_its_guard_and_since_when() -> None:
    for cause in GUARD_CAUSES:
        found = trouble_of("fault", word_of(cause), "none", "", 1.0)
        assert found is not None and found.look_at and found.happens and found.left_by and found.why, cause
        assert "`" not in "".join(map(str, found.as_dict().values()))
        assert trouble_of("idle", word_of(cause), "none", "", 1.0) is None
    drive = trouble_of("fault", "drive_fault", "undervoltage", "brown-out", 1.0)
    assert drive is not None and (drive.what, drive.why) == (
        "drive fault undervoltage",
        "supply below 18 V (brown-out)",
    )
    both = trouble_of("fault", "overspeed", "none", "", 1.0, ("pan", "tilt"))
    assert both is not None and both.what == "overspeed on pan and tilt"
    operator = trouble_of("fault", "operator", "none", "", 1.0)
    assert (
        operator is not None and "operator" in operator.what and trouble_of("stopping", "operator", "", "", 1.0) is None
    )
    assert told_state("fault", "operator") == operator.what
    for drive_state, is_over in ((DriveState.QUICK_STOP_ACTIVE, False), (DriveState.SWITCH_ON_DISABLED, True)):
        for cause in ("operator", "overspeed"):
            stop = trouble_of("fault", cause, "none", "", 1.0, (), drive_state)
            assert stop is not None and stop.happens.startswith("the drive gives no torque (the stop was: ") is is_over
    assert [told_state(*one) for one in (("idle", "none"), ("active", "operator"), ("fault", "gyro_stuck"))] == [
        "idle",
        "active, by an operator's command",
        "fault, by gyro stuck",
    ]
    view, row = LiveView(1_000_000), np.zeros(1, TICK_ROW)
    row["host_state"] = HostState.STOPPING
    for seconds, state in ((2, "stopping"), (3, "fault"), (9, None)):
        row["time_ns"] = seconds * 1_000_000_000
        view.take([Exchange(row.tobytes(), b"", b"")])
        if state:
            view.tripped("overspeed", "pan")
            view.state_changed(state, "overspeed")
            assert view.status()["trouble"]["what"] == "overspeed on pan"
    # braking and then fault of the same guard is one stop
    assert view.status()["trouble"]["since_s"] == 2.0
    view.state_changed("waiting", "operator")
    row["host_state"] = HostState.WAITING
    view.take([Exchange(row.tobytes(), b"", b"")])
    assert view.status()["trouble"] is None
    view.tripped("runaway", "tilt")
    view.state_changed("fault", "overspeed")
    row["host_state"] = HostState.FAULT
    view.take([Exchange(row.tobytes(), b"", b"")])
    # of an earlier stop, or of another guard, no axis is told
    assert view.stopped_s == 9.0 and view.status()["trouble"]["what"] == "overspeed"


@in_a_browser
def test_a_stop_has_one_banner_and_set_points_are_told_in_degrees(browser: Browser) -> None:
    assert browser.value("document.querySelector('#trouble').hidden") is True
    found = trouble_of("fault", "runaway", "none", "<i>", 1.5)
    assert found is not None
    browser.value(f"Object.assign(window.told.status, {{trouble: {json.dumps(found.as_dict())}, time_ns: 4.6e9}}); 1")
    browser.until("!document.querySelector('#trouble').hidden")
    said = browser.value("document.querySelector('#trouble').textContent")
    assert "Stopped: runaway for 3 s (since 1.5 s of the run)Over 30 ms the axis gains" in said
    assert "Look at phases and sign of the motor" in said and "Arm, then Reset fault" in said
    assert browser.value("document.querySelectorAll('#trouble i').length") == 0
    # what happens now changes within one stop, of which the rest is not told once more
    browser.value("window.first = document.querySelector('#trouble b'); window.told.status.trouble.happens = 'rest'; 1")
    browser.until("document.querySelector('#trouble_now').textContent === 'Now: rest.'")
    assert browser.value("document.querySelector('#trouble b') === window.first") is True
    browser.value("(f => { f.value = '0.5'; f.oninput(); })(document.querySelector('#to_tilt')); 1")
    assert browser.value("document.querySelector('#deg_tilt').textContent") == "rad (28.65\u00b0)"
    browser.value("window.told.status.trouble = null; 1")
    browser.until("document.querySelector('#trouble').hidden")
    assert not browser.problems
