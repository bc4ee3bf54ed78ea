"""Gains and limits changed while the daemon runs: within their bounds, in force with one tick, logged, replayed."""

from __future__ import annotations

import http.client
import json
import os
import pty
import socket
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.runs import EventKind, open_run, replay
from gimbal_hil.loop.host import Host, layout
from gimbal_hil.loop.settings import (
    adjustable_numbers,
    adjusted,
    host_configuration,
    merged,
    settings_from_document,
    shipped_settings,
)
from gimbal_hil.loop.settings.shipped import shipped_settings_path
from gimbal_hil.realtime.dashboard.server import TOKEN_HEADER
from gimbal_hil.realtime.lockstep import give_again, host_of
from gimbal_hil.realtime.operator import Door, OperatorClient
from gimbal_hil.realtime.operator.client import RequestRefusedError
from tests.daemon.daemons import RunningDaemon

pytestmark = pytest.mark.realtime
Json = dict[str, Any]


def shipped_document() -> Json:
    document: Json = yaml.safe_load(shipped_settings_path().read_text())
    return document


def page_acts(port: int, token: str, **request: object) -> Json:
    """What the live page does when a button is pressed."""
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=20)
    headers = {"Content-Type": "application/json", TOKEN_HEADER: token}
    connection.request("POST", "/act", body=json.dumps(request), headers=headers)
    answer: Json = json.loads(connection.getresponse().read())
    connection.close()
    return answer


def free_port() -> int:
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return int(found.getsockname()[1])


def test_a_run_with_changed_gains_is_replayed_bit_for_bit_and_not_without_them(tmp_path: Path) -> None:
    run, port = tmp_path / "run", free_port()
    with RunningDaemon(run, "--duration", "60", "--page", str(port)) as daemon, daemon.client() as client:
        daemon.until_state(client, "idle")
        client.when_ready("set_point", mode="position", outer=0.3, inner=-0.2, over_s=0.5)
        client.request("adjust", outer={"rate_loop.kp_s_per_rad": 45.0, "limits.torque_nm": 7.99})
        time.sleep(0.4)
        # the second change keeps the first
        token = Door.read(run).token
        assert page_acts(port, token, command="adjust", inner={"position_loop.kp_per_s": 12.0})["ok"]
        assert not page_acts(port, "0" * 64, command="adjust_back")["ok"]
        changed = [one for one in client.request("adjustable")["numbers"] if one["value"] != one["configured"]]
        told = client.request("status")["status"]["adjusted"]
        time.sleep(0.3)
        back = page_acts(port, token, command="adjust_back")["tick"]
        assert not client.request("status")["status"]["adjusted"]
        client.request("shut_down")
        assert daemon.wait()[0] == 0
    assert {(one["axis"], one["key"]) for one in changed} == {
        ("outer", "rate_loop.kp_s_per_rad"),
        ("outer", "limits.torque_nm"),
        ("inner", "position_loop.kp_per_s"),
    }
    assert "outer rate_loop.kp_s_per_rad 45 (configured 60)" in told
    log = open_run(run)
    commands = [event for event in log.events if event.data.get("command") == "adjust"]
    assert len(commands) == 3 and all(event.kind is EventKind.COMMAND for event in commands)
    assert commands[-1].tick == back and commands[-1].data["values"] == {}
    host = host_of(log)
    assert replay(log, host, lambda event: give_again(host, log, event)).identical
    # they did act: without the commands the same frames give other torques
    unchanged = host_of(log)
    again = replay(
        log, unchanged, lambda event: None if event in commands else give_again(unchanged, log, event)
    ).difference
    assert again is not None and commands[0].tick <= again.tick <= commands[1].tick


def test_a_number_beyond_its_bounds_or_without_any_is_refused_and_nothing_changes(tmp_path: Path) -> None:
    with RunningDaemon(tmp_path / "run", "--duration", "60") as daemon, daemon.client() as client:
        daemon.until_state(client, "idle")
        for changes, said in (
            ({"outer": {"rate_loop.kp_s_per_rad": 81.0}}, "beyond axes.outer.adjustable; expected 40 to 80"),
            ({"outer": {"limits.torque_nm": 15.6}}, "expected 2 to 15.5"),
            ({"outer": {"rate_loop.tracking_time_s": 0.1}}, "may not be changed while the daemon runs"),
            ({"outer": {"limits.cable_wrap_turns": 1.0}}, "may not be changed while the daemon runs"),
            ({"azimuth": {"rate_loop.kp_s_per_rad": 50.0}}, "azimuth"),
            ({"outer": {"rate_loop.kp_s_per_rad": "50"}}, "outer"),
            ({}, "names no number"),
        ):
            with pytest.raises(RequestRefusedError, match=said.replace(".", r"\.")):
                client.request("adjust", **changes)
        assert all(one["value"] == one["configured"] for one in client.request("adjustable")["numbers"])
        # a limit that the axis is beyond already would stop it at once
        client.when_ready("set_point", mode="position", inner=-0.4, over_s=0.5)
        deadline = time.monotonic() + 20.0
        while client.request("status")["status"]["position_rad"]["inner"] > -0.35 and time.monotonic() < deadline:
            time.sleep(0.02)
        with pytest.raises(RequestRefusedError, match=r"inner stands at -0.[34]"):
            client.request("adjust", inner={"limits.position_low_rad": -0.25})
        # and a set-point is held to the limit that is in force, not to the one of the file
        client.request("adjust", inner={"limits.position_high_rad": 0.3})
        with pytest.raises(RequestRefusedError, match=r"expected -2 to 0\.3 rad"):
            client.request("set_point", mode="position", inner=0.5)


@pytest.mark.parametrize(
    ("bounds", "said"),
    [
        ({"rate_loop.kp_s_per_rad": [90.0, 61.0]}, "expected least and largest value"),
        ({"limits.position_low_rad": [-1.0, 1.0]}, "the number itself is not given"),
        ({"rate_loop.ki_per_rad": [-1.0, 1800.0]}, "is negative"),
        ({"rate_loop.tracking_time_s": [0.0, 1.0]}, "adjustable"),
    ],
)
def test_bounds_that_make_no_sense_are_refused_at_the_door(bounds: Json, said: str) -> None:
    document = shipped_document()
    document["axes"]["outer"]["adjustable"] = bounds
    with pytest.raises(BadInputError, match=said):
        settings_from_document(document, "antenna.yaml")


def test_bounds_never_loosen_a_limit_and_always_hold_the_configured_number() -> None:
    document = shipped_document()
    document["axes"]["inner"]["adjustable"] = {
        "rate_loop.kp_s_per_rad": [9.0, 12.0],
        "limits.torque_nm": [1.0, 16.0],
        "limits.position_low_rad": [-3.0, 0.0],
        "limits.position_high_rad": [0.1, 3.0],
    }
    numbers = adjustable_numbers(settings_from_document(document, "antenna.yaml"), {})
    assert {one.key: (one.low, one.high) for one in numbers if one.axis == "inner"} == {
        "rate_loop.kp_s_per_rad": (8.4, 12.0),
        "limits.torque_nm": (1.0, 6.6),
        "limits.position_low_rad": (-2.0, 0.0),
        "limits.position_high_rad": (0.1, 2.0),
    }


def test_what_fits_its_bounds_but_not_each_other_is_refused() -> None:
    settings = shipped_settings()
    with pytest.raises(BadInputError, match="position_low_rad is not below position_high_rad"):
        adjusted(settings, {"inner": {"limits.position_low_rad": 0.5, "limits.position_high_rad": 0.3}})


def test_a_number_back_at_its_configured_value_counts_as_unchanged_and_other_sections_stay_as_they_are() -> None:
    settings = shipped_settings()
    values = merged({"outer": {"rate_loop.kp_s_per_rad": 50.0}}, {"outer": {"limits.torque_nm": 8.0}}, settings)
    assert values == {"outer": {"rate_loop.kp_s_per_rad": 50.0, "limits.torque_nm": 8.0}}
    assert merged(values, {"outer": {"rate_loop.kp_s_per_rad": 60.0}}, settings) == {"outer": {"limits.torque_nm": 8.0}}
    before, after = host_configuration(settings), host_configuration(adjusted(settings, values))
    assert len(np.flatnonzero(before != after)) == 2
    assert np.array_equal(before, host_configuration(adjusted(settings, {})))


def test_a_smaller_torque_limit_holds_on_the_wire_too() -> None:
    settings = shipped_settings()
    host = Host(host_configuration(settings), settings.axis_names)
    host.adjust(host_configuration(adjusted(settings, {"inner": {"limits.torque_nm": 1.5}})))
    h = layout.axis_h(layout.INNER)
    most = host.memory.H[h + layout.MOST_TORQUE] * host.memory.H[h + layout.TORQUE_STEP]
    assert 1.49 < most <= 1.5


def test_the_command_shows_changes_and_takes_back_and_so_does_one_key_in_watch(tmp_path: Path) -> None:
    run = tmp_path / "run"
    with RunningDaemon(run, "--duration", "90") as daemon, daemon.client() as client:
        daemon.until_state(client, "idle")

        def adjust(*words: str) -> tuple[int, str]:
            line = [sys.executable, "-c", "from gimbal_hil.surface.cli import main; main()", "adjust", *words]
            done = subprocess.run([*line, "--run", str(run)], capture_output=True, text=True)
            return done.returncode, done.stdout + done.stderr

        code, said = adjust("outer.rate_loop.kp_s_per_rad=50")
        assert code == 0 and "50 *" in said and f"next: gimbal-hil adjust --back --run {run}" in said
        assert adjust("outer.rate_loop.kp_s_per_rad=5")[0] == 2 and adjust("outer=5")[0] == 2
        assert adjust("outer.rate_loop.kp_s_per_rad=50", "--back")[0] == 2
        code, said = adjust("--json")
        assert code == 0 and _value(json.loads(said), "rate_loop.kp_s_per_rad") == 50.0
        _press_in_watch(run, client)
        assert not client.request("status")["status"]["adjusted"]


def _value(answer: Json, key: str) -> float:
    (found,) = [one["value"] for one in answer["numbers"] if (one["axis"], one["key"]) == ("outer", key)]
    return float(found)


def _press_in_watch(run: Path, client: OperatorClient) -> None:
    """`b`, then `q`, in a terminal."""
    here, there = pty.openpty()
    line = [
        sys.executable,
        "-c",
        "from gimbal_hil.surface.cli import main; main()",
        "watch",
        str(run),
        "--every",
        "0.05",
    ]
    with subprocess.Popen(line, stdin=there, stdout=there, stderr=there) as watching:
        os.close(there)
        shown = b""
        while b"keys: s stop" not in shown:
            shown += os.read(here, 4096)
        assert b"not as configured: outer rate_loop.kp_s_per_rad 50" in shown
        os.write(here, b"b")
        while client.request("status")["status"]["adjusted"]:
            os.read(here, 4096)
        os.write(here, b"q")
        while watching.poll() is None:
            try:
                os.read(here, 4096)
            except OSError:  # the terminal has gone with its last user
                break
        assert watching.wait(20) == 0
    os.close(here)
