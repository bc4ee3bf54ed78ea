"""The virtual antenna on a link in lockstep: its time goes on when the host says so, and stands still otherwise."""

from __future__ import annotations

import time

from firmware_protocol.links import Link, LinkState
from firmware_protocol.lockstep import BEGIN, EdgeParser, edge, next_edge
from sim_backend.device import Device
from sim_backend.server.serving import ServingStatistics

#: a wait for the host is looked after so often, for `stop` and the end of the time
_LOOK_NS = 50_000_000


class LockstepServer:
    """Serves a device by the edges of `firmware_protocol.lockstep`. Hosts may come, go and come back; the antenna is
    where it was.
    """

    def __init__(self, device: Device, link: Link) -> None:
        self.device, self.link = device, link
        self._parser = EdgeParser()
        self._number = BEGIN
        self._stopping = False
        self.statistics = ServingStatistics(round(1e9 / device.rate_hz), link=link.name)

    def stop(self) -> None:
        """End `serve`; may be called from a signal handler."""
        self._stopping = True

    def serve(self, duration_ns: int | None = None) -> ServingStatistics:
        """Tick as often as the host asks for `duration_ns` of the wall clock (for ever when None) or until `stop`."""
        end = None if duration_ns is None else time.monotonic_ns() + duration_ns
        link = self.link
        while not self._stopping and (end is None or time.monotonic_ns() < end):
            self._answer(link.receive())
            if link.state is LinkState.LOST:
                link.reopen()
            if not link.wait(_LOOK_NS) and link.state is LinkState.LOST:
                # a lost link has nothing to wait on and says so at once
                time.sleep(_LOOK_NS * 1e-9)
        self.statistics.complete(self.device, link)
        return self.statistics

    def _answer(self, block: bytes) -> None:
        """Every edge that has come: that of a host that begins, or the next one."""
        if not block:
            return
        parser = self._parser
        parser.feed(block)
        left_behind = parser.before(BEGIN)
        if left_behind is not None:
            # a host that has gone may have asked for ticks before: they are made, in the order of asking
            before = EdgeParser()
            before.feed(left_behind)
            self._tick_all(before)
            self._number = BEGIN
            self.link.send(edge(BEGIN))
        self._tick_all(parser)

    def _tick_all(self, parser: EdgeParser) -> None:
        while (received := parser.before(number := next_edge(self._number))) is not None:
            self._number = number
            self.statistics.ticks_by_set_point += 1
            self.link.send(self.device.tick(received) + edge(number))
