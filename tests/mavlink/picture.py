"""A ground station's session with a running daemon as a picture: `python -m tests.mavlink.picture OUT.svg`."""

from __future__ import annotations

import json
import math
import sys
import tempfile
import time
from pathlib import Path

from pymavlink.quaternion import QuaternionBase

from gimbal_hil.pages.plots import ALERT, MEASURED, REFERENCE, stacked, write_picture
from gimbal_hil.realtime.operator import OperatorClient
from tests.mavlink.parts import NAN, dialect
from tests.mavlink.station import Station, session

#: attitude messages a second that the station asks for
_HZ = 25
_FLAGS = "GIMBAL_DEVICE_ERROR_FLAGS_"


class Watched:
    """What a station heard and said, by its own clock."""

    def __init__(self, station: Station) -> None:
        self.station, self.began = station, time.monotonic()
        #: time, pitch and yaw that were told, those that were asked for (NaN: none), failure flags
        self.rows: list[tuple[float, float, float, float, float, int]] = []
        self.asked = (NAN, NAN)
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
            now = time.monotonic() - self.began
            told = math.degrees(pitch), math.degrees(yaw)
            self.rows.append((now, *told, *self.asked, int(message.failure_flags)))


def act(watched: Watched, client: OperatorClient) -> None:
    """Point, be refused, turn at a rate, come back, lose the heartbeat; then somebody else trips a guard."""
    station = watched.station
    interval = dialect.MAVLINK_MSG_ID_GIMBAL_DEVICE_ATTITUDE_STATUS, 1e6 / _HZ
    station.mav.command_long_send(1, 154, dialect.MAV_CMD_SET_MESSAGE_INTERVAL, 0, *interval, 0, 0, 0, 0, 0)
    watched.looks(1.0)
    results = {getattr(dialect, name): name for name in ("MAV_RESULT_ACCEPTED", "MAV_RESULT_DENIED")}
    for pitch, yaw in ((10.0, 20.0), (170.0, 0.0)):
        result = results[station.points(pitch, yaw)].removeprefix("MAV_RESULT_")
        watched.says(f"PITCHYAW {pitch:g}, {yaw:g}: {result}")
        watched.asked = (pitch, yaw) if result == "ACCEPTED" else watched.asked
        watched.looks(3.0)
    watched.says("yaw rate -6 deg/s, told once: braked after 1 s")
    watched.asked = (NAN, NAN)
    watched.turn(math.radians(-6.0))
    watched.looks(3.0)
    flags = dialect.GIMBAL_MANAGER_FLAGS_NEUTRAL
    result = results[station.points(NAN, NAN, flags)].removeprefix("MAV_RESULT_")
    watched.says(f"NEUTRAL: {result}")
    watched.asked = (0.0, 0.0)
    watched.looks(2.0)
    watched.asked = (NAN, NAN)
    watched.says("yaw rate 6 deg/s, repeated without heartbeats: braked")
    watched.looks(6.0, False, math.radians(6.0))
    assert client.request("status")["status"]["host_state"] == "idle"
    watched.looks(1.0)
    watched.says("an operator switches to torque, an axis falls towards its stop: a guard trips")
    client.when_ready("set_point", mode="torque", outer=-4.0, inner=0.0)
    watched.looks(3.0)


def _flags(bits: int) -> list[str]:
    """Names of the failure flags that are set."""
    found = {getattr(dialect, name): name.removeprefix(_FLAGS) for name in dir(dialect) if name.startswith(_FLAGS)}
    return [name for bit, name in sorted(found.items()) if bits & bit == bit]


def recorded() -> Watched:
    """A session through a bridge and a daemon of their own."""
    with tempfile.TemporaryDirectory() as place, session(Path(place) / "run") as (station, daemon, client, _):
        watched = Watched(station)
        act(watched, client)
        client.request("shut_down")
        daemon.wait()
        return watched


def main(out: Path) -> None:
    """Write the picture, and print what was said."""
    watched = recorded()
    drawn = stacked(
        ("A ground station points the antenna over MAVLink, in real time", "", ""),
        "time [s]",
        ("pitch [deg]", "yaw [deg]", "failure flags"),
        230,
    )
    times, pitch, yaw, asked_pitch, asked_yaw, flags = zip(*watched.rows, strict=True)
    for panel, told, asked in ((1, pitch, asked_pitch), (2, yaw, asked_yaw)):
        for name, values, colour, dash in (("told", told, MEASURED, "solid"), ("asked for", asked, ALERT, "dash")):
            line = dict(color=colour, dash=dash)
            drawn.add_scatter(row=panel, x=times, y=values, name=name, line=line, showlegend=panel == 1)
    raised = sorted({flag for one in flags for flag in _flags(one)})
    for level, flag in enumerate(raised, start=1):
        up = [level if flag in _flags(one) else NAN for one in flags]
        drawn.add_scatter(row=3, x=times, y=up, line=dict(color=ALERT, width=6), name=flag, showlegend=False)
    # above the flags there is room for what was said, and the fall at the end leaves the panels
    words = ["none", *raised]
    drawn.update_yaxes(3, range=[-0.6, len(raised) + 4.6], tickvals=list(range(len(words))), ticktext=words)
    for panel, ends in ((1, [-25.0, 19.0]), (2, [-5.0, 35.0])):
        drawn.update_yaxes(panel, range=ends)
    drawn.add_scatter(row=3, x=times, y=[NAN if one else 0 for one in flags], line=dict(color=MEASURED, width=6))
    for number, (at, text) in enumerate(watched.said, start=1):
        for panel in (1, 2, 3):
            drawn.add_vline(at, row=panel, color=REFERENCE, width=1, dash="dot")
        # under numbers, so that no word lies on a curve; what each means stands in the legend of the last panel
        drawn.add_scatter(row=3, x=[], y=[], mode="markers", name=f"{number}: {at:.1f} s, {text}")
        drawn.add_scatter(row=1, x=[at + 0.12], y=[16.0], mode="text", text=[str(number)], showlegend=False)
    write_picture(drawn, out)
    print(json.dumps([[round(at, 2), text] for at, text in watched.said], indent=1))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
