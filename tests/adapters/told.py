"""Drives of which a test says what they say, and a gateway of two of them that is spoken to tick by tick."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from firmware_protocol.adapters import AxisSample, CanFrame, Power
from firmware_protocol.adapters.gateway import Gateway
from firmware_protocol.codec import pack, record, records, schema_of, unpack
from firmware_protocol.enumerations import BrakeCommand, DriveRequest, DriveState, StopReaction
from firmware_protocol.links import DriveSection
from firmware_protocol.messages import AnyMessage, DriveControl, SetPoint

Powers = tuple[Power | None, Power | None]
OFF, ON, SILENT = (Power.OFF, Power.OFF), (Power.ON, Power.ON), (None, None)


class Told:
    """A drive of which a test says what it says; each frame to it says what it is for."""

    gives = frozenset()  # type: ignore[var-annotated]
    answers_s = 0.005

    def __init__(self, is_asked: bool = True) -> None:
        self.is_asked, self.sample = is_asked, AxisSample()

    def begin(self) -> list[CanFrame]:
        return []

    def ask(self) -> list[CanFrame]:
        return [CanFrame(0, b"fed")]

    def enable(self) -> list[CanFrame]:
        return [CanFrame(5, b"enable")]

    def command(self, torque_nm: float) -> list[CanFrame]:
        return [CanFrame(6, b"torque")]

    def release(self) -> list[CanFrame]:
        return [CanFrame(2, b"release")]

    def stop(self) -> list[CanFrame]:
        return [CanFrame(1, b"stop")]

    def starve(self) -> list[CanFrame]:
        return [CanFrame(3, b"starved")]

    def leave(self) -> list[CanFrame]:
        return [CanFrame(4, b"left")]

    def reset(self) -> list[CanFrame]:
        return [CanFrame(7, b"reset")]

    def take(self, frame: CanFrame) -> bool:
        return False

    def says(self, power: Power, **more: Any) -> None:
        self.sample = replace(self.sample, updates=self.sample.updates + 1, power=power, **more)


class Shorting(Told):
    """One that can be told to short its winding."""

    def short(self) -> list[CanFrame]:
        return [CanFrame(8, b"short")]


class Spoken:
    """A gateway of two told drives."""

    def __init__(self, kind: type[Told] = Told, is_asked: bool = True) -> None:
        self.drives = kind(is_asked), kind(is_asked)
        section = DriveSection(id=1, torque_nm=5.0)
        self.gateway = Gateway(self.drives, (section, section), "two")
        self.count = 0

    def hears(self, *messages: AnyMessage) -> set[bytes]:
        """What the drives are sent in a tick in which the host says this."""
        self.count += 1
        block = b"".join(record(schema_of(one).can_id, pack(one, self.count & 15)) for one in messages)
        return {frame.data for frame in self.gateway.hear(block)}

    def tick(
        self, request: DriveRequest | None, powers: Powers = SILENT, is_fed: bool = True, **control: Any
    ) -> set[bytes]:
        """What they are sent after they have said this, in a tick with or without a set-point, and perhaps with a
        request.
        """
        for drive, power in zip(self.drives, powers, strict=True):
            if power is not None:
                drive.says(power)
        messages: list[AnyMessage] = []
        if is_fed:
            messages.append(SetPoint(0.0, 0.0, (self.count + 1) & 1023, True, True))
        if request is not None:
            brakes = BrakeCommand.AUTOMATIC, BrakeCommand.AUTOMATIC
            asked = DriveControl(request, False, False, False, StopReaction.DECELERATE_AND_HOLD, *brakes, False)
            messages.append(replace(asked, **control))
        return self.hears(*messages)

    def says(self) -> dict[type[AnyMessage], Any]:
        """The feedback set of this tick, by the kinds of its messages."""
        told = [unpack(*one) for one in records(self.gateway.feedback())]
        return {type(one): one for one in told}  # type: ignore[misc]

    def switched_on(self) -> Spoken:
        """Led to where only enabling is left."""
        for request in (DriveRequest.NONE, DriveRequest.SHUTDOWN, DriveRequest.SWITCH_ON):
            for _ in range(3):
                self.tick(request, OFF)
        assert self.gateway.state is DriveState.SWITCHED_ON
        return self

    def enabled(self) -> Spoken:
        """Under torque."""
        self.switched_on()
        for _ in range(3):
            self.tick(DriveRequest.ENABLE_OPERATION, ON)
        assert self.gateway.state is DriveState.OPERATION_ENABLED
        return self
