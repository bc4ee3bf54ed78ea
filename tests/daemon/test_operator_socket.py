from __future__ import annotations

import json
import os
import socket
import stat
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from firmware_protocol.errors import BadInputError, LinkError
from gimbal_hil.loop.host import AxisCommand, Mode, Segment, Shape, program_of
from gimbal_hil.loop.settings import shipped_settings
from gimbal_hil.realtime.operator.client import OperatorClient, RequestRefusedError
from gimbal_hil.realtime.operator.socket import (
    GREETING_TIMEOUT_S,
    LONGEST_UNREAD,
    MOST_CLIENTS,
    MOST_STRANGERS,
    Client,
    Door,
    OperatorSocket,
)
from gimbal_hil.realtime.service.operator_commands import SetPointRequest, parse_request
from gimbal_hil.realtime.service.set_point_bounds import require_reachable

pytestmark = pytest.mark.realtime

Json = dict[str, Any]


def echo(_client: Client, request: Json) -> Json:
    if request.get("command") == "refuse":
        return {"ok": False, "error": "not now"}
    return {"ok": True, "got": request}


class Served:
    """A door served by a thread until the test ends."""

    def __init__(self, run: Path, handle: Callable[[Client, Json], Json | None] = echo) -> None:
        self.run, self.door = run, Door.make()
        self.operator = OperatorSocket(self.door, handle)
        self.path = self.door.write(run)
        self._stop = False
        self._thread = threading.Thread(target=self._work)
        self._thread.start()

    def _work(self) -> None:
        while not self._stop:
            self.operator.serve(0.01)

    def close(self) -> None:
        self._stop = True
        self._thread.join()
        self.operator.close()
        self.door.remove(self.run)

    def connect(self) -> socket.socket:
        connection = socket.socket(socket.AF_UNIX)
        connection.settimeout(5)
        connection.connect(str(self.door.socket))
        return connection


@pytest.fixture
def served(tmp_path: Path) -> Iterator[Served]:
    door = Served(tmp_path)
    yield door
    door.close()


def test_a_client_with_the_token_file_is_answered(served: Served) -> None:
    with OperatorClient(served.run) as client:
        assert client.request("status", axis="outer")["got"]["axis"] == "outer"
        with pytest.raises(RequestRefusedError, match="refuse: not now"):
            client.request("refuse")


def test_the_token_file_and_the_socket_are_for_the_owner_alone(served: Served) -> None:
    for path in (served.path, served.door.socket):
        assert stat.S_IMODE(path.stat().st_mode) == 0o600
    assert stat.S_IMODE(served.door.socket.parent.stat().st_mode) == 0o700


def test_a_token_file_that_others_may_read_is_refused(served: Served) -> None:
    served.path.chmod(0o640)
    with pytest.raises(BadInputError, match="mode 0600"):
        OperatorClient(served.run)


@pytest.mark.parametrize(
    "greeting",
    [b'{"token": "00"}\n', b'{"id": 1, "command": "stop"}\n', b"\n", b"[1]\n", b'{"token": 5}\n', b"\xff\xfe\n"],
)
def test_without_the_token_nothing_is_handled_and_the_connection_ends(served: Served, greeting: bytes) -> None:
    with served.connect() as connection:
        connection.sendall(greeting)
        assert json.loads(connection.makefile().readline()) == {"ok": False, "error": "wrong or missing token"}
        assert connection.recv(1) == b""


def test_a_greeting_without_end_is_cut_off(served: Served) -> None:
    with served.connect() as connection, pytest.raises(OSError):
        for _ in range(1000):
            connection.sendall(b"x" * 1000)
        assert connection.recv(1) == b""
        raise ConnectionResetError


def test_lines_may_come_in_any_pieces_and_bad_ones_are_answered(served: Served) -> None:
    with served.connect() as connection:
        answers = connection.makefile()
        for byte in (
            json.dumps({"token": served.door.token}).encode() + b'\n{"id": 7, "command": "a"}\nnonsense\n{"id": 8}\n'
        ):
            connection.sendall(bytes([byte]))
        lines = [json.loads(answers.readline()) for _ in range(4)]
    assert lines[0]["ok"] and lines[1]["id"] == 7
    assert lines[2] == {"id": None, "ok": False, "error": lines[2]["error"]}
    assert lines[3]["id"] == 8


def test_events_reach_every_client_and_do_not_disturb_answers(tmp_path: Path) -> None:
    def handle(_client: Client, request: Json) -> Json:
        here.operator.announce({"event": "segment_end", "number": request["number"]})
        return {"ok": True}

    here = Served(tmp_path, handle)
    try:
        with OperatorClient(tmp_path) as one, OperatorClient(tmp_path) as other:
            for number in range(3):
                one.request("go", number=number)
            for client in (one, other):
                event = client.wait_for(lambda event: event["number"] == 2, timeout_s=5)
                assert event == {"event": "segment_end", "number": 2}
            assert one.next_event(0.01) is None
    finally:
        here.close()


def test_a_client_that_does_not_read_is_dropped_and_others_go_on(tmp_path: Path) -> None:
    served = Served(tmp_path, lambda client, request: {"ok": True, "filling": "x" * (LONGEST_UNREAD // 8)})
    try:
        with served.connect() as deaf:
            deaf.sendall(json.dumps({"token": served.door.token}).encode() + b"\n")
            with pytest.raises(OSError):
                for number in range(100_000):
                    deaf.sendall(b'{"id": %d}\n' % number)
        with OperatorClient(tmp_path) as client:
            assert client.request("status")["ok"]
    finally:
        served.close()


def test_a_daemon_that_ended_is_reported_as_gone(tmp_path: Path) -> None:
    served = Served(tmp_path)
    client = OperatorClient(tmp_path)
    served.close()
    with pytest.raises(LinkError):
        client.request("status")
    with pytest.raises(BadInputError, match="no such file"):
        OperatorClient(tmp_path)
    Door(Path("/nonexistent/socket"), "").write(tmp_path)
    with pytest.raises(LinkError, match="no daemon listens"):
        OperatorClient(tmp_path)
    assert os.path.exists(tmp_path / "operator.json")


class Clock:
    """Seconds that pass when the test says so."""

    def __init__(self) -> None:
        self.now_s = 100.0

    def __call__(self) -> float:
        return self.now_s


class Unserved:
    """A door that is served when the test says so."""

    def __init__(self) -> None:
        self.door, self.clock, self.handled = Door.make(), Clock(), []
        self.operator = OperatorSocket(self.door, self._handle, self.clock)

    def _handle(self, _client: Client, request: Json) -> Json:
        self.handled.append(request["command"])
        return {"ok": True}

    def connect(self, *lines: bytes) -> socket.socket:
        connection = socket.socket(socket.AF_UNIX)
        connection.settimeout(5)
        connection.connect(str(self.door.socket))
        for line in lines:
            connection.sendall(line + b"\n")
        return connection

    @property
    def token(self) -> bytes:
        return json.dumps({"token": self.door.token}).encode()

    def serve(self, times: int = 3) -> None:
        for _ in range(times):
            self.operator.serve(0.0)


@pytest.fixture
def unserved(tmp_path: Path) -> Iterator[Unserved]:
    here = Unserved()
    yield here
    here.operator.close()
    here.door.remove(tmp_path)


def said(connection: socket.socket) -> list[Json]:
    """All lines that have come."""
    connection.setblocking(False)
    data = b""
    try:
        while piece := connection.recv(1 << 16):
            data += piece
    except BlockingIOError:
        pass
    return [json.loads(line) for line in data.splitlines()]


@pytest.mark.parametrize(
    "line",
    [
        b'{"token": "\\ud800"}',
        b'{"\\ud800": 1}',
        b'{"id": 1, "command": "segments", "length": 1e400}',
        b'{"id": 1, "command": "start", "program": {"length": ' + b"9" * 400 + b', "values": []}}',
        b'{"id": ' + b"9" * 6000 + b"}",
        b"[" * 3000,
        b'{"a":' * 500 + b"1" + b"}" * 500,
        b'{"id": 1, "id": 2, "command": "stop"}',
        b"\xff\xfe\x00",
        b'{"id": NaN}',
    ],
)
def test_a_hostile_line_is_answered_before_and_after_the_token_and_the_door_stays_open(
    unserved: Unserved, line: bytes
) -> None:
    stranger = unserved.connect(line)
    owner = unserved.connect(unserved.token, line, b'{"id": 5, "command": "quick_stop"}')
    unserved.serve()
    assert said(stranger) == [{"ok": False, "error": "wrong or missing token"}]
    greeting, refused, answered = said(owner)
    assert greeting["ok"] and refused["ok"] is False and refused["error"] and answered == {"id": 5, "ok": True}
    assert unserved.handled == ["quick_stop"]


def test_silent_connections_lock_nobody_out(unserved: Unserved) -> None:
    silent = [unserved.connect() for _ in range(60)]
    unserved.serve()
    with unserved.connect(unserved.token, b'{"id": 1, "command": "quick_stop"}') as owner:
        unserved.serve()
        assert [line["ok"] for line in said(owner)] == [True, True]
    unserved.clock.now_s += GREETING_TIMEOUT_S + 0.1
    unserved.serve()
    assert all("silent longest" in said(one)[0]["error"] for one in silent[: 60 - MOST_STRANGERS])
    # one of the last eight made room for the owner
    assert all("no token within" in said(one)[0]["error"] for one in silent[60 - MOST_STRANGERS + 1 :])


def test_a_token_that_came_while_the_process_stood_still_counts(unserved: Unserved) -> None:
    with unserved.connect() as newcomer, unserved.connect(unserved.token) as owner:
        unserved.serve()

        def stall(_client: Client, _request: Json) -> Json:
            newcomer.sendall(unserved.token + b"\n")
            unserved.clock.now_s += GREETING_TIMEOUT_S + 1.0
            return {"ok": True}

        unserved.operator._handle = stall
        owner.sendall(b'{"id": 1, "command": "status"}\n')
        unserved.serve(1)
        assert said(newcomer) == [{"ok": True, "protocol": 1}]


def test_a_stranger_who_trickles_is_not_taken_for_one_who_speaks(unserved: Unserved) -> None:
    with unserved.connect() as stranger:
        unserved.serve()
        for _ in range(5):
            stranger.sendall(b" ")
            unserved.clock.now_s += GREETING_TIMEOUT_S / 4
            unserved.serve()
        assert "no token" in said(stranger)[0]["error"]


def test_the_owner_gets_in_where_all_places_are_taken_by_clients_with_the_token(unserved: Unserved) -> None:
    crowd = []
    for _ in range(MOST_CLIENTS):
        crowd.append(unserved.connect(unserved.token))
        unserved.serve()
        unserved.clock.now_s += 1.0
    crowd[0].sendall(b'{"id": 1, "command": "status"}\n')
    unserved.serve()
    with unserved.connect(unserved.token, b'{"id": 1, "command": "quick_stop"}') as owner:
        unserved.serve()
        assert [line["ok"] for line in said(owner)] == [True, True] and unserved.operator.clients == MOST_CLIENTS
    assert [line["ok"] for line in said(crowd[0])] == [True, True]
    assert "silent longest" in said(crowd[1])[-1]["error"]


def test_a_long_request_waits_for_every_short_one_and_keeps_its_clients_order(unserved: Unserved) -> None:
    long = b'{"id": 1, "command": "long", "filling": "' + b"x" * 17_000 + b'"}'
    hauliers = [unserved.connect(unserved.token, long, b'{"id": 2, "command": "after"}') for _ in range(2)]
    with unserved.connect(unserved.token, b'{"id": 3, "command": "quick_stop"}') as owner:
        unserved.serve(1)
        assert said(owner)[-1] == {"id": 3, "ok": True}
        assert "after" not in unserved.handled[:1] and unserved.handled.count("long") <= 1
        unserved.serve(5)
    assert unserved.handled.count("long") == 2 and unserved.handled.count("after") == 2
    assert [line["id"] for line in said(hauliers[0])[1:]] == [1, 2]


def test_a_line_beyond_the_limit_ends_its_connection_and_no_other(tmp_path: Path) -> None:
    served = Served(tmp_path)
    try:
        with OperatorClient(tmp_path) as client, served.connect() as flood:
            flood.sendall(json.dumps({"token": served.door.token}).encode() + b"\n")
            with pytest.raises(OSError):
                for _ in range(60):
                    flood.sendall(b"x" * (1 << 20))
            assert client.request("status")["ok"]
    finally:
        served.close()


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


def test_a_daemon_that_is_refused_a_folder_leaves_the_door_of_the_one_that_records_there(served: Served) -> None:
    Door.make().remove(served.run)
    with OperatorClient(served.run) as client:
        assert client.request("stop")["ok"]


def test_a_daemon_takes_its_own_door_away_even_where_somebody_widened_its_mode(tmp_path: Path) -> None:
    door = Door.make()
    door.write(tmp_path).chmod(0o644)
    with pytest.raises(BadInputError, match="may be read by others"):
        Door.read(tmp_path)
    door.remove(tmp_path)
    assert list(tmp_path.iterdir()) == []


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
