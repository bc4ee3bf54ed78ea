"""The virtual antenna in the daemon's own process, behind the same link and the same frames as a real one."""

from __future__ import annotations

from collections.abc import Callable

from firmware_protocol.links import LinkBasis
from gimbal_hil.loop.settings import DaemonSettings, EmbeddedAntenna
from sim_backend.device import Device
from sim_backend.firmware import close_firmware, run_firmware
from sim_backend.model import AntennaModel, model_named

#: a virtual antenna is carried over at most this many missed periods: its deadman has stopped it long before
_MOST_PASSED_OVER = 2000


class EmbeddedLink(LinkBasis):
    """What is sent at tick n is answered by what is received at tick n + 1."""

    speaks_first = False

    def __init__(self, device: Device) -> None:
        super().__init__(f"virtual antenna {device.model.name}")
        self.device = device
        self._feedback: list[bytes] = []
        self._next: Device | None = None
        self._next_tick = 0
        self._told: Callable[[str], None] | None = None
        self._connect()

    def becomes(self, device: Device, tick: int, told: Callable[[str], None]) -> None:
        """From the antenna's tick `tick` on it is this device, in the motion that the one before has, and `told`
        gets a line.
        """
        self._next, self._next_tick, self._told = device, tick, told

    def receive(self) -> bytes:
        """Feedback since the last call."""
        feedback, self._feedback = self._feedback, []
        return self._count_received(b"".join(feedback))

    def send(self, block: bytes) -> None:
        """The host's set-point is the antenna's clock edge."""
        self._count_sent(block, True)
        if self._next is not None and self.device.ticks >= self._next_tick:
            self._next.take_over(self.device)
            close_firmware(self.device)
            self.device, self._next = self._next, None
            assert self._told is not None
            self._told(f"the virtual antenna goes on as {self.device.model.name}")
        self._feedback.append(self.device.tick(block))

    def pass_over(self, periods: int) -> None:
        """Periods in which no set-point came: the antenna goes on by its own clock, and its deadman counts."""
        for _ in range(min(periods, _MOST_PASSED_OVER)):
            self._feedback.append(self.device.tick())

    def wait(self, timeout_ns: int) -> bool:
        """Whether there is feedback; more of it comes with the next set-point only."""
        return bool(self._feedback)

    def close(self) -> None:
        """The antenna stays as it is; its firmware is run no longer."""
        close_firmware(self.device)

    def fileno(self) -> int:
        """None."""
        return -1

    def _connect(self) -> None:
        self._opened()


def embedded_model(link: EmbeddedAntenna) -> AntennaModel:
    """The model that an embedded antenna follows: a shipped name or a file."""
    return model_named(link.embedded.model, "link.embedded.model")


def embedded_antenna(settings: DaemonSettings, link: EmbeddedAntenna) -> EmbeddedLink:
    """A virtual antenna as configured."""
    embedded = link.embedded
    return EmbeddedLink(run_firmware(embedded.firmware, embedded_model(link), settings.rate_hz, embedded.seed))
