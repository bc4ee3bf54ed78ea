"""A drive of anybody's: a DBC, and a YAML file that says which of its signals are position, torque and the like.

    schema: 1
    dbc: servo.dbc                 # beside this file
    id_step: 16                    # identifiers are those of the DBC plus this times the drive's id
    feedback:
      position: {message: Status, signal: Angle, unit: deg, scale: 1.0, sign: -1}
      rate: {message: Status, signal: Speed, unit: rpm}
    power: {message: Status, signal: State, on: [4], fault: [15]}
    torque: {message: Command, signal: Torque, unit: N m}
    enable: {message: Command, signal: Run, on: 1, off: 0, reset: 2}
    constants: {Command: {Mode: 3}}
    messages:
      Status: {rate_hz: 1000, counter: {signal: Alive, modulo: 16}, crc: Check}
      Command: {counter: {signal: Alive, modulo: 16}, crc: Check}
    crc: {polynomial: 0x1D, start: 0xFF, final: 0xFF}
    watchdog: the drive lets go 20 ms after the last Command

Scale and offset of the DBC count first; `unit` says what its physical values are in. `watchdog` says in words what
stops the drive when its host is gone, for `doctor`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field

from firmware_protocol.adapters.bus import CanFrame
from firmware_protocol.adapters.drive import AxisSample, DriveTiming, Gives, Power
from firmware_protocol.documents import Strict, read_yaml, validated
from firmware_protocol.errors import BadInputError, refused_below
from firmware_protocol.links import DriveSection

#: factor of a unit to SI
UNITS = {
    "rad": 1.0, "deg": math.pi / 180.0, "turn": 2.0 * math.pi,
    "rad/s": 1.0, "deg/s": math.pi / 180.0, "rpm": math.pi / 30.0, "turn/s": 2.0 * math.pi,
    "N m": 1.0, "mN m": 1e-3, "degC": 1.0, "V": 1.0, "mV": 1e-3,
}  # fmt: skip
_KINDS = {
    "position": ("rad", "deg", "turn"),
    "rate": ("rad/s", "deg/s", "rpm", "turn/s"),
    "gyro": ("rad/s", "deg/s", "rpm", "turn/s"),
    "torque": ("N m", "mN m"),
    "temperature": ("degC",),
    "supply": ("V", "mV"),
}
_GIVES = {
    "gyro": Gives.GYRO,
    "torque": Gives.TORQUE,
    "temperature": Gives.TEMPERATURE,
    "supply": Gives.SUPPLY,
}
#: a message is gone after so many of its periods
_LOST_PERIODS = 5.0
_EXPECTED = "a map of a DBC with the keys schema, dbc, feedback, power, torque, enable"


class SignalRef(Strict):
    """One signal of the DBC as a quantity of the axis."""

    message: str
    signal: str
    unit: str
    scale: float = 1.0
    sign: Literal[-1, 1] = 1

    def si(self, value: float) -> float:
        """A physical value of the DBC in SI units of the axis."""
        return self.sign * self.scale * UNITS[self.unit] * value

    def physical(self, value: float) -> float:
        """The other way."""
        return value / (self.sign * self.scale * UNITS[self.unit])


class Feedback(Strict):
    """What the drive tells."""

    position: SignalRef
    rate: SignalRef | None = None
    gyro: SignalRef | None = None
    torque: SignalRef | None = None
    temperature: SignalRef | None = None
    supply: SignalRef | None = None

    def given(self) -> dict[str, SignalRef]:
        """Those that are there, by name."""
        return {name: ref for name in _KINDS if (ref := getattr(self, name)) is not None}


class PowerRef(Strict):
    """The signal that says whether torque can be applied."""

    message: str
    signal: str
    on: tuple[int, ...]
    fault: tuple[int, ...] = ()


class EnableRef(Strict):
    """The signal that asks for torque; `reset` is sent once to clear a fault."""

    message: str
    signal: str
    on: int = 1
    off: int = 0
    reset: int | None = None
    #: for a quick stop; `off` without it
    stop: int | None = None


class Counter(Strict):
    """An alive counter."""

    signal: str
    modulo: Annotated[int, Field(ge=2)] = 16


class MessageRef(Strict):
    """What protects a message, and how often it comes."""

    rate_hz: Annotated[float, Field(gt=0.0)] | None = None
    counter: Counter | None = None
    #: signal of eight whole bits that holds the CRC over the other bytes
    crc: str | None = None


class Crc8(Strict):
    """A CRC of eight bits, most significant bit first; the standing numbers are those of SAE J1850."""

    polynomial: Annotated[int, Field(ge=1, le=255)] = 0x1D
    start: Annotated[int, Field(ge=0, le=255)] = 0xFF
    final: Annotated[int, Field(ge=0, le=255)] = 0xFF

    def of(self, data: bytes) -> int:
        """CRC of these bytes."""
        crc = self.start
        for byte in data:
            crc ^= byte
            for _ in range(8):
                crc = (crc << 1) ^ self.polynomial if crc & 0x80 else crc << 1
                crc &= 0xFF
        return crc ^ self.final


class DriveMap(Strict):
    """A whole map."""

    schema_: Literal[1] = Field(alias="schema")
    dbc: Path
    id_step: Annotated[int, Field(ge=0)] = 0
    feedback: Feedback
    power: PowerRef
    torque: SignalRef
    enable: EnableRef
    constants: dict[str, dict[str, float]] = Field(default_factory=dict)
    messages: dict[str, MessageRef] = Field(default_factory=dict)
    crc: Crc8 = Crc8()
    watchdog: str = ""


def load_map(path: Path) -> tuple[DriveMap, Any]:
    """A map and its DBC (of cantools); BadInputError names file and key of what is wrong or not in the DBC."""
    found = validated(DriveMap, read_yaml(path, _EXPECTED), str(path))
    try:
        import cantools
    except ImportError:
        raise BadInputError(str(path), "needs the package cantools", "pip install 'gimbal-hil[dbc]'") from None
    place = path.parent / found.dbc
    try:
        database = cantools.database.load_file(place, database_format="dbc")
    except Exception as error:  # cantools has errors of its own for every line that it cannot read
        raise BadInputError(f"{path}: dbc", f"{place} cannot be read: {error}", "a DBC file beside the map") from None
    _require_signals(found, database, path)
    return found, database


def _require_signals(found: DriveMap, database: Any, path: Path) -> None:
    named = {f"feedback.{name}": ref for name, ref in found.feedback.given().items()} | {"torque": found.torque}
    for key, ref in named.items():
        units = _KINDS[key.rpartition(".")[2]]
        if ref.unit not in units:
            raise BadInputError(f"{path}: {key}.unit", f"{ref.unit!r}", " or ".join(units))
    places = [(key, ref.message, ref.signal) for key, ref in named.items()]
    places += [
        ("power", found.power.message, found.power.signal),
        ("enable", found.enable.message, found.enable.signal),
    ]
    places += [(f"constants.{name}", name, signal) for name, values in found.constants.items() for signal in values]
    for name, message in found.messages.items():
        signals = [message.counter.signal if message.counter else None, message.crc]
        places += [(f"messages.{name}", name, signal) for signal in signals if signal]
    for key, name, signal in places:
        known = {message.name: [one.name for one in message.signals] for message in database.messages}
        if name not in known:
            raise BadInputError(f"{path}: {key}", f"the DBC has no message {name!r}", ", ".join(known))
        if signal not in known[name]:
            raise BadInputError(f"{path}: {key}", f"{name} has no signal {signal!r}", ", ".join(known[name]))
    if found.enable.message != found.torque.message:
        raise BadInputError(
            f"{path}: enable.message", f"{found.enable.message!r}", f"that of torque, {found.torque.message!r}"
        )


class MappedDrive:
    """One drive described by a map."""

    def __init__(self, section: DriveSection, timing: DriveTiming) -> None:
        if section.map is None:
            raise BadInputError("link.drives: map", "is missing", "the YAML file that maps the drive's DBC")
        with refused_below("link.drives: map"):
            self._map, self._database = load_map(section.map)
        self._offset, self._period_s = self._map.id_step * section.id, timing.period_s
        self._by_identifier = {one.frame_id + self._offset: one for one in self._database.messages}
        self._given = self._map.feedback.given()
        self.gives = frozenset(_GIVES[name] for name in self._given if name in _GIVES)
        self._sent: dict[str, int] = {}
        self._heard: dict[str, int] = {}
        self._silent: dict[str, int] = {}
        self.bad_frames = 0
        self.sample = AxisSample()

    def begin(self) -> list[CanFrame]:
        return []

    def ask(self) -> list[CanFrame]:
        self._grow_older()
        return []

    def enable(self) -> list[CanFrame]:
        return self.command(0.0)

    def command(self, torque_nm: float) -> list[CanFrame]:
        self._grow_older()
        return [self._command(torque_nm, self._map.enable.on)]

    def release(self) -> list[CanFrame]:
        return [self._command(0.0, self._map.enable.off)]

    def stop(self) -> list[CanFrame]:
        word = self._map.enable.stop
        return self.release() if word is None else [self._command(0.0, word)]

    def reset(self) -> list[CanFrame]:
        word = self._map.enable.reset
        return self.release() if word is None else [self._command(0.0, word)]

    def take(self, frame: CanFrame) -> bool:
        message = self._by_identifier.get(frame.identifier)
        if message is None or message.is_extended_frame != frame.extended:
            return False
        values = self._values(message, frame.data)
        if values is None:
            self.bad_frames += 1
            return False
        self._silent[message.name] = 0
        changes: dict[str, Any] = {}
        for name, ref in self._given.items():
            if ref.message == message.name:
                changes[_FIELDS[name]] = ref.si(float(values[ref.signal]))
        if self._map.feedback.position.message == message.name:
            changes["updates"] = self.sample.updates + 1
        if self._map.power.message == message.name:
            word = int(values[self._map.power.signal])
            on, fault = word in self._map.power.on, word in self._map.power.fault
            changes["power"] = Power.FAULT if fault else Power.ON if on else Power.OFF
        self.sample = replace(self.sample, **changes)
        return True

    def _values(self, message: Any, data: bytes) -> Mapping[str, float] | None:
        """Signals of a frame whose CRC is good and whose counter moved on."""
        guard = self._map.messages.get(message.name, MessageRef())
        try:
            values: dict[str, float] = message.decode(data, decode_choices=False)
        except Exception:  # too short, or a multiplexer that says something else
            return None
        if guard.crc is not None and int(values[guard.crc]) != self._map.crc.of(_without(message, guard.crc, data)):
            return None
        if guard.counter is not None:
            count = int(values[guard.counter.signal])
            if self._heard.get(message.name) == count:
                return None
            self._heard[message.name] = count
        return values

    def _command(self, torque_nm: float, enable: int) -> CanFrame:
        ref, name = self._map.torque, self._map.torque.message
        message = self._database.get_message_by_name(name)
        guard = self._map.messages.get(name, MessageRef())
        signal = message.get_signal_by_name(ref.signal)
        torque = ref.physical(torque_nm)
        low, high = signal.minimum, signal.maximum
        torque = torque if low is None else max(torque, float(low))
        torque = torque if high is None else min(torque, float(high))
        values: dict[str, float] = {one.name: 0.0 for one in message.signals}
        values |= self._map.constants.get(name, {})
        values |= {ref.signal: torque, self._map.enable.signal: enable}
        if guard.counter is not None:
            count = self._sent[name] = (self._sent.get(name, -1) + 1) % guard.counter.modulo
            values[guard.counter.signal] = count
        data = message.encode(values, scaling=True, strict=False)
        if guard.crc is not None:
            values[guard.crc] = self._map.crc.of(_without(message, guard.crc, data))
            data = message.encode(values, scaling=True, strict=False)
        return CanFrame(message.frame_id + self._offset, data, message.is_extended_frame)

    def _grow_older(self) -> None:
        """A message with a stated rate that stays away is a fault: its last values say nothing any more."""
        for name, guard in self._map.messages.items():
            if guard.rate_hz is None or name not in self._silent:
                continue
            self._silent[name] += 1
            if self._silent[name] * self._period_s * guard.rate_hz > _LOST_PERIODS:
                self.sample = replace(self.sample, power=Power.FAULT)


_FIELDS = {
    "position": "position_rad",
    "rate": "rate_rad_s",
    "gyro": "gyro_rad_s",
    "torque": "torque_nm",
    "temperature": "temperature_degc",
    "supply": "supply_v",
}


def _without(message: Any, signal: str, data: bytes) -> bytes:
    """The bytes of a frame without that of its CRC."""
    place = message.get_signal_by_name(signal).start // 8
    return data[:place] + data[place + 1 :]
