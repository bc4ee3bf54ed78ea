"""Hostile lines, silent connections and long requests lock nobody out and delay no short one."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import pytest

from gimbal_hil.realtime.operator.client import OperatorClient
from gimbal_hil.realtime.operator.socket import (
    GREETING_TIMEOUT_S,
    MOST_CLIENTS,
    MOST_STRANGERS,
    Client,
)
from tests.daemon.doors import Json, Served, Unserved, said

pytestmark = pytest.mark.realtime


@pytest.fixture
def unserved(tmp_path: Path) -> Iterator[Unserved]:
    here = Unserved()
    yield here
    here.operator.close()
    here.door.remove(tmp_path)


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
