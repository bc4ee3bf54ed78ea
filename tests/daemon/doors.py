"""An operator's door for tests: served by a thread, or only when the test says so."""

from __future__ import annotations

import json
import socket
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

from gimbal_hil.realtime.operator.socket import (
    Client,
    Door,
    OperatorSocket,
)

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
