"""Who may speak at the operator's door, and what becomes of lines, events and silent readers."""

from __future__ import annotations

import json
import os
import stat
from collections.abc import Iterator
from pathlib import Path

import pytest

from firmware_protocol.errors import BadInputError, LinkError
from gimbal_hil.realtime.operator.client import OperatorClient, RequestRefusedError
from gimbal_hil.realtime.operator.socket import (
    LONGEST_UNREAD,
    Client,
    Door,
)
from tests.daemon.doors import Json, Served

pytestmark = pytest.mark.realtime


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
