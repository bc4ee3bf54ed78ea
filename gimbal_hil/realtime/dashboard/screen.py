"""What the page shows of the scope: its settings, what it does, and its last capture."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from gimbal_hil.realtime.telemetry import Capture, Scope, capture_columns, signal_names


class ScopeScreen:
    """The service shows captures, the server reads; what passes between their threads is replaced whole."""

    def __init__(self, scope: Scope) -> None:
        self.scope = scope
        self._last: tuple[Capture, str | None, str | None] | None = None

    def show(self, capture: Capture, folder: str | None, failure: str | None) -> None:
        """A capture has become whole; where it is kept, or why it is not."""
        self._last = (capture, folder, failure)

    def document(self, have: int, axes: Sequence[str]) -> dict[str, Any]:
        """For the page: the last capture is left out where it is number `have` already."""
        found: dict[str, Any] = {
            "state": self.scope.state.value,
            "settings": asdict(self.scope.settings),
            "signals": signal_names(axes),
            "capture": None,
        }
        last = self._last
        if last is not None and last[0].number != have:
            capture, folder, failure = last
            found["capture"] = {
                "number": capture.number,
                "trigger_tick": capture.trigger_tick,
                "folder": folder,
                "failure": failure,
                "columns": capture_columns(capture, axes),
            }
        return found
