"""A daemon as Foxglove sees it: what is told, and that a websocket client of its protocol gets all of it."""

from __future__ import annotations

import json
import math
import struct
import threading
import time
from typing import Any, cast

import numpy as np
import pytest

from gimbal_hil.data.runs import TICK_ROW
from gimbal_hil.realtime.foxglove import FoxgloveServer, axis_message, layout_of, log_level, rotations, serve
from gimbal_hil.realtime.foxglove.telling import along_boresight
from gimbal_hil.realtime.operator import OperatorClient
from gimbal_hil.realtime.telemetry import LiveView
from gimbal_hil.realtime.telemetry.records import Exchange
from sim_backend.boresight import Boresight

pytestmark = pytest.mark.realtime
AXES = ("azimuth", "tilt")
EVENT = {"time_ns": 7, "kind": "fault", "text": "active to fault (runaway)", "data": {"code": "state"}}


def status(**changes: Any) -> dict[str, Any]:
    view, row = LiveView(1_000_000, AXES), np.zeros(1, TICK_ROW)
    row["position_ref_outer"], row["position_ref_inner"], row["time_ns"] = 0.3, math.nan, 5_000_000_000
    view.take([Exchange(row.tobytes(), b"", b"")])
    found: dict[str, Any] = json.loads(json.dumps(view.status(), allow_nan=False))
    return found | {"observer": {"state": "off"}, "position_rad": {"azimuth": 0.5, "tilt": -0.25}} | changes


def turned(quaternion: tuple[float, float, float, float], vector: np.ndarray) -> np.ndarray:
    x, y, z, w = quaternion
    axis = np.array([x, y, z])
    return np.asarray(vector + 2.0 * w * np.cross(axis, vector) + 2.0 * np.cross(axis, np.cross(axis, vector)))


def test_an_axis_is_told_in_radians_and_degrees_and_what_is_not_known_is_null() -> None:
    told = axis_message(status(), "azimuth")
    assert told["position_deg"] == pytest.approx(28.6479, abs=1e-4) and told["position_ref_rad"] == 0.3
    other = axis_message(status(position_rad={"azimuth": 0.5, "tilt": None}), "tilt")
    assert other["position_rad"] is other["position_deg"] is other["position_ref_deg"] is None
    assert log_level(EVENT) == "Error" and log_level({"kind": "segment"}) == "Info"


def test_frames_turn_as_the_contract_says_on_a_base_that_is_tilted() -> None:
    base = {"roll": 0.2, "pitch": -0.3, "yaw": 1.1}
    found = rotations(status(base_attitude_rad=base))
    assert {frame: parent for frame, (parent, _) in found.items()} == {
        "base": "world", "azimuth": "base", "tilt": "azimuth", "azimuth_reference": "base",
        "tilt_reference": "azimuth_reference",
    }  # fmt: skip
    x = np.array([1.0, 0.0, 0.0])
    in_base = turned(found["azimuth"][1], turned(found["tilt"][1], x))
    # a positive second angle lowers the boresight, z being up
    level = math.cos(-0.25)
    assert in_base == pytest.approx([level * math.cos(0.5), level * math.sin(0.5), math.sin(0.25)])
    cr, sr, cp, sp, cy, sy = (f(base[k]) for k in ("roll", "pitch", "yaw") for f in (math.cos, math.sin))
    attitude = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]]) @ np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    attitude = attitude @ np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    assert turned(found["base"][1], in_base) == pytest.approx(attitude @ in_base)


class Daemon:
    """Answers like the operator's door: the run goes on by a tick a question, and one event comes."""

    def __init__(self) -> None:
        self.asked: list[str] = []

    def request(self, command: str, /, **_: object) -> dict[str, Any]:
        self.asked.append(command)
        return {"ok": True, "status": status(time_ns=20_000_000 * len(self.asked), tick=len(self.asked))}

    def next_event(self, timeout_s: float) -> dict[str, Any] | None:
        time.sleep(timeout_s)
        return EVENT


def test_a_client_of_the_websocket_protocol_gets_signals_state_events_frames_and_bodies() -> None:
    pytest.importorskip("foxglove", reason="the extra foxglove is not installed")
    websocket = pytest.importorskip("websockets.sync.client", reason="websockets is not installed")
    daemon, going = Daemon(), threading.Event()
    with FoxgloveServer(AXES, 0) as server:
        serving = threading.Thread(
            target=serve, args=(cast(OperatorClient, daemon), server, 0.02, lambda: not going.is_set())
        )
        serving.start()
        try:
            with websocket.connect(f"ws://127.0.0.1:{server.port}", subprotocols=["foxglove.sdk.v1"]) as connection:
                topics, got = {}, dict[str, bytes]()
                while set(got) != {"/state", "/events", "/tf", "/antenna", "/axes/azimuth", "/axes/tilt"}:
                    message = connection.recv(timeout=30)
                    if isinstance(message, str):
                        document = json.loads(message)
                        if document["op"] == "serverInfo":
                            assert document["name"] == "gimbal-hil"
                        for channel in document.get("channels", []):
                            topics[channel["id"]] = channel["topic"]
                            wanted = {"id": channel["id"], "channelId": channel["id"]}
                            connection.send(json.dumps({"op": "subscribe", "subscriptions": [wanted]}))
                    elif message[0] == 1:
                        # opcode, subscription, time
                        subscription, time_ns = struct.unpack_from("<IQ", message, 1)
                        got[topics[subscription]] = message[13:]
                        assert time_ns == 7 or time_ns % 20_000_000 == 0
        finally:
            going.set()
            serving.join()
    assert json.loads(got["/axes/azimuth"])["position_rad"] == 0.5
    assert json.loads(got["/state"])["host_state"] == "waiting"
    assert b"active to fault (runaway)" in got["/events"] and b"azimuth_reference" in got["/tf"]
    assert b"tilt" in got["/antenna"]
    assert set(daemon.asked) == {"status"}


@pytest.mark.parametrize("looks", Boresight)
def test_dish_and_arrow_are_turned_along_the_boresight_of_the_model(looks: Boresight) -> None:
    lying, pointing = along_boresight(looks)
    ahead = pytest.approx([looks.sign, 0.0, 0.0])
    assert turned(lying, np.array([0.0, 0.0, 1.0])) == ahead
    assert turned(pointing, np.array([1.0, 0.0, 0.0])) == ahead


def test_the_layout_names_the_topics_of_these_axes() -> None:
    pytest.importorskip("foxglove", reason="the extra foxglove is not installed")
    text = layout_of(AXES)
    assert json.loads(text)["content"]["type"] == "split"
    assert all(topic in text for topic in ("/axes/azimuth.position_deg", "/axes/tilt.torque_nm", "/state", "/events"))
