"""A ground station's session with a running daemon as a picture: `python -m tests.mavlink.picture OUT.svg`."""

from __future__ import annotations

import json
import math
import sys
import tempfile
import time
from bisect import bisect
from collections.abc import Callable
from pathlib import Path

from pymavlink.quaternion import QuaternionBase

from gimbal_hil.pages.plots import stacked, write_picture
from tests.mavlink.parts import NAN, dialect
from tests.mavlink.station import Station, session

#: attitude messages a second that the station asks for
_HZ = 25


class Watched:
    """What a station heard and said, by its own clock."""

    def __init__(self, station: Station) -> None:
        self.station, self.began = station, time.monotonic()
        self.rows: list[tuple[float, float, float]] = []
        self.said: list[tuple[float, str]] = []

    def says(self, text: str) -> None:
        """A word of the picture at this time."""
        self.said.append((time.monotonic() - self.began, text))

    def turn(self, yaw_rad_s: float) -> None:
        """Ask for a yaw rate."""
        self.station.mav.gimbal_manager_set_pitchyaw_send(1, 154, 0, 1, NAN, NAN, 0.0, yaw_rad_s)

    def looks(self, seconds: float, beating: bool = True, turning_rad_s: float | None = None) -> None:
        """Hear attitudes for some time; a yaw rate is repeated."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            if turning_rad_s is not None:
                self.turn(turning_rad_s)
            message = self.station.hears("GIMBAL_DEVICE_ATTITUDE_STATUS", beating=beating)
            _, pitch, yaw = QuaternionBase(list(message.q)).euler
            self.rows.append((time.monotonic() - self.began, math.degrees(pitch), math.degrees(yaw)))


def act(watched: Watched, state: Callable[[], str]) -> None:
    """Point, be refused, turn at a rate, come back, lose the heartbeat."""
    station = watched.station
    interval = dialect.MAVLINK_MSG_ID_GIMBAL_DEVICE_ATTITUDE_STATUS, 1e6 / _HZ
    station.mav.command_long_send(1, 154, dialect.MAV_CMD_SET_MESSAGE_INTERVAL, 0, *interval, 0, 0, 0, 0, 0)
    watched.looks(1.0)
    results = {getattr(dialect, name): name for name in ("MAV_RESULT_ACCEPTED", "MAV_RESULT_DENIED")}
    for pitch, yaw in ((10.0, 20.0), (170.0, 0.0)):
        result = results[station.points(pitch, yaw)].removeprefix("MAV_RESULT_")
        watched.says(f"PITCHYAW {pitch:g}, {yaw:g}: {result}")
        watched.looks(3.0)
    watched.says("yaw rate -6 deg/s, told once: braked after 1 s")
    watched.turn(math.radians(-6.0))
    watched.looks(3.0)
    flags = dialect.GIMBAL_MANAGER_FLAGS_NEUTRAL
    result = results[station.points(NAN, NAN, flags)].removeprefix("MAV_RESULT_")
    watched.says(f"NEUTRAL: {result}")
    watched.looks(2.0)
    watched.says("yaw rate 6 deg/s, repeated without heartbeats: braked")
    watched.looks(6.0, False, math.radians(6.0))
    assert state() == "idle"


def recorded() -> Watched:
    """A session through a bridge and a daemon of their own."""
    with tempfile.TemporaryDirectory() as place, session(Path(place) / "run") as (station, daemon, client, _):
        watched = Watched(station)
        act(watched, lambda: str(client.request("status")["status"]["host_state"]))
        client.request("shut_down")
        daemon.wait()
        return watched


def main(out: Path) -> None:
    """Write the picture, and print what was said."""
    watched = recorded()
    drawn = stacked(
        ("A ground station points the antenna over MAVLink, in real time", ""),
        "time in s",
        ("pitch in degrees", "yaw in degrees"),
    )
    times = [row[0] for row in watched.rows]
    for panel in (1, 2):
        values = [row[panel] for row in watched.rows]
        drawn.add_scatter(row=panel, x=times, y=values, mode="lines", showlegend=False)
        for at, text in watched.said:
            value = values[min(bisect(times, at), len(values) - 1)]
            drawn.add_vline(at, row=panel, color="#999999", width=1, dash="dot")
            drawn.add_scatter(
                row=panel, x=[at], y=[value], mode="markers", name=f"{at:.1f} s: {text}", showlegend=panel == 1
            )
    write_picture(drawn, out)
    print(json.dumps([[round(at, 2), text] for at, text in watched.said], indent=1))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
