"""An antenna in another process whose time waits, behind the link that the control loop knows."""

from __future__ import annotations

import time

from firmware_protocol.errors import LinkError
from firmware_protocol.links import AntennaInStep, Link, LinkBasis, LinkState, require_can_wait
from firmware_protocol.opening import open_link
from gimbal_hil.realtime.daemon.first_opening import PortConfig, comes_with_the_antenna

#: between two tries to open the link of an antenna that is not there yet
_RETRY_S = 0.1


class LockstepLink(LinkBasis):
    """What is sent at tick n is answered by what is received at tick n + 1, as with an antenna in this process. An
    answer that does not come loses the link for good.
    """

    speaks_first = False

    def __init__(self, antenna: AntennaInStep) -> None:
        super().__init__(antenna.name)
        self._antenna = antenna
        self._feedback = b""
        self._opened()

    def receive(self) -> bytes:
        """Feedback of the tick that the last set-point began."""
        feedback, self._feedback = self._feedback, b""
        return self._count_received(feedback)

    def send(self, block: bytes) -> None:
        """Hand a tick's frames over and wait for its feedback."""
        if self.state is not LinkState.OPEN:
            return
        try:
            self._feedback = self._antenna.tick(block)
        except LinkError as error:
            self._lost(error)
        self._count_sent(block, self.state is LinkState.OPEN)

    def wait(self, timeout_ns: int) -> bool:
        """Whether there is feedback; more of it comes with the next set-point only."""
        return bool(self._feedback)

    def hurry(self) -> None:
        """Wait no longer than a second for an answer from now on; may be called from a signal handler."""
        self._antenna.hurry()

    def close(self) -> None:
        """The antenna's time stands still."""
        self._antenna.close()
        self._state = LinkState.CLOSED

    def fileno(self) -> int:
        """None."""
        return -1

    def _connect(self) -> None:
        raise LinkError(f"{self.name}: a run in lockstep does not go on without its antenna")


def open_in_lockstep(config: PortConfig, patience_s: float) -> LockstepLink:
    """Open a link to an antenna in lockstep; one that is not there yet is waited for. LinkError when none comes within
    the patience (for ever with 0), BadInputError for a link that cannot be in lockstep.
    """
    require_can_wait(config)
    return LockstepLink(AntennaInStep(_opened(config, patience_s), patience_s))


def _opened(config: PortConfig, patience_s: float) -> Link:
    began = time.monotonic()
    while True:
        try:
            return open_link(config)
        except LinkError:
            out_of_time = patience_s > 0.0 and time.monotonic() - began >= patience_s
            if out_of_time or not comes_with_the_antenna(config):
                raise
        time.sleep(_RETRY_S)
