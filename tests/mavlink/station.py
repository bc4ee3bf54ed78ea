"""A ground station with a bridge and a daemon of its own, over UDP on loopback, in real time."""

from __future__ import annotations

import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from gimbal_hil.realtime.operator import OperatorClient
from tests.daemon.daemons import PATIENCE_S, RunningDaemon
from tests.mavlink.parts import NAN, dialect, mavutil


class Station:
    """A ground station on the other end of the link; `hears` answers the first message for which a test holds."""

    def __init__(self, port: int) -> None:
        self._link = mavutil.mavlink_connection(
            f"udpout:127.0.0.1:{port}", source_system=255, source_component=190, dialect="common"
        )
        self.mav, self._next_s = self._link.mav, 0.0

    def hears(self, kind: str, holds: Callable[[Any], bool] = lambda message: True, beating: bool = True) -> Any:
        end = time.monotonic() + PATIENCE_S
        while time.monotonic() < end:
            if beating and time.monotonic() >= self._next_s:
                self.mav.heartbeat_send(dialect.MAV_TYPE_GCS, 8, 0, 0, 4)
                self._next_s = time.monotonic() + 0.2
            message = self._link.recv_match(blocking=True, timeout=0.05)
            if message is not None and message.get_type() == kind and holds(message):
                return message
        raise AssertionError(f"no {kind} for which it holds")

    def points(self, pitch_deg: float, yaw_deg: float, flags: int = 0) -> int:
        """Result of a command to look there."""
        number = dialect.MAV_CMD_DO_GIMBAL_MANAGER_PITCHYAW
        self.mav.command_long_send(1, 154, number, 0, pitch_deg, yaw_deg, NAN, NAN, flags, 0, 0)
        return int(self.hears("COMMAND_ACK").result)


@contextmanager
def session(run: Path) -> Iterator[tuple[Station, RunningDaemon, OperatorClient, subprocess.Popen[bytes]]]:
    """A station that has heard the gimbal, the daemon that records into `run` and is idle, a client, the bridge."""
    port = free_port()
    with RunningDaemon(run) as daemon:
        client = daemon.client()
        daemon.until_state(client, "idle")
        words = ["mavlink", str(daemon.run), "--link", f"udpin:127.0.0.1:{port}"]
        bridge = subprocess.Popen([sys.executable, "-c", "from gimbal_hil.surface.cli import main; main()", *words])
        try:
            station = Station(port)
            station.hears("HEARTBEAT", lambda message: message.type == dialect.MAV_TYPE_GIMBAL)
            yield station, daemon, client, bridge
        finally:
            bridge.kill()
            bridge.wait()


def free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as held:
        held.bind(("127.0.0.1", 0))
        return int(held.getsockname()[1])
