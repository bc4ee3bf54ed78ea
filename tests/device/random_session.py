"""A seeded session between a host that does all sorts of things and the device; prints a digest of every frame and of
the final state.
"""

from __future__ import annotations

import hashlib
import random
from collections.abc import Iterator

from firmware_protocol.enumerations import DriveRequest, DriveState, StopReaction
from firmware_protocol.messages import AnyMessage, DeadmanConfig, SetPoint
from sim_backend.device import Device, FirmwareSettings
from sim_backend.model import shipped_model
from tests.device.bench import Bench, FrameWire, MailWire, Wire, control
from tests.endpoints import Sender

TICKS = 600
_NEXT = {
    DriveState.SWITCH_ON_DISABLED: DriveRequest.SHUTDOWN,
    DriveState.READY_TO_SWITCH_ON: DriveRequest.SWITCH_ON,
    DriveState.SWITCHED_ON: DriveRequest.ENABLE_OPERATION,
}


def moving_device() -> Device:
    """The thesis antenna with cogging on a swaying base."""
    model = shipped_model().with_base(
        {
            "motion": "sinusoid",
            "amplitude_rad": {"roll": 0.1, "pitch": 0.2, "yaw": 3.0},
            "frequency_hz": {"roll": 1.0, "pitch": 0.7, "yaw": 0.5},
        }
    )
    model = model.with_effect("cogging", "outer", {"amplitude": 0.05, "order": 12.0, "phase": 0.3})
    return Device(model, FirmwareSettings.for_model(model), seed=11)


def session(wire: Wire) -> str:
    """Digest of a session over this wire."""
    bench = Bench(moving_device(), wire)
    # frames by one codec, whatever the wire: only the device differs
    sender, digest = Sender(), hashlib.sha256()
    for messages in _host(bench):
        bench.answer = wire.exchange(bench.device, messages)
        digest.update(sender.encode(*sorted(bench.answer, key=lambda message: type(message).__name__)))
    device = bench.device
    for array in (device.X, device.drive_words):
        digest.update(array.tobytes())
    return f"{digest.hexdigest()} {bench.state.name} {sum(abs(rate) > 0.1 for rate in device.joint_rates)}"


def _host(bench: Bench) -> Iterator[list[AnyMessage]]:
    dice = random.Random(5)
    sequence, state = 0, DriveState.NOT_READY
    for tick in range(TICKS):
        messages: list[AnyMessage] = []
        if tick == 3:
            messages.append(DeadmanConfig(6, StopReaction.DECELERATE_AND_HOLD))
        if tick % 5 == 0:
            messages.append(
                control(
                    _NEXT.get(state, DriveRequest.NONE), fault_reset=tick % 10 == 0, quick_stop=dice.random() < 0.01
                )
            )
        if dice.random() < 0.93 and not 400 < tick < 420:
            sequence += 1
            messages.append(
                SetPoint(dice.uniform(-8.0, 16.0), dice.uniform(-3.0, 3.0), sequence % 1024, True, dice.random() < 0.9)
            )
        yield messages
        state = bench.state


if __name__ == "__main__":
    import sys

    print(session(FrameWire() if sys.argv[1:] == ["frames"] else MailWire()))
