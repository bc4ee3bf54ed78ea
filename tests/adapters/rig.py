"""A host, an adapter and two simulated drives tick by tick on python-can's virtual bus."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from firmware_protocol.adapters import AdapterLink, Bus, CanFrame, PythonCanBus
from firmware_protocol.links import AdapterLinkConfig
from gimbal_hil.loop.host import AxisCommand, Host, HostState, Mode, Segment, Shape, program_of
from gimbal_hil.loop.settings import DaemonSettings, host_configuration, settings_from_document
from gimbal_hil.surface.starting import AntennaDescription, AxisDescription, LinkChoice, usual_axis
from gimbal_hil.surface.starting.documents import configuration_document, model_document
from sim_backend.drives import DrivenGimbal, SimulatedDrive
from sim_backend.model import ModelKind, model_from_document

RATE_HZ, PERIOD_NS = 1000.0, 1_000_000
_CHANNELS = itertools.count()


def link_section(drive: str, **more: Any) -> dict[str, Any]:
    """The `link` section of two drives of one make on a virtual bus of their own."""
    each: dict[str, Any] = {"cia402": {"counts_per_turn": 262144.0, "rated_torque_nm": 2.0}}.get(drive, {})
    sections = [{"id": 1, "torque_nm": 15.0} | each, {"id": 2, "torque_nm": 6.0, "sign": -1, "gear": 2.0} | each]
    section = {"kind": "adapter", "drive": drive, "interface": "virtual", "channel": f"bus{next(_CHANNELS)}"}
    section |= {"drives": [one | more for one in sections]}
    return section | ({"data_bitrate": 5_000_000} if drive == "moteus" else {})


def settings_and_model(link: dict[str, Any], **more: Any) -> tuple[DaemonSettings, Any]:
    """A stranger's gimbal without gyros, as `init` writes it, behind this link."""
    axes = tuple(
        usual_axis(AxisDescription(name), ModelKind.GIMBAL, place) for place, name in enumerate(("pan", "tilt"))
    )
    antenna = AntennaDescription("mine", ModelKind.GIMBAL, axes, LinkChoice("adapter", link), RATE_HZ, has_gyro=False)
    document = configuration_document(antenna, "model.yaml", link)
    return settings_from_document(document | more, "antenna.yaml"), model_from_document(model_document(antenna), "m")


class MemoryBus:
    """One end of a bus without anything between; `other` hears what it sends."""

    def __init__(self) -> None:
        self.other: MemoryBus | None = None
        self._come: list[CanFrame] = []

    def send(self, frame: CanFrame) -> bool:
        assert self.other is not None
        self.other._come.append(frame)
        return True

    def receive(self) -> list[CanFrame]:
        come, self._come = self._come, []
        return come

    def take_malformed(self) -> int:
        return 0

    def fileno(self) -> int:
        return -1

    def close(self) -> None:
        """Nothing is open."""


def memory_buses() -> tuple[MemoryBus, MemoryBus]:
    """Both ends of a bus that costs next to nothing."""
    near, far = MemoryBus(), MemoryBus()
    near.other, far.other = far, near
    return near, far


@dataclass
class AdapterRig:
    """Everything, advanced by `run`; `lost` makes the bus lose frames of the drives, `unheard` those to them; `far` is
    their end of another bus than python-can's virtual one, of which `bus_more` tells the host, or whose other end is
    `near`; `more` are the configuration's sections.
    """

    drive: str
    drives: list[SimulatedDrive] | None = None
    link_more: dict[str, Any] = field(default_factory=dict)
    more: dict[str, Any] = field(default_factory=dict)
    lost: Callable[[CanFrame], bool] = lambda frame: False
    unheard: Callable[[CanFrame], bool] = lambda frame: False
    number: int = 0
    far: Bus | None = None
    near: Bus | None = None
    bus_more: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        section = link_section(self.drive, **self.link_more) | self.bus_more
        self.settings, model = settings_and_model(section, **self.more)
        config = self.settings.link
        assert isinstance(config, AdapterLinkConfig)
        if self.far is None:
            self.far = PythonCanBus("virtual", str(config.channel), config.bitrate, config.data_bitrate)
        drives = self.drives
        self.gimbal = (
            DrivenGimbal.of_link(model, config)
            if drives is None
            else DrivenGimbal(model, drives, config.drives, RATE_HZ)
        )
        near = self.near
        opened = None if near is None else lambda: near
        self.link = AdapterLink(config, opened, now_ns=lambda: self.number * PERIOD_NS)
        self.host = Host(host_configuration(self.settings))
        self.events: list[str] = []
        self.host_speaks = True

    @property
    def gateway(self) -> Any:
        return self.link.gateway

    def run(self, ticks: int) -> AdapterRig:
        """As the daemon does it: nothing is sent before something was heard."""
        for _ in range(ticks):
            block = self.link.receive()
            if self.host_speaks:
                out = self.host.tick(self.number, self.number * PERIOD_NS, block)
                self.events += [event.text for event in self.host.events()]
                if self.link.statistics.frames_received:
                    self.link.send(out)
            self._drives()
            self.number += 1
        return self

    def _drives(self) -> None:
        """What was sent is heard and answered, then the period passes."""
        assert self.far is not None
        heard = [frame for frame in self.far.receive() if not self.unheard(frame)]
        for frame in (*self.gimbal.hear(heard), *self.gimbal.tick()):
            if not self.lost(frame):
                self.far.send(frame)

    def away(self, ticks: int) -> AdapterRig:
        """The host's process is kept from running; the drives go on."""
        for _ in range(ticks):
            self._drives()
            self.number += 1
        return self

    def connected(self) -> AdapterRig:
        """Run until idle."""
        self.run(400)
        assert self.host.state is HostState.IDLE, (self.host.state, self.events)
        return self

    def position(self, pan: float, tilt: float) -> AdapterRig:
        """Ask for positions from the next tick on."""
        self.host.command(
            program_of([Segment(*(AxisCommand(Mode.POSITION, Shape.HOLD, (target,)) for target in (pan, tilt)))])
        )
        return self

    def torque(self, pan: float, tilt: float) -> AdapterRig:
        """Ask for torques from the next tick on."""
        self.host.command(
            program_of([Segment(*(AxisCommand(Mode.TORQUE, Shape.HOLD, (wanted,)) for wanted in (pan, tilt)))])
        )
        return self

    @property
    def joints(self) -> np.ndarray:
        return self.gimbal.plant.position

    def only_brakes(self) -> bool:
        """Whether no drive has torque but against its own motion."""
        return all(drive.torque_nm * drive.shaft.rate_rad_s <= 0.0 for drive in self.gimbal.drives)

    def has_no_torque(self) -> bool:
        """Whether no drive has any."""
        return all(drive.torque_nm == 0.0 for drive in self.gimbal.drives)

    def close(self) -> None:
        self.link.close()
        if self.far is not None:
            self.far.close()
