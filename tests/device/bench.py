"""A test bench for the virtual antenna's firmware: speaks to it message by message, and moves the antenna by hand."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from typing import Any, Protocol

from firmware_protocol.block_codec import new_mail
from firmware_protocol.codec import from_raw, raw_values, schema_of
from firmware_protocol.enumerations import (
    BrakeCommand,
    DriveRequest,
    DriveState,
    FaultCode,
    StopReaction,
)
from firmware_protocol.messages import AnyMessage, DriveControl, DriveEvent, DriveStatus, SetPoint
from firmware_protocol.schema import MESSAGES, POSITION_STEP_RAD, TORQUE_STEP_NM, Direction, offset
from sim_backend.device import Device, FirmwareSettings, device_tick
from sim_backend.layout import POSITION, RATE, TEMPERATURE
from sim_backend.model import AntennaModel, model_from_document, shipped_model
from tests.endpoints import Receiver, Sender

WINDOW = 10
_CACHED: dict[bool, AntennaModel] = {}


class Wire(Protocol):
    """How messages get to the device and back."""

    def exchange(self, device: Device, messages: Sequence[AnyMessage]) -> list[AnyMessage]:
        """One tick."""


class FrameWire:
    """Frames through the pure Python codec on this side and the compiled one on the device's."""

    def __init__(self) -> None:
        self.sender, self.receiver = Sender(), Receiver(Direction.DEVICE_TO_HOST)

    def exchange(self, device: Device, messages: Sequence[AnyMessage]) -> list[AnyMessage]:
        return self.receiver.receive(device.tick(self.sender.encode(*messages)))


class MailWire:
    """Raw integers straight into `device_tick`, for interpreted code."""

    def __init__(self) -> None:
        self.mail = new_mail()

    def exchange(self, device: Device, messages: Sequence[AnyMessage]) -> list[AnyMessage]:
        for definition in MESSAGES:
            if definition.direction is Direction.HOST_TO_DEVICE:
                self.mail[offset(definition.name)] = 0
        for message in messages:
            slot = offset(schema_of(message).name)
            raw = raw_values(message)
            self.mail[slot : slot + 1 + len(raw)] = (1, *raw)
        device_tick(self.mail, self.mail, device.P, device.K, device.X, device.drive)
        answer = []
        for definition in MESSAGES:
            slot = offset(definition.name)
            if definition.direction is Direction.DEVICE_TO_HOST and self.mail[slot] > 0:
                answer.append(
                    from_raw(definition, [int(x) for x in self.mail[slot + 1 : slot + 1 + len(definition.fields)]])
                )
        return answer


def bench_model(coarse: bool = False) -> AntennaModel:
    """The thesis antenna; `coarse` with one plant step a tick, for interpreted code."""
    if coarse not in _CACHED:
        model = shipped_model()
        _CACHED[coarse] = (
            model_from_document({**model.document, "plant_step_s": 1e-3}, model.where) if coarse else model
        )
    return _CACHED[coarse]


class Bench:
    """A device on the bench. Axes are 0 (outer) and 1 (inner)."""

    def __init__(self, device: Device, wire: Wire | None = None) -> None:
        self.device, self.wire = device, wire or FrameWire()
        self.sequence = 0
        self.events: list[DriveEvent] = []
        self.answer: list[AnyMessage] = []

    def tick(
        self,
        torque: tuple[float, float] | None = (0.0, 0.0),
        *others: AnyMessage,
        sequence: int | None = None,
        **set_point: Any,
    ) -> DriveStatus:
        """One tick with a fresh set-point (none when torque is None) and other messages; answers the status."""
        messages = list(others)
        if torque is not None:
            if sequence is None:
                self.sequence = (self.sequence + 1) % 1024
            number = self.sequence if sequence is None else sequence
            fields = {"enable_outer": True, "enable_inner": True, **set_point}
            messages.append(SetPoint(*torque, number, fields["enable_outer"], fields["enable_inner"]))
        self.answer = self.wire.exchange(self.device, messages)
        self.events += [message for message in self.answer if isinstance(message, DriveEvent)]
        return self.status

    def request(
        self, request: DriveRequest, torque: tuple[float, float] | None = (0.0, 0.0), **flags: Any
    ) -> DriveStatus:
        """One tick with a drive request."""
        return self.tick(torque, control(request, **flags))

    def run(self, ticks: int, torque: tuple[float, float] | None = (0.0, 0.0)) -> DriveStatus:
        """Ticks in a row."""
        for _ in range(ticks):
            self.tick(torque)
        return self.status

    def enable(self, **flags: Any) -> Bench:
        """Take a drive that is not in fault to OPERATION_ENABLED."""
        while self.tick().state is DriveState.NOT_READY:
            pass
        for request in (DriveRequest.SHUTDOWN, DriveRequest.SWITCH_ON, DriveRequest.ENABLE_OPERATION):
            self.tick((0.0, 0.0), control(request, **flags))
        assert self.state is DriveState.OPERATION_ENABLED
        return self

    def place(self, axis: int, position_rad: float) -> None:
        """Turn an axis by hand and let it rest there."""
        self.device.X[POSITION + axis], self.device.X[RATE + axis] = position_rad, 0.0
        self.device.drive.joints[axis].encoder = round(position_rad / POSITION_STEP_RAD)
        self.device.drive.joints[axis].joint_rate = 0

    def spin(self, axis: int, rate_rad_s: float) -> None:
        """Give an axis a joint rate, as if it had had it for some time."""
        self.device.X[RATE + axis] = rate_rad_s
        self.device.drive.joints[axis].joint_rate = self.device.drive.joints[axis].gyro = round(rate_rad_s / 1e-5)

    def heat(self, axis: int, temperature_degc: float) -> None:
        """Warm a winding."""
        self.device.X[TEMPERATURE + axis] = temperature_degc

    @property
    def status(self) -> DriveStatus:
        """Status of the last tick."""
        return next(message for message in self.answer if isinstance(message, DriveStatus))

    @property
    def state(self) -> DriveState:
        """State after the last tick."""
        return self.status.state

    @property
    def fault(self) -> FaultCode:
        """Latched fault after the last tick."""
        return self.status.fault

    @property
    def torque(self) -> tuple[float, float]:
        """Torque applied in the last tick, N m."""
        outer, inner = (int(self.device.drive.joints[axis].applied_torque) for axis in (0, 1))
        return round(outer * TORQUE_STEP_NM, 9), round(inner * TORQUE_STEP_NM, 9)


def control(
    request: DriveRequest = DriveRequest.NONE,
    *,
    fault_reset: bool = False,
    quick_stop: bool = False,
    clear_travel: bool = False,
    stop: StopReaction = StopReaction.DECELERATE_AND_HOLD,
    brakes: tuple[BrakeCommand, BrakeCommand] = (BrakeCommand.AUTOMATIC, BrakeCommand.AUTOMATIC),
    identify: bool = False,
) -> DriveControl:
    """A drive_control message."""
    return DriveControl(request, fault_reset, quick_stop, clear_travel, stop, brakes[0], brakes[1], identify)


def bench(
    interpreted: bool = False,
    base: dict[str, Any] | None = None,
    travel: tuple[float, float] | None = None,
    brakes: bool = True,
    device: Callable[..., Device] = Device,
    **settings: Any,
) -> Bench:
    """A bench with the thesis antenna and firmware settings as given; `travel` limits of both axes (rad), `brakes`
    False for none. `device` makes the device of model, settings and seed.
    """
    model = bench_model(coarse=interpreted)
    if base is not None:
        model = model.with_base(base)
    firmware = FirmwareSettings.for_model(model)
    if not brakes:
        firmware = dataclasses.replace(
            firmware, axes=tuple(dataclasses.replace(axis, holding_torque_nm=0.0) for axis in firmware.axes)
        )
    if travel is not None:
        axes = tuple(
            dataclasses.replace(axis, travel_low_rad=travel[0], travel_high_rad=travel[1]) for axis in firmware.axes
        )
        settings = {"axes": axes, **settings}
    firmware = dataclasses.replace(firmware, **{"deadman_window_ticks": WINDOW, **settings})
    return Bench(device(model, firmware, seed=3), MailWire() if interpreted else FrameWire())
