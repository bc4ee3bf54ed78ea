"""The operator's door: JSON lines over a Unix socket that only a process which can read the owner's token file gets
through.

One line is one JSON object. The first line of a connection is `{"token": "..."}`; each later one is a request with an
`id` of the client's choice and is answered by one line with that `id`. Lines without `id` are events, sent to every
client as they happen.
"""

from __future__ import annotations

import contextlib
import hmac
import json
import os
import secrets
import selectors
import shutil
import socket
import tempfile
import time
import traceback
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from firmware_protocol.documents import DocumentLimits, json_line, read_json
from firmware_protocol.errors import BadInputError
from firmware_protocol.json_object import Json

#: a request may carry a program with tables (eight megabytes of numbers at most, packed); an answer nobody reads may
#: not grow for ever
LONGEST_LINE = 12 << 20
LONGEST_UNREAD = 4 << 20
_LIMITS = DocumentLimits(size_bytes=LONGEST_LINE, values=100_000)
#: before it has shown the token a client may send this much, and has this long
LONGEST_GREETING = 4096
GREETING_TIMEOUT_S = 2.0
#: how many who have shown the token, and how many who have not
MOST_CLIENTS, MOST_STRANGERS = 16, 8
_BACKLOG = 256
#: takes well under a millisecond
_SHORT_LINE = 16384
_MOST_WAITING = 256
DOOR_FILE = "operator.json"
#: an address of a socket has 107 bytes, of which the folder and the name below it take 27
_LONGEST_BASE = 80


@dataclass(frozen=True, slots=True)
class Door:
    """Where a daemon listens and what opens it; kept in a file readable by its owner alone."""

    socket: Path
    token: str

    @classmethod
    def make(cls) -> Door:
        """A new socket address in a private folder (socket paths are limited to some 100 bytes, run folders are not)
        and a new token.
        """
        base = os.environ.get("XDG_RUNTIME_DIR", "")
        serves = Path(base).is_dir() and len(os.fsencode(base)) <= _LONGEST_BASE
        folder = tempfile.mkdtemp(prefix="gimbal-hil-", dir=base if base and serves else None)
        if len(os.fsencode(folder)) > _LONGEST_BASE + len("/gimbal-hil-") + 8:
            Path(folder).rmdir()
            raise BadInputError("TMPDIR", f"{folder} is too long for a socket", f"at most {_LONGEST_BASE} bytes")
        return cls(Path(folder) / "socket", secrets.token_hex(32))

    def write(self, run: Path) -> Path:
        """Leave the door's file in the run folder, mode 0600 from its first byte and whole from its first moment."""
        path, fresh = run / DOOR_FILE, run / f".{DOOR_FILE}"
        fresh.unlink(missing_ok=True)
        with os.fdopen(os.open(fresh, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w") as file:
            json.dump({"socket": str(self.socket), "token": self.token}, file)
        return fresh.rename(path)

    @classmethod
    def read(cls, run: Path) -> Door:
        """The door of the daemon that records into `run`; BadInputError when there is none or others may read the
        token.
        """
        path = run / DOOR_FILE if run.is_dir() else run
        door, status = cls._written_in(path), path.stat()
        if status.st_mode & 0o077 or status.st_uid != os.geteuid():
            raise BadInputError(
                str(path), "may be read by others or belongs to somebody else", "a file of yours with mode 0600"
            )
        return door

    @classmethod
    def is_open(cls, run: Path) -> bool:
        """Whether somebody listens at the door of that run folder; a daemon that was killed leaves a dead one."""
        try:
            door = cls._written_in(run / DOOR_FILE)
            with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as knocking:
                knocking.setblocking(False)
                knocking.connect(str(door.socket))
        except BlockingIOError:
            # a crowd waits there
            return True
        except (OSError, BadInputError):
            return False
        return True

    @classmethod
    def _written_in(cls, path: Path) -> Door:
        expected = "the run folder of a running daemon"
        content = read_json(path, expected)
        address, token = content.get("socket"), content.get("token")
        if not isinstance(address, str) or not isinstance(token, str):
            raise BadInputError(str(path), "does not say where the daemon listens", expected)
        return cls(Path(address), token)

    def remove(self, run: Path) -> None:
        """Take the socket, its folder and the file away; the file of another daemon that records into `run` stays."""
        shutil.rmtree(self.socket.parent, ignore_errors=True)
        with contextlib.suppress(OSError, BadInputError):
            if Door._written_in(run / DOOR_FILE) == self:
                (run / DOOR_FILE).unlink(missing_ok=True)


@dataclass(slots=True, eq=False)
class Client:
    """One connection, as the service sees it; `heard_s` is when it last said something (it connected, at first)."""

    connection: socket.socket
    heard_s: float
    admitted: bool = False
    incoming: bytearray = field(default_factory=bytearray)
    outgoing: bytearray = field(default_factory=bytearray)
    #: whole lines that wait for their turn, because one of them is long
    lines: deque[bytes] = field(default_factory=deque)


class OperatorSocket:
    """Serves the door without ever blocking: `serve` handles what is ready and returns. `handle(client, request)`
    answers a request at once with a line, or with None when the answer comes later through `answer`.

    Whoever holds the token gets in: a connection that does not show it in time is closed, and when places are short the
    one that has been silent longest makes room. A long line is taken apart when every short one has been answered, and
    one at a time, so that it delays a quick stop on another connection by its own time at most.
    """

    def __init__(
        self,
        door: Door,
        handle: Callable[[Client, Json], Json | None],
        clock_s: Callable[[], float] = time.monotonic,
        gone: Callable[[Client], None] = lambda client: None,
    ) -> None:
        """`gone(client)` is called when an admitted client's connection has closed."""
        self._token = door.token
        self._handle = handle
        self._gone = gone
        self._clock_s = clock_s
        #: in the order of their coming
        self._clients: dict[Client, None] = {}
        self._long: deque[Client] = deque()
        self._selector = selectors.DefaultSelector()
        self._listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self._listener.bind(str(door.socket))
        os.chmod(door.socket, 0o600)
        self._listener.listen(_BACKLOG)
        self._listener.setblocking(False)
        self._selector.register(self._listener, selectors.EVENT_READ)

    @property
    def clients(self) -> int:
        """How many admitted clients there are."""
        return sum(client.admitted for client in self._clients)

    def has(self, client: Client) -> bool:
        """Whether a client is still connected."""
        return client in self._clients

    def serve(self, timeout_s: float) -> None:
        """Wait up to `timeout_s` for something to do and do all that is ready: all short lines, and one long one."""
        for key, ready in self._selector.select(0.0 if self._long else timeout_s):
            if key.data is None:
                self._accept()
            elif key.data not in self._clients or (ready & selectors.EVENT_WRITE and not self._flush(key.data)):
                continue
            elif ready & selectors.EVENT_READ:
                self._receive(key.data)
        if self._long:
            self._take_long_line(self._long.popleft())
        self._drop_silent()

    def answer(self, client: Client, line: Json) -> None:
        """Send one line to one client; nothing happens when it has gone."""
        if client in self._clients:
            client.outgoing += json.dumps(line).encode() + b"\n"
            if len(client.outgoing) > LONGEST_UNREAD:
                self._drop(client)
            else:
                self._flush(client)

    def announce(self, event: Json) -> None:
        """Send one event to every admitted client."""
        for client in [client for client in self._clients if client.admitted]:
            self.answer(client, event)

    def close(self) -> None:
        """End all connections; what they still had to read is given one chance."""
        for client in list(self._clients):
            self._flush(client)
            self._drop(client)
        self._selector.close()
        self._listener.close()

    def _accept(self) -> None:
        """Let in all who wait, and hear each at once: the token usually comes with the knock, before anybody can push
        in.
        """
        for _ in range(_BACKLOG):
            try:
                connection, _address = self._listener.accept()
            except OSError:
                # nobody waits any more, or there are no more descriptors: those who wait are taken when there are
                return
            connection.setblocking(False)
            self._make_room(admitted=False, most=MOST_STRANGERS)
            client = Client(connection, self._clock_s())
            self._clients[client] = None
            self._selector.register(connection, selectors.EVENT_READ, client)
            self._receive(client)

    def _make_room(self, admitted: bool, most: int) -> None:
        """Leave a place free among those who have, or have not, shown the token."""
        there = [client for client in self._clients if client.admitted is admitted]
        if len(there) >= most:
            silent = min(there, key=lambda client: client.heard_s)
            self.answer(
                silent, {"ok": False, "error": "too many connections: the one that was silent longest has to go"}
            )
            self._drop(silent)

    def _drop_silent(self) -> None:
        latest = self._clock_s() - GREETING_TIMEOUT_S
        for client in [client for client in self._clients if not client.admitted and client.heard_s < latest]:
            # this process may have stood still since it last listened: the token may be here
            self._receive(client)
            if client.admitted or client not in self._clients:
                continue
            self.answer(client, {"ok": False, "error": f"no token within {GREETING_TIMEOUT_S:g} s"})
            self._drop(client)

    def _receive(self, client: Client) -> None:
        try:
            data = client.connection.recv(1 << 18)
        except (BlockingIOError, InterruptedError):
            return
        except OSError:
            data = b""
        if not data:
            self._drop(client)
            return
        searched = len(client.incoming)
        client.incoming += data
        while client in self._clients and (end := client.incoming.find(b"\n", searched)) >= 0:
            line = bytes(client.incoming[:end])
            del client.incoming[: end + 1]
            searched = 0
            self._take_in_turn(client, line)
        longest = LONGEST_LINE if client.admitted else LONGEST_GREETING
        if len(client.incoming) > longest:
            self.answer(client, {"ok": False, "error": f"a line of more than {longest} bytes"})
            self._drop(client)

    def _take_in_turn(self, client: Client, line: bytes) -> None:
        """A short line at once, unless one before it still waits: a client's lines keep their order."""
        if not client.lines and len(line) <= _SHORT_LINE:
            self._take_line(client, line)
        elif len(client.lines) >= _MOST_WAITING:
            self.answer(client, {"ok": False, "error": "too many requests at once"})
            self._drop(client)
        else:
            if not client.lines:
                self._long.append(client)
            client.lines.append(line)

    def _take_long_line(self, client: Client) -> None:
        """The line whose turn it is, and the short ones behind it."""
        if client in self._clients:
            self._take_line(client, client.lines.popleft())
        while client in self._clients and client.lines and len(client.lines[0]) <= _SHORT_LINE:
            self._take_line(client, client.lines.popleft())
        if client in self._clients and client.lines:
            self._long.append(client)

    def _take_line(self, client: Client, line: bytes) -> None:
        problem = ""
        try:
            request = json_line(line, "request", "one JSON object in a line", _LIMITS)
        except BadInputError as refused:
            request, problem = {}, str(refused)
        if not client.admitted:
            token = request.get("token")
            if not isinstance(token, str) or not hmac.compare_digest(token.encode(), self._token.encode()):
                self.answer(client, {"ok": False, "error": "wrong or missing token"})
                self._drop(client)
                return
            self._make_room(admitted=True, most=MOST_CLIENTS)
            client.admitted, client.heard_s = True, self._clock_s()
            self.answer(client, {"ok": True, "protocol": 1})
            return
        client.heard_s = self._clock_s()
        reply = {"ok": False, "error": problem} if problem else self._handled(client, request)
        if reply is not None:
            self.answer(client, {"id": request.get("id"), **reply})

    def _handled(self, client: Client, request: Json) -> Json | None:
        """The answer to a request; whatever goes wrong with one, the door stays open for a quick stop."""
        try:
            return self._handle(client, request)
        except Exception as error:
            traceback.print_exc()
            return {"ok": False, "error": f"the daemon failed at this request: {error!r}"[:500]}

    def _flush(self, client: Client) -> bool:
        try:
            while client.outgoing:
                del client.outgoing[: client.connection.send(client.outgoing)]
        except (BlockingIOError, InterruptedError):
            pass
        except OSError:
            self._drop(client)
            return False
        wanted = selectors.EVENT_READ | (selectors.EVENT_WRITE if client.outgoing else 0)
        if self._selector.get_key(client.connection).events != wanted:
            self._selector.modify(client.connection, wanted, client)
        return True

    def _drop(self, client: Client) -> None:
        if client in self._clients:
            client.lines.clear()
            del self._clients[client]
            self._selector.unregister(client.connection)
            client.connection.close()
            if client.admitted:
                self._gone(client)
