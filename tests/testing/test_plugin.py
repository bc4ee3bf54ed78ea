"""The pytest plugin, and the assertions on signals."""

from __future__ import annotations

import os
import subprocess
import sys
import tomllib
from importlib.metadata import entry_points
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.runs import open_run, replay
from gimbal_hil.loop.settings import shipped_settings
from gimbal_hil.realtime.lockstep import give_again, host_of
from gimbal_hil.surface.testing import MadeStep, Signal, within
from gimbal_hil.surface.testing.antennas import antenna_of
from gimbal_hil.surface.testing.recorded import RecordedSignals

ROOT = Path(__file__).parents[2]
MODULE = "gimbal_hil.surface.testing.plugin"
#: what a user writes, as the page has it
USERS_FILE = (ROOT / "docs" / "how-to" / "testing.md").read_text().partition("```python\n")[2].partition("```")[0]


def users_pytest(folder: Path, text: str, *options: str) -> subprocess.CompletedProcess[str]:
    """pytest on a file in a folder of its own, with the plugin as an installation has it."""
    folder.mkdir(exist_ok=True)
    (folder / "test_mine.py").write_text(text)
    installed = any(one.value == MODULE for one in entry_points(group="pytest11"))
    named = [] if installed else ["-p", MODULE]
    words = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *named, "--junit-xml=junit.xml", *options]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    return subprocess.run(words, cwd=folder, env=environment, capture_output=True, text=True, check=False)


@pytest.mark.heavy
def test_a_users_file_of_ten_lines_is_run_and_a_failure_explains_itself(tmp_path: Path) -> None:
    assert len(USERS_FILE.splitlines()) <= 10
    before = antenna_of(shipped_settings(), tmp_path / "before")
    before.step("outer", 0.1, for_s=1.5)
    before.close()
    wrong = USERS_FILE.replace("def test_a_step", "def test_b_step").replace("settles_at(0.1,", "settles_at(0.15,")
    recorded = "".join(
        f"def test_travel_{name}(recorded_run):\n    assert recorded_run.signal('outer.position').largest() < {limit}\n"
        for name, limit in (("small", 0.05), ("large", 0.12))
    )
    text = USERS_FILE + wrong.partition("within\n")[2] + recorded
    done = users_pytest(
        tmp_path / "mine", text, "--gimbal-out", str(tmp_path / "runs"), "--gimbal-run", str(tmp_path / "before")
    )
    assert done.returncode == 1 and "2 failed, 2 passed" in done.stdout, done.stdout
    assert "outer.position settles within 0.002 of 0.15 for 0.5 s" in done.stdout
    assert "go to outer 0.1 rad" in done.stdout and "recorded in" in done.stdout and "test_travel_small" in done.stdout
    folder, _ = sorted((tmp_path / "runs").iterdir())
    run = open_run(folder)
    assert run.record.end is not None and len(run.ticks) > 2700
    host = host_of(run)
    assert replay(run, host, lambda event: give_again(host, run, event)).identical
    case = next(ElementTree.parse(tmp_path / "mine" / "junit.xml").iter("testcase"))
    assert [p.get("value") for p in case.iter("property")] == [str(folder)]


def test_a_signal_can_be_waited_for_while_it_is_recorded(tmp_path: Path) -> None:
    antenna = antenna_of(shipped_settings(), tmp_path / "run")
    try:
        antenna.go_to(inner=0.1)
        found = antenna.wait_until("inner.position", 0.1, within(0.001).for_s(0.2), at_most_s=3.0)
        assert found and 0.2 < antenna.now_s < 3.0
        assert not antenna.wait_until("inner.position", 0.2, within(0.001).for_s(0.2), at_most_s=0.5)
        with pytest.raises(BadInputError, match="azimuth"):
            antenna.go_to(azimuth=1.0)
    finally:
        antenna.close()
    recorded = RecordedSignals(tmp_path / "run")
    assert recorded.signal("inner.position").values[-1] == pytest.approx(0.1, abs=0.01)
    assert recorded.signal("inner.position_ref").values.max() == pytest.approx(0.1)
    with pytest.raises(BadInputError, match=r"no signal 'inner\.colour'"):
        recorded.signal("inner.colour")


def test_the_plugin_is_an_entry_point_and_loads_nothing_heavy() -> None:
    plugins = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["entry-points"]["pytest11"]
    assert plugins == {"gimbal": MODULE}
    code = f"import sys, {MODULE}; print([m for m in ('numpy', 'numba', 'pyarrow', 'pydantic') if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def ringing() -> tuple[Signal, MadeStep]:
    """A second-order response that overshoots by exp(-pi zeta / sqrt(1 - zeta^2)), zeta 0.5, at 2 rad/s."""
    time = np.arange(0.0, 20.0, 0.01)
    zeta, natural, after = 0.5, 2.0, np.clip(np.arange(0.0, 20.0, 0.01) - 1.0, 0.0, None)
    damped = natural * np.sqrt(1.0 - zeta**2)
    wave = np.cos(damped * after) + zeta / np.sqrt(1.0 - zeta**2) * np.sin(damped * after)
    return Signal("y", time, 1.0 - np.exp(-zeta * natural * after) * wave), MadeStep("y", 1.0, 0.0, 1.0)


def test_the_overshoot_of_a_known_response_is_what_theory_says() -> None:
    signal, step = ringing()
    assert signal.overshoot(step) == pytest.approx(np.exp(-np.pi * 0.5 / np.sqrt(0.75)), abs=1e-4)


def test_settling_is_the_last_entry_into_the_band_and_has_to_come_in_time() -> None:
    signal, step = ringing()
    outside = signal.time_s[np.abs(signal.values - 1.0) > 0.02].max()
    late = outside - step.time_s
    assert signal.settles_at(1.0, within(0.02).for_s(5.0).after(step, late + 0.02))
    assert not signal.settles_at(1.0, within(0.02).for_s(5.0).after(step, late - 0.1))
    assert signal.stays_at(1.0, within(0.02).for_s(5.0).after(float(outside) + 0.02))
    off = signal.stays_at(1.0, within(0.02).for_s(5.0).after(float(outside) - 0.05))
    assert not off and "off by" in repr(off)
    # a late machine leaves a gap, and behind it two sets in one tick: judged by what stands at its ends
    kept = np.flatnonzero((signal.time_s < late + 5.5) | (signal.time_s > late + 6.3))
    gap = Signal("y", signal.time_s[kept], signal.values[kept])
    assert gap.stays_at(1.0, within(0.02).for_s(5.0).after(late + 1.02))
    twice = Signal("y", np.concatenate([[0.0], signal.time_s]), np.concatenate([[0.0], signal.values]))
    assert "off by" in repr(twice.stays_at(1.0, within(0.02).for_s(5.0).after(float(outside) - 0.05)))
    assert twice.stays_at(1.0, within(0.02).for_s(5.0).after(float(outside) + 0.02))
    ends = signal.stays_at(1.0, within(0.02).for_s(5.0).after(18.0))
    assert not ends and "the signal ends at" in repr(ends)
    with pytest.raises(BadInputError, match="tolerance"):
        within(-0.1)
