"""What the page shows of the scope: its settings, what it does, and its captures, the newest or an older one."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import asdict

from gimbal_hil.realtime.telemetry import Capture, Scope, capture_columns, signal_names

#: captures that can be looked at again, and ticks that they hold in all: older ones are read from the run
_MOST, _MOST_TICKS = 20, 60_000


class ScopeScreen:
    """The service shows captures, the server reads; what passes between their threads is replaced whole."""

    def __init__(self, scope: Scope) -> None:
        self.scope = scope
        self._kept: tuple[tuple[Capture, str | None, str | None], ...] = ()

    def show(self, capture: Capture, folder: str | None, failure: str | None) -> None:
        """A capture has become whole; where it is kept, or why it is not."""
        kept = deque((*self._kept, (capture, folder, failure)), maxlen=_MOST)
        while len(kept) > 1 and sum(len(one.exchanges) for one, _, _ in kept) > _MOST_TICKS:
            kept.popleft()
        self._kept = tuple(kept)

    def document(self, have: int, axes: Sequence[str], wanted: int = 0) -> dict[str, object]:
        """For the page: capture number `wanted` (0, or one that is gone: the newest), left out where it is number
        `have`, which the page shows already.
        """
        kept = self._kept
        found: dict[str, object] = {
            "state": self.scope.state.value,
            "settings": asdict(self.scope.settings),
            "signals": signal_names(axes),
            "numbers": [capture.number for capture, _, _ in kept],
            "capture": None,
        }
        chosen = next((one for one in kept if one[0].number == wanted), kept[-1] if kept else None)
        if chosen is not None and chosen[0].number != have:
            capture, folder, failure = chosen
            found["capture"] = {
                "number": capture.number,
                "trigger_tick": capture.trigger_tick,
                "folder": folder,
                "failure": failure,
                "columns": capture_columns(capture, axes),
            }
        return found
