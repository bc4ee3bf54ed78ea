"""A small HTTP server on the loopback address: the page, its data as JSON, the metrics. It reads; nothing can be
commanded here.
"""

from __future__ import annotations

import json
import math
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any
from urllib.parse import parse_qs, urlsplit

from firmware_protocol.errors import BadInputError
from gimbal_hil.dashboard.metrics import CONTENT_TYPE, metrics_text
from gimbal_hil.dashboard.page import PAGE
from gimbal_hil.telemetry import LiveView
from gimbal_hil.timing import upper_bound_ns

_LOOPBACK = "127.0.0.1"
_NAMES = (_LOOPBACK, "localhost")


class PageServer:
    """Serves a LiveView from threads of the service process; the control process knows nothing of it."""

    def __init__(self, view: LiveView, port: int) -> None:
        """`port` 0 takes any free one; BadInputError when it is taken."""
        handler = type("Handler", (_Handler,), {"view": view})
        try:
            self._server = ThreadingHTTPServer((_LOOPBACK, port), handler)
        except OSError as error:
            raise BadInputError("--page", f"port {port}: {error.strerror}", "a free port, or 0 for any") from None
        self._server.daemon_threads = True
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
    #: a client that says nothing is not waited for
    timeout = 10

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
        elif parts.path == "/metrics":
            text = metrics_text(self.view)
            if text is None:
                self._answer(501, "text/plain", b"metrics need prometheus-client: pip install 'gimbal-hil[metrics]'\n")
            else:
                self._answer(200, CONTENT_TYPE, text)
        else:
            self._answer(404, "text/plain", b"/, /live.json, /metrics\n")

    def log_message(self, format: str, *args: Any) -> None:
        """Requests are not news."""

    def _host_name(self) -> str:
        return self.headers.get("Host", "").rsplit(":", 1)[0]

    def _answer(self, status: int, kind: str, content: bytes) -> None:
        self.send_response(status)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(content)))
        self.send_header("Cache-Control", "no-store")
        self.send_header(
            "Content-Security-Policy", "default-src 'self'; script-src 'unsafe-inline'; style-src 'unsafe-inline'"
        )
        self.end_headers()
        self.wfile.write(content)


def live(view: LiveView, since_s: float) -> dict[str, Any]:
    """What the page draws: status, trace after `since_s`, latency histogram as [upper bound in us, count]."""
    bins = [[upper_bound_ns(index) / 1e3, count] for index, count in enumerate(view.latency.counts) if count]
    return {"status": view.status(), "trace": _without_nan(view.trace(since_s)), "latency_bins_us": bins}


def _without_nan(columns: dict[str, list[float]]) -> dict[str, list[float | None]]:
    """JSON knows no NaN: where an axis has no reference there is none."""
    return {name: [value if math.isfinite(value) else None for value in column] for name, column in columns.items()}


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return -1.0
