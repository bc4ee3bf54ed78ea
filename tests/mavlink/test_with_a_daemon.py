"""A ground station's session with a running daemon, over UDP on loopback, in real time."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest
from pymavlink.quaternion import QuaternionBase

from tests.mavlink.parts import NAN, dialect
from tests.mavlink.station import session

pytestmark = pytest.mark.realtime


def test_a_session_of_a_ground_station(tmp_path: Path) -> None:
    with session(tmp_path / "run") as (station, daemon, client, bridge):
        assert station.points(10.0, 20.0) == dialect.MAV_RESULT_ACCEPTED

        def looks_there(message: Any) -> bool:
            _, pitch, yaw = QuaternionBase(list(message.q)).euler
            return abs(pitch - math.radians(10.0)) < 0.01 and abs(yaw - math.radians(20.0)) < 0.01

        station.hears("GIMBAL_DEVICE_ATTITUDE_STATUS", looks_there)
        # beyond the travel of the inner joint: the daemon refuses, and goes on
        assert station.points(80.0 + 90.0, 0.0) == dialect.MAV_RESULT_DENIED
        assert client.request("status")["status"]["host_state"] == "active"
        # a station that has gone
        station.hears("GIMBAL_MANAGER_STATUS", lambda message: message.primary_control_sysid == 0, beating=False)
        daemon.until_state(client, "idle")
        # heard again it may turn by rates, and the bridge dies in motion
        station.hears("GIMBAL_DEVICE_ATTITUDE_STATUS")
        station.mav.gimbal_manager_set_pitchyaw_send(1, 154, 0, 1, NAN, NAN, 0.0, 0.2)
        daemon.until_state(client, "active")
        bridge.kill()
        daemon.until_state(client, "idle")
        client.request("shut_down")
        assert daemon.wait()[0] == 0
