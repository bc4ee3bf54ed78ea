"""The operator's side of the door: one object for scripts, experiments and the command line."""

from __future__ import annotations

import contextlib
import json
import socket
import threading
import time
from collections import deque
from collections.abc import Callable
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Self

from firmware_protocol.documents import DocumentLimits, json_line
from firmware_protocol.errors import BadInputError, LinkError
from firmware_protocol.json_object import Json
from gimbal_hil.realtime.operator.socket import Door

if TYPE_CHECKING:
    from gimbal_hil.loop.host import Program


#: a figure that is not known may be NaN
_ANSWER = DocumentLimits(size_bytes=64 << 20, values=2_000_000, finite=False)


#: how often a request is repeated while the daemon is on its way to ready
_REPEAT_S = 0.02
#: a lease is renewed so many times before it would run out
_RENEWALS = 6


class RequestRefusedError(BadInputError):
    """The daemon understood the request and refused it; the message says why."""


class NotReadyError(RequestRefusedError):
    """A motion was asked for while the host still connects to its antenna: it can be asked for again."""


class OperatorClient:
    """A connection to the daemon that records into `run` (its run folder, the `operator.json` in it, or its door).

    Raises BadInputError when there is no such daemon or the token file is not the caller's own, LinkError when the
    daemon does not answer within `timeout_s` or has gone.

    A motion that was asked for with a lease is this object's own: it is braked to rest when the connection closes, and
    when this process stands still for longer than `operator.lease_s`; `release` leaves it to itself. The lease is
    renewed by a thread, so that a caller who computes for long is not taken for one who is gone.
    """

    def __init__(self, run: Path | Door, timeout_s: float = 5.0) -> None:
        door = run if isinstance(run, Door) else Door.read(Path(run))
        self._where = str(door.socket)
        self._timeout_s = timeout_s
        self._events: deque[Json] = deque()
        self._unread = b""
        self._next_id = 0
        #: events of earlier ticks are of motions that somebody else began
        self._since_tick: int | None = None
        self._sending, self._leaving = threading.Lock(), threading.Event()
        self._renewal: threading.Thread | None = None
        self._connection = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        try:
            self._connection.settimeout(timeout_s)
            self._connect(time.monotonic() + timeout_s)
            self._send({"token": door.token})
        except OSError as error:
            self._connection.close()
            raise LinkError(f"{self._where}: no daemon listens there ({error.strerror or error})") from error
        greeting = self._line(time.monotonic() + timeout_s)
        if greeting is None or not greeting.get("ok"):
            self.close()
            raise LinkError(f"{self._where}: {greeting['error'] if greeting else 'the daemon does not answer'}")

    def request(self, command: str, /, **fields: object) -> Json:
        """Send one command and wait for its answer; RequestRefusedError when the daemon says no. Events that come first
        are kept.
        """
        self._next_id += 1
        number = self._next_id
        try:
            self._send({**fields, "id": number, "command": command})
        except OSError as error:
            raise LinkError(f"{self._where}: the daemon has gone ({error.strerror or error})") from error
        deadline = time.monotonic() + self._timeout_s
        while (line := self._line(deadline)) is not None:
            if line.get("id") != number:
                self._events.append(line)
            elif line.get("ok"):
                if "lease_s" in line:
                    self._keep_lease(float(line["lease_s"]))
                return line
            else:
                kind = NotReadyError if line.get("not_ready") else RequestRefusedError
                raise kind(command, str(line.get("error", "refused")))
        raise LinkError(f"{self._where}: no answer to {command!r} within {self._timeout_s} s")

    def when_ready(self, command: str, /, timeout_s: float = 5.0, **fields: object) -> Json:
        """`request`, repeated until the host has connected to its antenna; NotReadyError when that takes longer.

        It is the caller who waits, not the daemon: a motion whose caller has gone never begins.
        """
        deadline = time.monotonic() + timeout_s
        while True:
            try:
                return self.request(command, **fields)
            except NotReadyError:
                if time.monotonic() > deadline:
                    raise
                time.sleep(_REPEAT_S)

    def start(self, program: Program, with_image: bool = False) -> int:
        """Have the host follow a program, with a lease, as soon as it is ready; answers the tick at which it began.
        `with_image` also records where the host stood, so that a run that begins there can be computed again.

        Events from before the first program of this connection are let go: the daemon's own test before the first
        motion has segments and a stop as well.
        """
        document = program.as_document()
        tick = int(self.when_ready("start", program=document, with_image=with_image, lease=True)["tick"])
        if self._since_tick is None:
            self._since_tick = tick
        return tick

    def wait_for_segment(self, label: int, timeout_s: float) -> Json | None:
        """The event that ends the segment of that label (`cause` in its data says why), None when it does not come in
        time.
        """

        def ended(event: Json) -> bool:
            data = event.get("data", {})
            return data.get("code") == "segment_ended" and data.get("segment") == label

        return self.wait_for(ended, timeout_s)

    def next_event(self, timeout_s: float) -> Json | None:
        """The next event, or None when none comes in time."""
        deadline = time.monotonic() + timeout_s
        while True:
            event = self._events.popleft() if self._events else self._line(deadline)
            if event is None or self._since_tick is None or event.get("tick", self._since_tick) >= self._since_tick:
                return event

    def wait_for(self, wanted: Callable[[Json], bool], timeout_s: float) -> Json | None:
        """The first event for which `wanted` is true; others are let go. None when it does not come in time."""
        deadline = time.monotonic() + timeout_s
        while (left := deadline - time.monotonic()) > 0:
            event = self.next_event(left)
            if event is not None and wanted(event):
                return event
        return None

    def release(self) -> None:
        """The motion goes on, or is held, without this client."""
        self.request("release")

    def close(self) -> None:
        """End the connection, and with it a motion that it has the lease of; the daemon goes on."""
        self._leaving.set()
        with contextlib.suppress(OSError):
            # a child that was forked may hold the connection too
            self._connection.shutdown(socket.SHUT_RDWR)
        if self._renewal is not None:
            self._renewal.join()
        self._connection.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _connect(self, deadline: float) -> None:
        """Knock until there is room before the door: a crowd there is let in, and sent away, within milliseconds."""
        while True:
            try:
                self._connection.connect(self._where)
                return
            except BlockingIOError:
                if time.monotonic() > deadline:
                    raise
                time.sleep(0.005)

    def _send(self, line: Json) -> None:
        with self._sending:
            self._connection.settimeout(self._timeout_s)
            self._connection.sendall(json.dumps(line).encode() + b"\n")

    def _keep_lease(self, lease_s: float) -> None:
        if self._renewal is None:
            # the thread's own handle on the connection, which has a time-out of its own
            voice = self._connection.dup()
            voice.settimeout(self._timeout_s)
            self._renewal = threading.Thread(target=self._renew, args=(voice, lease_s / _RENEWALS), daemon=True)
            self._renewal.start()

    def _renew(self, voice: socket.socket, every_s: float) -> None:
        line = json.dumps({"command": "renew"}).encode() + b"\n"
        with voice, contextlib.suppress(OSError):
            while not self._leaving.wait(every_s):
                with self._sending:
                    voice.sendall(line)

    def _line(self, deadline: float) -> Json | None:
        while b"\n" not in self._unread:
            left = deadline - time.monotonic()
            if left <= 0:
                return None
            self._connection.settimeout(left)
            try:
                data = self._connection.recv(1 << 18)
            except TimeoutError:
                return None
            except OSError as error:
                raise LinkError(f"{self._where}: the daemon has gone ({error.strerror or error})") from error
            if not data:
                raise LinkError(f"{self._where}: the daemon has ended")
            self._unread += data
        line, self._unread = self._unread.split(b"\n", 1)
        return json_line(line, self._where, "an answer of the daemon", _ANSWER)
