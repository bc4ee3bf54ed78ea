"""A host and a fake antenna tick by tick, with everything that was sent taken apart again."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from firmware_protocol import mail as m
from firmware_protocol.block_codec import new_mail, new_receivers, receive_block
from firmware_protocol.schema import INDEX, MESSAGES, Direction, offset
from gimbal_hil.loop.host import (
    AxisCommand,
    Host,
    HostEvent,
    HostState,
    Mode,
    Program,
    Segment,
    Shape,
    core,
    program_of,
)
from gimbal_hil.loop.settings import host_configuration, settings_from_document, shipped_settings
from tests.host.fake_antenna import FakeAntenna

#: interpreted code for the mutants: frames are compiled code's business, so the mail goes straight from side to side
INTERPRETED = os.environ.get("NUMBA_DISABLE_JIT") == "1"


@dataclass(frozen=True)
class Sent:
    """One tick: the set-point sent, raw, and the host's state after it."""

    tick: int
    torque: tuple[int, int]
    enable: tuple[int, int]
    state: HostState


def configuration(**changes: object) -> np.ndarray:
    """C of the shipped settings with changes, keys as `inner__limits__rate_rad_s` or `supervisor__lost_ticks`.

    The fake antenna has no weight, so none is expected of it.
    """
    document = shipped_settings().model_dump(mode="json", by_alias=True)
    for axis in document["axes"].values():
        axis["expectation"]["moment_kg_m"] = [0.0, 0.0, 0.0]
    for name, value in changes.items():
        section = document if name.startswith("supervisor") else document["axes"]
        *path, key = name.split("__")
        for part in path:
            section = section[part]
        section[key] = value
    return host_configuration(settings_from_document(document, "test"))


@dataclass
class HostLoop:
    """Host against fake antenna; `mangle` may change each received block."""

    host: Host = field(default_factory=lambda: Host(configuration()))
    antenna: FakeAntenna = field(default_factory=FakeAntenna)
    mangle: Callable[[bytes], bytes] = bytes
    number: int = 0
    events: list[HostEvent] = field(default_factory=list)
    sent: list[Sent] = field(default_factory=list)
    blocks: list[tuple[bytes, bytes]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.answer = b""
        self._mail, self._receivers = new_mail(), new_receivers()

    def run(self, ticks: int) -> HostLoop:
        """Advance; interpreted code without frames, from mail to mail."""
        if INTERPRETED:
            return self._run_on_mail(ticks)
        for _ in range(ticks):
            received = self.mangle(self.answer)
            block = self.host.tick(self.number, self.number * 1_000_000, received)
            self.blocks.append((received, block))
            receive_block(np.frombuffer(block, dtype=np.uint8).copy(), len(block), self._mail, self._receivers, 0)
            mail = self._mail
            self.sent.append(
                Sent(
                    self.number,
                    (int(mail[m.SET_POINT_TORQUE_OUTER]), int(mail[m.SET_POINT_TORQUE_INNER])),
                    (int(mail[m.SET_POINT_ENABLE_OUTER]), int(mail[m.SET_POINT_ENABLE_INNER])),
                    self.host.state,
                )
            )
            self.answer = self.antenna.tick(block)
            self.events += self.host.events()
            self.number += 1
        return self

    def _run_on_mail(self, ticks: int) -> HostLoop:
        memory, mail = self.host.memory, self._mail
        for _ in range(ticks):
            core.host_tick(mail, memory.H, memory.G, memory.C, self.host.plan, self.number)
            self.sent.append(
                Sent(
                    self.number,
                    (int(mail[m.SET_POINT_TORQUE_OUTER]), int(mail[m.SET_POINT_TORQUE_INNER])),
                    (int(mail[m.SET_POINT_ENABLE_OUTER]), int(mail[m.SET_POINT_ENABLE_INNER])),
                    self.host.state,
                )
            )
            fresh = self.antenna.answer(mail)
            for message in MESSAGES:
                if message.direction is Direction.DEVICE_TO_HOST:
                    mail[offset(message.name)] = int(INDEX[message.name] in fresh)
            self.events += self.host.events()
            self.number += 1
        return self

    def connected(self) -> HostLoop:
        """Run until idle."""
        self.run(30)
        assert self.host.state is HostState.IDLE
        return self

    def command(self, *segments: Segment) -> HostLoop:
        """Follow segments from the next tick on."""
        self.host.command(program_of(segments))
        return self

    def texts(self) -> list[str]:
        """All events in words."""
        return [event.text for event in self.events]


def hold(mode: Mode, outer: float = 0.0, inner: float = 0.0, **more: object) -> Segment:
    """Both axes hold a value in one mode."""
    return Segment(AxisCommand(mode, Shape.HOLD, (outer,)), AxisCommand(mode, Shape.HOLD, (inner,)), **more)  # type: ignore[arg-type]


def one_program(*segments: Segment) -> Program:
    """Segments as a program."""
    return program_of(segments)
