"""What each drive of another make says, for `doctor`: who answers, at what rate, what misses, and what it complains
of.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, field

from firmware_protocol.adapters import AdapterLink, DriveReport, ListenedBus, drive_reports, open_bus, probes, strangers
from firmware_protocol.links import AdapterLinkConfig

#: of drives that nobody commands, s
_WATCHDOG_S = 2.0
#: how long answers to questions at all ids are waited for, s
_PROBE_S = 0.2


@dataclass
class HeardDrives:
    """Two drives after they were listened to."""

    drives: list[DriveReport]
    reasons: list[str] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)


class DriveListener:
    """An adapter link that nobody commands, and what is said on its bus. LinkError when it cannot be opened."""

    def __init__(self, config: AdapterLinkConfig) -> None:
        # whoever listens has no real-time priority: a drive is not to fall into fault because of that
        self._config = config = config.model_copy(update={"watchdog_s": _WATCHDOG_S})
        self._buses: list[ListenedBus] = []
        self.link = AdapterLink(config, self._opened)
        self._begun = time.monotonic()

    def judged(self) -> HeardDrives:
        """Everything that was heard until now."""
        bus, config = self._buses[-1], self._config
        seconds = time.monotonic() - self._begun
        drives = self.link.gateway.drives
        found = HeardDrives(drive_reports(drives, config.drives, bus.heard, seconds))
        for report in found.drives:
            found.reasons += report.reasons
            found.remarks += report.remarks
        if any(not report.heard_hz for report in found.drives):
            self._probe(bus)
        others = strangers(drives, config.drives, bus.heard)
        if others:
            known = " and ".join(str(section.id) for section in config.drives)
            found.reasons.append(
                f"a drive of id {', '.join(map(str, others))} answers; link.drives has those of id {known}"
            )
        if bus.dropped:
            found.reasons.append(
                f"{bus.dropped} frames could not be sent: nobody acknowledges them, or the bus takes no frames of "
                "their kind (CAN FD needs link.data_bitrate)"
            )
        if bus.refused:
            found.reasons.append(f"the slcan adapter said no {bus.refused} times (BEL): its channel or its queue")
        found.reasons += [f"the bus says {count} times: {word}" for word, count in sorted(bus.errors.items())]
        return found

    def _probe(self, bus: ListenedBus) -> None:
        """Ask every id of this make, where one that is configured does not answer."""
        for frame in probes(self.link.gateway.drives):
            bus.send(frame)
            bus.receive()
        end = time.monotonic() + _PROBE_S
        while time.monotonic() < end:
            self.link.wait(10_000_000)
            bus.receive()

    def _opened(self) -> ListenedBus:
        config = self._config
        bus = open_bus(config.interface, config.channel, config.bitrate, config.data_bitrate, config.options)
        self._buses.append(ListenedBus(bus))
        return self._buses[-1]
