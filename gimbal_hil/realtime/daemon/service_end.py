"""What the control process has of the service process."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from gimbal_hil.loop.timing import Clock, RingReader
from gimbal_hil.realtime.daemon.heartbeat import Heartbeat
from gimbal_hil.realtime.telemetry import Telemetry

_WITHOUT_IT = "nothing is recorded and no operator can reach the daemon"


@dataclass(frozen=True)
class ServiceEnd:
    """A ring each way, and whether the process lives. Without a `heartbeat` one that hangs is not noticed."""

    telemetry: Telemetry
    commands: RingReader
    alive: Callable[[], bool]
    heartbeat: Heartbeat | None = None

    def trouble(self, clock: Clock) -> str | None:
        """Why the daemon cannot go on, if it cannot."""
        if not self.alive():
            return f"the service process has died: {_WITHOUT_IT}"
        if self.heartbeat is not None and self.heartbeat.missed(clock.now()):
            return f"{self.heartbeat}: {_WITHOUT_IT}"
        return None
