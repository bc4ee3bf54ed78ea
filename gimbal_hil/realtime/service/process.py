"""The control process' handle on its service process: orders, start, end.

The service is started with its orders as one JSON line on standard input, answers one JSON line on standard output when
it is ready (or why it cannot be), and takes the end of its standard input as the end of the control process.
"""

from __future__ import annotations

import json
import os
import select
import subprocess
import sys
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Self

from firmware_protocol.errors import BadInputError
from firmware_protocol.interpreter import apart_from_the_users_folder
from firmware_protocol.json_object import Json
from gimbal_hil.data.runs import RunHeader
from gimbal_hil.loop.timing import RingReader, RingWriter, create_ring
from gimbal_hil.realtime.operator import Door
from gimbal_hil.realtime.telemetry import COMMAND_BYTES, TELEMETRY_BYTES

_START_TIMEOUT_S = 30.0


@dataclass(frozen=True, slots=True)
class ServiceSettings:
    """What of the ticks is kept (their frames, one row in `every_ticks`), whether the folder may be overwritten, who
    may look on.
    """

    force: bool = False
    frames: bool = True
    every_ticks: int = 1
    operator: bool = True
    #: port of the live page, 0 for any free one, None for no page
    page_port: int | None = None
    quiet: bool = False


@dataclass(frozen=True, slots=True)
class Orders:
    """What the control process tells its service: descriptors of the two rings, where to record, which door."""

    telemetry: int
    commands: int
    run: str
    header: Json
    socket: str
    token: str
    settings: Json


class ServiceProcess:
    """The control process' handle on its service: starts it (`wait_ready` says when that is done), watches it, ends
    it.
    """

    def __init__(self, run: Path, header: RunHeader, settings: ServiceSettings) -> None:
        self.run = run
        self.door = Door.make()
        telemetry, commands = create_ring(TELEMETRY_BYTES), create_ring(COMMAND_BYTES)
        try:
            self.telemetry, self.commands = RingWriter(telemetry), RingReader(commands)
            orders = Orders(
                telemetry, commands, str(run), asdict(header), str(self.door.socket), self.door.token, asdict(settings)
            )
            with apart_from_the_users_folder():
                self._process = subprocess.Popen(
                    [sys.executable, "-m", "gimbal_hil.realtime.service"],
                    pass_fds=(telemetry, commands),
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                    start_new_session=True,  # Ctrl-C in a terminal is for the control process alone
                )
        finally:
            os.close(telemetry)
            os.close(commands)
        self.page_url: str | None = None
        assert self._process.stdin
        self._process.stdin.write(json.dumps(asdict(orders)).encode() + b"\n")
        self._process.stdin.flush()

    @property
    def pid(self) -> int:
        """Process id of the service."""
        return self._process.pid

    def alive(self) -> bool:
        """Whether the service still runs: one system call."""
        return self._process.poll() is None

    def progress(self) -> int:
        """A number that changes as long as the service takes what the ticks leave for it."""
        return self.telemetry.reader_position

    def close(self, timeout_s: float = 20.0) -> bool:
        """Let the service write what it has and end it; False when it had died or had to be killed."""
        if self._process.stdin:
            self._process.stdin.close()
        try:
            code = self._process.wait(timeout_s)
        except subprocess.TimeoutExpired:
            self._process.kill()
            code = self._process.wait()
        if self._process.stdout:
            self._process.stdout.close()
        self.door.remove(self.run)
        return code == 0

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def wait_ready(self) -> None:
        """Until the service records and listens; BadInputError when it cannot."""
        assert self._process.stdout
        readable, _, _ = select.select([self._process.stdout], [], [], _START_TIMEOUT_S)
        line = self._process.stdout.readline() if readable else b""
        answer: Json = (
            json.loads(line) if line else {"problem": "did not start", "where": "service process", "expected": ""}
        )
        if not answer.get("ready"):
            self.close(timeout_s=1.0)
            raise BadInputError(answer["where"], answer["problem"], answer["expected"])
        self.page_url = answer["page"]
