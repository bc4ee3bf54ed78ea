"""A link at whose other end are two drives of somebody else: frames of the antenna above, theirs below."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

from firmware_protocol.adapters.bus import Bus, open_bus
from firmware_protocol.adapters.drive import DriveTiming, farewell
from firmware_protocol.adapters.gateway import Gateway
from firmware_protocol.adapters.registry import drive_named
from firmware_protocol.links import AdapterLinkConfig, BusClaim, CanFrame, LinkBasis, LinkState, wait_readable

#: buses that have one host by themselves: in one process, a port that is claimed
_ONE_HOST = ("virtual", "slcan")


class AdapterLink(LinkBasis):
    """Both drives of an antenna. LinkError when the bus cannot be opened.

    The host's set-point is the edge of a tick. While none comes, drives that must be asked are asked once a period, so
    that the antenna's frames arrive before it gets a request; then the deadman counts those periods.
    """

    def __init__(
        self,
        config: AdapterLinkConfig,
        opened: Callable[[], Bus] | None = None,
        now_ns: Callable[[], int] = time.monotonic_ns,
    ) -> None:
        super().__init__(f"{config.drive} on {config.interface} {config.channel}")
        self._config, self._now_ns = config, now_ns
        self._open = opened or (
            lambda: open_bus(config.interface, config.channel, config.bitrate, config.data_bitrate, config.options)
        )
        self._period_ns = round(1e9 / config.rate_hz)
        self._bus: Bus | None = None
        self._claim: BusClaim | None = None
        self._commanded = False
        self.gateway = self._new_gateway()
        self._edge_ns = self._looked_ns = 0
        self._spared_edge_ns = -1
        self._connect()

    def send(self, block: bytes) -> None:
        """The host's block of this tick: heard, and what follows from it sent to the drives."""
        if self._bus is None:
            self._count_sent(block, False)
            return
        self._edge_ns, self._commanded = self._now_ns(), True
        self._emit(self.gateway.hear(block))
        self._count_sent(block, self._bus is not None)

    def receive(self) -> bytes:
        """A feedback set where both drives have told something new since the last one."""
        if self._bus is None:
            return b""
        now_ns, looked_ns = self._now_ns(), self._looked_ns
        self._looked_ns = now_ns
        silent = now_ns - self._edge_ns >= 2 * self._period_ns
        # A host that was kept from running has not fallen silent, and its block follows at once. What lies on the bus
        # answers the question from before, whose tick it has; to ask now would also count this tick twice. If no block
        # follows, the next look asks.
        if silent and now_ns - looked_ns >= 2 * self._period_ns and self._spared_edge_ns != self._edge_ns:
            self._spared_edge_ns = self._edge_ns
        elif silent:
            # the next one is due a period from now, not two
            self._edge_ns = now_ns - self._period_ns
            self._emit(self.gateway.pass_over())
        if self._bus is None:
            return b""
        try:
            frames = self._bus.receive()
        except OSError as error:
            self._lose(error)
            return b""
        self._statistics.malformed += self._bus.take_malformed() + self.gateway.take(frames)
        self.complaint = self._complaint()
        return self._count_received(self.gateway.feedback())

    def _complaint(self) -> str:
        """What is to be said of each drive, by its number on the bus."""
        told = zip(self._config.drives, self.gateway.complaints(), strict=False)
        return "; ".join(f"drive {section.id}: {words}" for section, words in told if words)

    def why_silent(self) -> str:
        """Which drives tell no position any more, with what else is known of them."""
        told = zip(self._config.drives, self.gateway.silent(), strict=True)
        silent = [f"drive {section.id} tells no position" for section, is_silent in told if is_silent]
        return "; ".join([*silent, *([self.complaint] if self.complaint else [])])

    def wait(self, timeout_ns: int) -> bool:
        """Sleep until a frame has come, at most that long."""
        descriptor = self.fileno()
        if descriptor >= 0:
            return wait_readable(descriptor, min(timeout_ns, self._period_ns))
        return self._bus is not None

    def close(self) -> None:
        """Let both drives go, where they were spoken to as their host, and leave the bus."""
        if self._bus is not None and self._commanded:
            self._emit([frame for drive in self.gateway.drives for frame in drive.release()])
        self._emit([frame for drive in self.gateway.drives for frame in farewell(drive)])
        self._leave()
        self._state = LinkState.CLOSED

    def fileno(self) -> int:
        """Descriptor of the bus, -1 where it has none."""
        return -1 if self._bus is None else self._bus.fileno()

    def _connect(self) -> None:
        bus = f"{self._config.interface} {self._config.channel}"
        if self._config.interface == "unix":
            self._claim = BusClaim.of_socket(bus, Path(str(self._config.channel)))
        elif self._config.interface not in _ONE_HOST:
            self._claim = BusClaim(bus)
        try:
            self._bus = self._open()
        except BaseException:
            self._leave()
            raise
        self.gateway = self._new_gateway()
        self._edge_ns = self._looked_ns = self._now_ns()
        self._opened()
        self._emit(self.gateway.begin())

    def _new_gateway(self) -> Gateway:
        config = self._config
        timing = DriveTiming(1.0 / config.rate_hz, config.watchdog_s)
        drives = [drive_named(config.drive)(section, timing) for section in config.drives]
        return Gateway(drives, config.drives, config.name, timing.period_s)

    def _emit(self, frames: list[CanFrame]) -> None:
        # what both drives ask of everybody (SYNC) goes out once
        for frame in dict.fromkeys(frames):
            if self._bus is None:
                return
            try:
                if not self._bus.send(frame):
                    self._statistics.frames_dropped += 1
            except OSError as error:
                self._lose(error)

    def _lose(self, reason: object) -> None:
        self._leave()
        self._lost(reason)

    def _leave(self) -> None:
        bus, self._bus, claim, self._claim = self._bus, None, self._claim, None
        self._commanded = False
        if bus is not None:
            bus.close()
        if claim is not None:
            claim.release()
