"""A small HTTP server on the loopback address: the page, its data as JSON, the metrics.

Everyone on this machine may look. Whoever shows the operator's token may also act: a request goes through the
operator's door, which judges it like one from any terminal, and the scope takes its settings.
"""

from __future__ import annotations

import contextlib
import hmac
import json
import math
import secrets
import socket
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any
from urllib.parse import parse_qs, urlsplit

from firmware_protocol.documents import DocumentLimits, json_line
from firmware_protocol.errors import BadInputError, LinkError
from firmware_protocol.json_object import Json
from gimbal_hil.loop.timing import upper_bound_ns
from gimbal_hil.realtime.dashboard.metrics import CONTENT_TYPE, metrics_text
from gimbal_hil.realtime.dashboard.page import PAGE
from gimbal_hil.realtime.dashboard.screen import ScopeScreen
from gimbal_hil.realtime.operator import Door, OperatorClient
from gimbal_hil.realtime.telemetry import LiveView, scope_settings

#: of this process: a page that was drawn from another one begins anew
_RUN = secrets.token_hex(8)
_LOOPBACK = "127.0.0.1"
_NAMES = (_LOOPBACK, "localhost")
TOKEN_HEADER = "X-Operator-Token"
#: what the page may ask for; experiments and programs come through the door itself
_COMMANDS = ("set_point", "stop", "quick_stop", "fault_reset", "adjust", "adjust_back", "learn_anew")
_LONGEST_REQUEST = 4096
MOST_CONNECTIONS = 32
_REQUEST = DocumentLimits(size_bytes=_LONGEST_REQUEST, values=50)


class _Connections(ThreadingHTTPServer):
    """So many connections at once and no more: where one more comes, the oldest has to go, so that silent ones neither
    use up this process' descriptors nor lock anybody out.
    """

    daemon_threads = True

    def __init__(self, handler: type[BaseHTTPRequestHandler], port: int) -> None:
        self._open: dict[socket.socket, None] = {}
        self._turn = threading.Lock()
        super().__init__((_LOOPBACK, port), handler)

    def process_request(self, request: Any, client_address: Any) -> None:
        """Serve one connection in a thread of its own."""
        with self._turn:
            oldest = next(iter(self._open)) if len(self._open) >= MOST_CONNECTIONS else None
            if oldest is not None:
                del self._open[oldest]
            self._open[request] = None
        if oldest is not None:
            # its thread reads the end and closes it
            with contextlib.suppress(OSError):
                oldest.shutdown(socket.SHUT_RDWR)
        super().process_request(request, client_address)

    def shutdown_request(self, request: Any) -> None:
        """One connection is done."""
        with self._turn:
            self._open.pop(request, None)
        super().shutdown_request(request)

    def handle_error(self, request: object, client_address: object) -> None:
        """A connection that broke off is not news."""


class PageServer:
    """Serves a LiveView from threads of the service process; the control process has no part in it."""

    def __init__(self, view: LiveView, port: int, door: Door | None = None, screen: ScopeScreen | None = None) -> None:
        """`port` 0 takes any free one; BadInputError when it is taken. Without a door nothing can be commanded."""
        handler = type("Handler", (_Handler,), {"view": view, "door": door, "screen": screen})
        try:
            self._server = _Connections(handler, port)
        except OSError as error:
            raise BadInputError("--page", f"port {port}: {error.strerror}", "a free port, or 0 for any") from None
        self._thread = threading.Thread(target=self._server.serve_forever, daemon=True)
        self._thread.start()

    @property
    def url(self) -> str:
        """Where the page is."""
        return f"http://{_LOOPBACK}:{self._server.server_address[1]}/"

    def close(self) -> None:
        """Stop serving."""
        self._server.shutdown()
        self._server.server_close()


class _Handler(BaseHTTPRequestHandler):
    view: LiveView
    door: Door | None
    screen: ScopeScreen | None
    #: a client that says nothing is not waited for
    timeout = 5

    def do_HEAD(self) -> None:
        """Answer as GET would, without the content."""
        self.do_GET()

    def do_GET(self) -> None:
        """Answer one request."""
        if self._host_name() not in _NAMES:
            # a page from elsewhere that resolved its own name to this machine
            self._answer(403, "text/plain", b"only for this machine\n")
            return
        parts = urlsplit(self.path)
        if parts.path == "/":
            self._answer(200, "text/html; charset=utf-8", PAGE.encode())
        elif parts.path == "/live.json":
            since = parse_qs(parts.query).get("since", ["-1"])[0]
            self._answer(200, "application/json", json.dumps(live(self.view, _number(since))).encode())
        elif parts.path == "/scope.json" and self.screen is not None:
            asked = parse_qs(parts.query)
            have, wanted = (int(_number(asked.get(name, ["0"])[0])) for name in ("have", "show"))
            self._json(200, self.screen.document(have, self.view.axes, wanted))
        elif parts.path == "/metrics":
            text = metrics_text(self.view)
            if text is None:
                self._answer(501, "text/plain", b"metrics need prometheus-client: pip install 'gimbal-hil[metrics]'\n")
            else:
                self._answer(200, CONTENT_TYPE, text)
        else:
            self._answer(404, "text/plain", b"/, /live.json, /scope.json, /metrics\n")

    def do_POST(self) -> None:
        """Act for whoever shows the operator's token."""
        if self._host_name() not in _NAMES:
            self._answer(403, "text/plain", b"only for this machine\n")
            return
        path = urlsplit(self.path).path
        if self.door is None or path not in ("/act", "/scope"):
            self._answer(501, "text/plain", b"nothing can be commanded here\n")
            return
        # a foreign page cannot send this content type or this header without being asked first, and nobody answers that
        if self.headers.get("Content-Type", "") != "application/json" or not hmac.compare_digest(
            self.headers.get(TOKEN_HEADER, "").encode(), self.door.token.encode()
        ):
            self._json(403, {"ok": False, "error": "not without the operator's token (operator.json of the run)"})
            return
        length = int(_number(self.headers.get("Content-Length", "0")))
        if not 0 < length <= _LONGEST_REQUEST:
            self._json(400, {"ok": False, "error": f"a request has at most {_LONGEST_REQUEST} bytes"})
            return
        try:
            request = json_line(self.rfile.read(length), "the request", "one JSON object", _REQUEST)
            self._json(200, self._acted(path, request))
        except (BadInputError, LinkError) as error:
            self._json(200, {"ok": False, "error": str(error)})

    def _acted(self, path: str, request: dict[str, object]) -> Json:
        assert self.door is not None
        if path == "/scope":
            if self.screen is None:
                raise BadInputError("scope", "there is none", "a daemon that records")
            self.screen.scope.ask(scope_settings(request, self.view.axes))
            return {"ok": True}
        command = request.pop("command", None)
        if command not in _COMMANDS:
            raise BadInputError("command", f"is {command!r}", ", ".join(_COMMANDS))
        with OperatorClient(self.door) as client:
            return client.request(command, **request)

    def _json(self, status: int, document: dict[str, object]) -> None:
        self._answer(status, "application/json", json.dumps(document).encode())

    def log_message(self, format: str, *args: object) -> None:
        """Requests are not news."""

    def _host_name(self) -> str:
        return self.headers.get("Host", "").rsplit(":", 1)[0]

    def _answer(self, status: int, kind: str, content: bytes) -> None:
        self.send_response(status)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(content)))
        self.send_header("Cache-Control", "no-store")
        self.send_header(
            "Content-Security-Policy",
            "default-src 'self'; img-src data:; script-src 'unsafe-inline'; style-src 'unsafe-inline'",
        )
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(content)


def live(view: LiveView, since_s: float) -> Json:
    """What the page draws: status, how recording stands, trace after `since_s`, latency histogram as [upper bound in
    us, count]; `run` is another one after a restart.
    """
    bins = [[upper_bound_ns(index) / 1e3, count] for index, count in enumerate(view.latency.counts) if count]
    trace = _without_nan(view.trace(since_s))
    return {
        "run": _RUN,
        "status": view.status(),
        "recording": view.recording(),
        "adjustable": view.adjustable(),
        "trace": trace,
        "latency_bins_us": bins,
    }


def _without_nan(columns: dict[str, list[float]]) -> dict[str, list[float | None]]:
    """JSON knows no NaN: where an axis has no reference there is none."""
    return {name: [value if math.isfinite(value) else None for value in column] for name, column in columns.items()}


def _number(text: str) -> float:
    try:
        number = float(text)
    except ValueError:
        return -1.0
    return number if math.isfinite(number) else -1.0
