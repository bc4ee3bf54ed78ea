"""Between a MAVLink link and a daemon: messages in, requests out, attitude and faults back."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

from firmware_protocol.errors import BadInputError, LinkError
from gimbal_hil.data.runs import GrowingLog
from gimbal_hil.loop.settings import DaemonSettings, Limits
from gimbal_hil.realtime.mavlink.gimbal import NOBODY, Gimbal
from gimbal_hil.realtime.mavlink.values import NOT_TOLD, Reach, Wish, seen_in
from gimbal_hil.realtime.operator import OperatorClient, RequestRefusedError
from sim_backend.boresight import Boresight

#: how long a look at the link may wait, and how often the daemon is asked
_WAIT_S, _ASK_S = 0.01, 0.05
#: messages that may come between two looks at the daemon
_MOST_AT_ONCE = 200


def reach_of(run: Path) -> Reach:
    """What the daemon that records into `run` lets its joints do; BadInputError where it is no daemon's run."""
    settings = DaemonSettings.model_validate(GrowingLog(run).record.header.configuration)
    limits = [axis.limits for axis in settings.axes.values()]

    def both(value: Callable[[Limits], float]) -> tuple[float, float]:
        return value(limits[0]), value(limits[1])

    def wrap(one: Limits) -> float:
        return math.inf if one.cable_wrap_turns is None else 2.0 * math.pi * float(one.cable_wrap_turns)

    return Reach(
        both(lambda one: -wrap(one) if one.position_low_rad is None else max(-wrap(one), one.position_low_rad)),
        both(lambda one: wrap(one) if one.position_high_rad is None else min(wrap(one), one.position_high_rad)),
        both(lambda one: one.rate_rad_s),
        settings.pointing.stow_rad,
        settings.pointing.boresight or Boresight.AHEAD,
    ).ahead()


def open_link(address: str, baud: int, system: int, component: int) -> tuple[Any, ModuleType]:
    """The link at an address as pymavlink writes them (`udpin:127.0.0.1:14550`, `udpout:...`, `tcp:...`, a serial
    port), and the dialect. BadInputError where pymavlink is not installed or the address cannot be opened.
    """
    # read by the library when it is imported
    os.environ["MAVLINK20"] = "1"
    try:
        from pymavlink import mavutil
        from pymavlink.dialects.v20 import common
    except ModuleNotFoundError:
        raise BadInputError(
            "mavlink", "needs the package pymavlink, which is not installed", "pip install 'gimbal-hil[mavlink]'"
        ) from None
    try:
        link = mavutil.mavlink_connection(
            address, baud=baud, source_system=system, source_component=component, dialect="common"
        )
    except (OSError, ValueError, IndexError, SystemExit) as error:
        expected = "udpin:127.0.0.1:14550, udpout:HOST:PORT, tcp:HOST:PORT or a serial port"
        raise BadInputError(f"--link {address}", f"cannot be opened ({error})", expected) from None
    return link, common


def serve(
    client: OperatorClient,
    link: Any,
    gimbal: Gimbal,
    tell: Callable[[str], None],
    go_on: Callable[[], bool],
    clock_s: Callable[[], float] = time.monotonic,
) -> None:
    """Until `go_on` says no, or the daemon ends (LinkError). What is asked has this client's lease: when this process
    ends, the joints are braked to rest.
    """
    bridge = _Bridge(client, link, gimbal, tell)
    try:
        while go_on():
            bridge.turn(clock_s)
    except OSError as error:
        raise LinkError(f"the MAVLink link has ended ({error})") from error


class _Bridge:
    """Both ends, turn by turn."""

    def __init__(self, client: OperatorClient, link: Any, gimbal: Gimbal, tell: Callable[[str], None]) -> None:
        self._client, self._link, self._gimbal, self._tell = client, link, gimbal, tell
        self._seen, self._ask_at_s = NOT_TOLD, 0.0
        self._guard, self._controller = "", gimbal.controller

    def turn(self, clock_s: Callable[[], float]) -> None:
        """Hear the daemon, hear the link, say what is due."""
        if clock_s() >= self._ask_at_s:
            self._seen = seen_in(self._client.request("status")["status"]).ahead(self._gimbal.boresight)
            self._ask_at_s = clock_s() + _ASK_S
        self._hear(clock_s)
        if (late := self._gimbal.overdue(clock_s())) is not None:
            self._tell(late[1])
            self._send(self._gimbal.text(late[1], severe=True))
            self._ask(late[0])
        for due in self._gimbal.due(self._seen, clock_s()):
            self._send(due)
        self._tell_changes()

    def _hear(self, clock_s: Callable[[], float]) -> None:
        """What has come; of a stream of set-points only the newest is asked for."""
        message, newest = self._link.recv_match(blocking=True, timeout=_WAIT_S), None
        for _ in range(_MOST_AT_ONCE):
            if message is None:
                break
            taken = self._gimbal.take(message, self._seen, clock_s())
            for answer in taken.answers:
                self._send(answer)
            newest = taken.wish or newest
            if taken.command is not None and newest is not None:
                self._send(self._gimbal.result(taken.command, self._ask(newest)))
                newest = None
            message = self._link.recv_match(blocking=False)
        if newest is not None:
            self._ask(newest)

    def _ask(self, wish: Wish) -> bool:
        """Whether the daemon took it; what it refuses is told to both ends."""
        command, fields = wish.behind(self._gimbal.boresight).as_request()
        try:
            self._client.request(command, **fields)
        except RequestRefusedError as refused:
            self._tell(f"refused: {refused}")
            self._send(self._gimbal.text(f"refused: {refused}"))
            return False
        return True

    def _tell_changes(self) -> None:
        if self._seen.guard != self._guard:
            self._guard = self._seen.guard
            if self._guard:
                self._tell(f"the axes were stopped: {self._guard}")
                self._send(self._gimbal.text(f"stopped: {self._guard}; left by the operator's reset", severe=True))
        if self._gimbal.controller != self._controller:
            self._controller = self._gimbal.controller
            system, component = self._controller
            self._tell("nobody is in control" if self._controller == NOBODY else f"in control: {system}/{component}")

    def _send(self, message: Any) -> None:
        self._link.mav.send(message)
