"""What a request may ask for: set-points within the limits, programs, and requests at which the code fails."""

from __future__ import annotations

from pathlib import Path

import pytest

from firmware_protocol.errors import BadInputError
from gimbal_hil.loop.host import AxisCommand, Mode, Segment, Shape, program_of
from gimbal_hil.loop.settings import shipped_settings
from gimbal_hil.realtime.operator.client import OperatorClient, RequestRefusedError
from gimbal_hil.realtime.operator.socket import (
    Client,
)
from gimbal_hil.realtime.service.operator_commands import SetPointRequest, parse_request
from gimbal_hil.realtime.service.set_point_bounds import require_reachable
from tests.daemon.doors import Json, Served

pytestmark = pytest.mark.realtime


def request_of(**values: object) -> SetPointRequest:
    request = parse_request({"command": "set_point", **values})
    assert isinstance(request, SetPointRequest)
    return request


@pytest.mark.parametrize(
    ("values", "says"),
    [
        ({"mode": "position", "outer": 1e300}, "set_point.position.outer|set_point.outer"),
        ({"mode": "position", "outer": 13.0}, "cable_wrap_turns; expected -12.5664 to 12.5664 rad"),
        ({"mode": "position", "inner": -2.1}, "set_point.inner: -2.1 rad is beyond .*; expected -2 to 2 rad"),
        ({"mode": "torque", "inner": 7.0}, "expected -6.6 to 6.6 N m"),
        ({"mode": "rate", "outer": -9.0}, "expected -8 to 8 rad/s"),
        ({"mode": "inertial_rate", "inner": 13.0}, "rad/s"),
        ({"mode": "rate", "outer": True}, "valid number"),
        ({"mode": "rate", "outer": "0.1"}, "valid number"),
    ],
)
def test_a_set_point_that_could_only_be_clamped_is_refused(values: Json, says: str) -> None:
    with pytest.raises(BadInputError, match=says):
        require_reachable(request_of(**values), shipped_settings())


def test_a_set_point_at_the_limit_is_taken() -> None:
    for values in (
        {"mode": "position", "outer": 12.5, "inner": 2.0},
        {"mode": "torque", "outer": -15.5},
        {"mode": "rate", "inner": 12.0},
    ):
        require_reachable(request_of(**values), shipped_settings())


def test_a_request_that_the_daemon_fails_at_leaves_the_door_open(tmp_path: Path) -> None:
    def handle(_client: Client, request: Json) -> Json:
        if request["command"] == "broken":
            raise KeyError("outer")
        return {"ok": True}

    here = Served(tmp_path, handle)
    try:
        with OperatorClient(tmp_path) as client:
            with pytest.raises(RequestRefusedError, match="failed at this request"):
                client.request("broken")
            assert client.request("quick_stop")["ok"]
    finally:
        here.close()


def test_a_direction_takes_no_time_of_its_own_and_the_refusal_names_the_option() -> None:
    line = {"command": "set_point", "mode": "pointing", "outer": 0.1, "inner": 0.2, "over_s": 2.0}
    request = parse_request(line)
    assert isinstance(request, SetPointRequest)
    with pytest.raises(BadInputError, match=r"over_s \(set --over\)"):
        request.program(1e-3)


def test_events_of_motions_before_the_first_program_are_not_taken_for_those_of_the_program(tmp_path: Path) -> None:
    def ended(tick: int) -> Json:
        return {"tick": tick, "data": {"code": "segment_ended", "segment": 1}}

    def handle(_client: Client, request: Json) -> Json:
        began = 143 + 1000 * int(request["id"] > 1)
        for tick in (began - 86, began + 250):
            here.operator.announce(ended(tick))
        return {"ok": True, "tick": began}

    here = Served(tmp_path, handle)
    rest = AxisCommand(Mode.OFF, Shape.HOLD)
    program = program_of([Segment(rest, rest, duration_ticks=10, label=1)])
    try:
        with OperatorClient(tmp_path) as client:
            client.start(program)
            assert client.wait_for_segment(1, 5.0) == ended(393)
            # what happens between two programs of the same client is its own: an operator's stop must not be missed
            client.start(program)
            assert client.wait_for_segment(1, 5.0) == ended(1057)
    finally:
        here.close()
