"""The live page and a report in a headless Chromium: keys, lamps, phone, dark, print, pictures. Skipped without one."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from gimbal_hil.data.runs import open_run
from gimbal_hil.pages.plots import figure
from gimbal_hil.pages.report import Details, Made, Page, Plot, Text
from gimbal_hil.realtime.dashboard.page import PAGE
from gimbal_hil.realtime.dashboard.server import live
from gimbal_hil.realtime.operator import Door
from gimbal_hil.realtime.telemetry import LiveView
from tests.browser import CHROMIUM, Browser
from tests.daemon.daemons import RunningDaemon
from tests.daemon.test_adjusting import free_port

pytestmark = [pytest.mark.realtime, pytest.mark.skipif(CHROMIUM is None, reason="there is no Chromium here")]
ACTIVE = "document.activeElement.id"


def lamp(browser: Browser, name: str) -> str:
    """Colour and words of a lamp."""
    spans = "[...document.querySelectorAll('#lamps span, #facts span')]"
    found = f"{spans}.find(s => s.textContent.startsWith({name!r}))"
    script = f"(s => s.querySelector('.lamp').className + ': ' + s.textContent)({found})"
    return str(browser.value(script))


def test_keys_act_and_lamps_tell_a_tripped_guard(tmp_path: Path) -> None:
    run, port = tmp_path / "run", free_port()
    with RunningDaemon(run, "--duration", "90", "--page", str(port)) as daemon, daemon.client() as client:
        daemon.until_state(client, "idle")
        with Browser() as browser:
            browser.open(
                f"http://127.0.0.1:{port}/#{Door.read(run).token}", "document.querySelectorAll('#plots canvas').length"
            )
            assert browser.value("document.querySelectorAll('#plots canvas').length") == 8
            assert lamp(browser, "guards").startswith("lamp green: guards none")
            browser.until("document.querySelector('#lamps').textContent.includes('deadman margin')")
            assert "of 250 ticks" in lamp(browser, "deadman margin")
            assert lamp(browser, "frames dropped") == "lamp green: frames dropped none"
            # two steps by keyboard: arm, then Go from the field of the first axis
            browser.value(
                "document.querySelector('#to_outer').value = 0.3; document.querySelector('#over').value = 1; 1"
            )
            assert browser.value("document.querySelector('#go').disabled") is True
            browser.value("document.activeElement.blur(); 1")
            browser.press("a")
            browser.until("!document.querySelector('#go').disabled")
            browser.value("document.querySelector('#to_outer').focus(); 1")
            browser.press("Enter")
            daemon.until_state(client, "active")
            # a changed gain, and the one key that takes it back
            client.request("adjust", outer={"rate_loop.kp_s_per_rad": 50.0})
            browser.until("document.querySelector('#lamps').textContent.includes('1 not as configured')")
            browser.value("document.activeElement.blur(); 1")
            browser.press("b")
            browser.until("!document.querySelector('#lamps').textContent.includes('not as configured')")
            # Escape stops from within a field too
            browser.value("document.querySelector('#over').focus(); 1")
            browser.press("Escape", 27)
            daemon.until_state(client, "idle", "stopping")
            client.request("quick_stop")
            daemon.until_state(client, "fault")
            browser.until("document.querySelector('#facts').textContent.includes('quick stop by an operator')")
            assert lamp(browser, "state").startswith("lamp red: state quick stop")
            # on a phone nothing is wider than the screen, and the stop is in view
            browser.resize(390, 800)
            browser.until("document.documentElement.scrollWidth <= 390")
            box = browser.value("(r => [r.top, r.bottom])(document.querySelector('#stop').getBoundingClientRect())")
            assert 0 <= box[0] < box[1] <= 800
            assert browser.printed().startswith(b"%PDF")
            assert not browser.problems
        client.request("shut_down")


#: N m a second up to more than holds the outer axis (0.26 N m), the inner one held
SLOW_TORQUE = {
    "outer": {"mode": "torque", "shape": "ramp", "parameters": [0.0, 0.1, 0.4]},
    "inner": {"mode": "position", "parameters": [0.0]},
    "duration_s": 6.0,
    "label": 1,
}


def test_the_scope_shows_a_break_away_and_every_tick_before_it(tmp_path: Path) -> None:
    run, port = tmp_path / "run", free_port()
    with RunningDaemon(run, "--duration", "90", "--page", str(port)) as daemon, daemon.client() as client:
        daemon.until_state(client, "idle")
        with Browser() as browser:
            browser.open(
                f"http://127.0.0.1:{port}/#{Door.read(run).token}", "document.querySelector('#scope').signal.value"
            )
            browser.value(
                "(f => { f.kind.value = 'window'; f.kind.onchange(); f.signal.value = 'rate_outer';"
                "f.low.value = -0.005; f.high.value = 0.005; f.before_s.value = 1; f.requestSubmit(); })"
                "(document.querySelector('#scope')); 1"
            )
            browser.until("document.querySelector('#scope_state').textContent === 'armed'")
            client.when_ready("segments", segments=[SLOW_TORQUE])
            browser.until("document.querySelector('#scope_state').textContent === 'done' && capture")
            shown = browser.value("({tick: capture.trigger_tick, ...capture.columns})")
            assert "triggered at tick" in browser.value("document.querySelector('#kept').textContent")
            drawn = "[...document.querySelectorAll('#captures canvas')].map(c => c.clientHeight > 0 && c.width > 300)"
            assert browser.value(drawn) == [True] * 6
            assert not browser.problems
        client.request("shut_down")
    time_s, rate = np.array(shown["time_s"]), np.array(shown["rate_outer"], float)
    at = int(np.argmin(np.abs(time_s)))
    assert time_s[at] == 0.0 and abs(rate[at]) > 0.005 and np.all(np.abs(rate[:at]) <= 0.005)
    # at the torque of its friction, from creeping on its bristles to sliding
    assert shown["torque_outer"][at] == pytest.approx(0.25, abs=0.03) and rate[-1] > 0.02
    assert time_s[0] == pytest.approx(-1.0, abs=0.05) and time_s[-1] == pytest.approx(0.5, abs=0.05)
    kept = open_run(run / "scope" / "0001").ticks
    assert kept["tick"].tolist() == (shown["tick"] + np.rint(time_s * 1e3).astype(int)).tolist()
    assert len(kept) == np.ptp(kept["tick"]) + 1 - kept["skipped_ticks"][1:].sum()


def number(key: str, value: float) -> dict[str, object]:
    return {"axis": "outer", "key": key, "value": value, "configured": 1.0, "low": 0.0, "high": 9.0}


def test_fields_follow_what_is_in_force_until_somebody_writes_and_only_what_was_written_is_sent(tmp_path: Path) -> None:
    told = live(LiveView(1_000_000), -1.0)
    told["status"]["position_rad"] = {"outer": 0.25, "inner": -0.5}
    told["adjustable"] = [number("a", 1.0), number("b", 2.0)]
    file = tmp_path / "page.html"
    file.write_text(PAGE)
    with Browser() as browser:
        browser.open(file.as_uri())
        browser.value(
            f"window.told = {json.dumps(told)}; window.fetch = async () => ({{json: async () => window.told}});"
            "window.post = (path, request) => (window.sent = request, Promise.resolve({ok: true})); 1"
        )
        browser.until("document.querySelector('#to_inner') && document.querySelector('#to_inner').value === '-0.5'")
        assert browser.value("document.querySelector('#to_outer').value") == "0.25"
        # one field written here, the other number changed by somebody else
        browser.value("document.getElementById('n_outer.a').value = '3'; 1")
        browser.value("window.told.adjustable[1].value = 5; 1")
        browser.until("document.getElementById('n_outer.b').value === '5'")
        browser.value("arm(true); document.querySelector('#adjust').requestSubmit(); 1")
        assert browser.value("window.sent") == {"command": "adjust", "outer": {"a": 3}}
        # one axis is moved, the other one stays where it is; an empty field is no zero
        browser.value("window.sent = null; document.querySelector('#to_outer').value = ''; 1")
        browser.value("arm(true); document.querySelector('#act').requestSubmit(); 1")
        assert browser.value("window.sent") is None
        browser.value("document.querySelector('#to_outer').value = '0.3'; 1")
        browser.value("arm(true); document.querySelector('#act').requestSubmit(); 1")
        moved = {"command": "set_point", "mode": "position", "over_s": 2, "outer": 0.3, "inner": -0.5}
        assert browser.value("window.sent") == moved
        # a rate of 0.25 because an axis stands at 0.25 is nothing that anybody wants
        browser.value("const mode = document.querySelector('#mode'); mode.value = 'rate'; mode.onchange(); 1")
        browser.until("document.querySelector('#to_inner').value === '0'")
        assert browser.value("document.querySelector('#to_outer').value") in ("", "0")
        # written in degrees, sent in radians
        browser.value("mode.value = 'position'; const unit = document.querySelector('#unit'); unit.value = 'deg'; 1")
        browser.value("unit.onchange(); 1")
        browser.until("document.querySelector('#to_inner').value === '-28.6479'")
        browser.value("document.querySelector('#to_outer').value = '10'; 1")
        browser.value("arm(true); document.querySelector('#act').requestSubmit(); 1")
        sent = browser.value("window.sent")
        assert sent["outer"] == pytest.approx(np.radians(10.0)) and sent["inner"] == pytest.approx(-0.5, abs=1e-6)
        browser.value("unit.value = 'rad'; unit.onchange(); 1")
        # another process answers: the page begins anew
        browser.value("window.told.run = 'another'; 1")
        browser.until("window.told === undefined")


def page_of_figures() -> str:
    blocks = []
    for number in range(3):
        drawn = figure(f"Figure {number}", "time [s]", "torque [N m]")
        for name in ("measured", "model"):
            drawn.add_scatter(x=[0.0, 1.0, 2.0], y=[0.0, 1.0 + number, 0.5], name=name)
        blocks.append(Plot(drawn, "what one sees"))
    folded = Details("folded away", [blocks[2], blocks[0]])
    return Page("A title", "", [Text("words"), blocks[0], blocks[1], folded]).render(
        Made("2026-11-22T12:00:00Z", "0", "x")
    )


@pytest.mark.parametrize("dark", [False, True])
def test_a_report_draws_its_figures_hides_a_line_by_keyboard_saves_svg_and_prints(tmp_path: Path, dark: bool) -> None:
    path = tmp_path / "report.html"
    path.write_text(page_of_figures())
    with Browser(390 if dark else 1280, 900, dark) as browser:
        browser.open(path.as_uri(), "document.querySelectorAll('.plot[data-drawn]').length >= 2")
        assert browser.value("document.documentElement.scrollWidth") <= (390 if dark else 1280)
        shade = browser.value("getComputedStyle(document.body).backgroundColor.match(/\\d+/g).map(Number)")
        assert (sum(shade[:3]) < 200) is dark
        # the legend is a row of buttons
        browser.value("document.querySelector('.legend button').focus(); 1")
        browser.press("Enter", 13)
        browser.until("document.querySelector('.plot')._fullData[0].visible === false")
        # SVG: what the button saves is a drawing
        browser.value(
            "window.saved = ''; const made = URL.createObjectURL; URL.createObjectURL = b => "
            "{ b.text().then(t => { window.saved = t }); return made(b) };"
            "document.querySelector('.save button').click(); 1"
        )
        browser.until("window.saved.includes('<svg')")
        # a folded figure, shown twice on the page and stored once, draws when it is opened
        browser.value(
            "document.querySelector('details').open = true; document.querySelector('details').scrollIntoView(); 1"
        )
        browser.until("[...document.querySelectorAll('.plot')].every(p => p.dataset.drawn)")
        held = browser.value("[...document.querySelectorAll('.plot')].map(p => p._fullLayout ? p.data[0].y[1] : null)")
        assert held == [1.0, 2.0, 3.0, 1.0]
        pdf = browser.printed()
        assert pdf.startswith(b"%PDF") and len(pdf) > 10_000
        # PDF of one figure: what is printed then is a sheet of its size with nothing else, and only once
        browser.value(
            "window.print = () => { window.asked = true }; document.querySelectorAll('.save button')[1].click(); 1"
        )
        assert browser.value("window.asked && document.querySelectorAll('figure.chosen').length") == 1
        alone = browser.printed(preferCSSPageSize=True)
        sheets = re.findall(rb"/MediaBox \[0 0 (\d+)[.\d]* (\d+)", alone)
        assert len(sheets) == 1 and int(sheets[0][0]) == 540 and int(sheets[0][1]) < 500
        browser.until("!document.querySelector('figure.chosen')")
        assert len(re.findall(rb"/MediaBox", browser.printed())) >= 2
        assert not browser.problems
