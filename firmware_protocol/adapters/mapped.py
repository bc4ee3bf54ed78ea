"""A drive of anybody's: its DBC, and a YAML file that says which of its signals are position, torque and the like.

The form of that file stands in `dbc_map.py`. A value that is not finite, outside the DBC's range, or called invalid
there or in the map, is a fault of the drive: the last good one stays, and is not told as new.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from firmware_protocol.adapters.dbc_map import MessageRef, SignalRef, load_map
from firmware_protocol.adapters.drive import AxisSample, DriveTiming, Gives, Power
from firmware_protocol.adapters.signal_span import not_there, span_of
from firmware_protocol.adapters.spoken import Spoken
from firmware_protocol.errors import BadInputError, refused_below
from firmware_protocol.links import CanFrame, DriveSection

if TYPE_CHECKING:
    from cantools.database.can import Message
    from cantools.database.can.signal import Signal

_GIVES = {
    "rate": Gives.RATE,
    "gyro": Gives.GYRO,
    "torque": Gives.TORQUE,
    "temperature": Gives.TEMPERATURE,
    "supply": Gives.SUPPLY,
}
#: how much of a differentiated position a rate takes on in one sample, where the drive tells none
_RATE_SHARE = 0.2
#: time for a drive whose map does not say how often it tells its power, s
_ANSWERS_S = 0.25
#: a message is gone after so many of its periods
_LOST_PERIODS = 5.0


class MappedDrive:
    """One drive described by a map."""

    is_asked = False

    def __init__(self, section: DriveSection, timing: DriveTiming) -> None:
        if section.map is None:
            raise BadInputError("link.drives: map", "is missing", "the YAML file that maps the drive's DBC")
        with refused_below("link.drives: map"):
            self._map, self._database = load_map(section.map)
        self._offset, self._period_s = self._map.id_step * section.id, timing.period_s
        self._by_identifier = {one.frame_id + self._offset: one for one in self._database.messages}
        self._given = self._map.feedback.given()
        self._signals = {name: self._signal(ref.message, ref.signal) for name, ref in self._given.items()}
        self._spans = {name: span_of(signal) for name, signal in self._signals.items()}
        self._no_values = {
            name: not_there(signal) | frozenset(self._given[name].invalid) for name, signal in self._signals.items()
        }
        command = self._database.get_message_by_name(self._map.torque.message)
        self._command_message, self._torque_span = command, span_of(command.get_signal_by_name(self._map.torque.signal))
        bits = {one.name: span_of(one, by_bits=True) for one in command.signals}
        # nothing, or what is nearest to it where an offset keeps the bits from zero
        self._standing = {name: min(max(0.0, span.low), span.high) for name, span in bits.items()}
        self._standing |= self._map.constants.get(command.name, {})
        shorts = frozenset[Gives]() if self._map.enable.short is None else {Gives.SHORT}
        self.gives = frozenset(_GIVES[name] for name in self._given if name in _GIVES) | shorts
        self._sent: dict[str, int] = {}
        self._heard: dict[str, int] = {}
        self._silent: dict[str, int] = {}
        self._told_power, self._told_fault = Power.OFF, ""
        self._invalid, self._lost = frozenset[str](), frozenset[str]()
        self._periods = self._words = 0
        self.bad_frames = 0
        told = self._map.messages.get(self._map.power.message, MessageRef()).rate_hz
        self.answers_s = _ANSWERS_S if told is None else _LOST_PERIODS / told
        self.spoken = tuple(
            Spoken(
                name,
                f"power, wiring, bit rate, and identifier 0x{self._identifier_of(name):X} (the DBC's, id and id_step)",
                (self._map.messages.get(name) or MessageRef()).rate_hz,
            )
            for name in sorted(self._map.received())
        )
        self.sample = AxisSample(power_updates=0)
        self._is_placed = False
        self._require_writable(section.map, section.torque_nm)

    def sender_of(self, frame: CanFrame) -> int | None:
        # a DBC does not say how other drives of its make are numbered
        return None

    def question_to(self, number: int) -> CanFrame | None:
        return None

    def word_of(self, frame: CanFrame) -> str:
        message = self._by_identifier.get(frame.identifier)
        if message is None or message.is_extended_frame != frame.extended:
            return ""
        return str(message.name) if message.name in self._map.received() else ""

    def _identifier_of(self, name: str) -> int:
        return int(self._database.get_message_by_name(name).frame_id) + self._offset

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

    def starve(self) -> list[CanFrame]:
        # what feeds a drive of a map is not known: nothing is sent
        self._grow_older()
        return []

    def leave(self) -> list[CanFrame]:
        return []

    def release(self) -> list[CanFrame]:
        return [self._command(0.0, self._map.enable.off)]

    def stop(self) -> list[CanFrame]:
        return self._told(self._map.enable.stop)

    def short(self) -> list[CanFrame]:
        return self._told(self._map.enable.short)

    def reset(self) -> list[CanFrame]:
        return self._told(self._map.enable.reset)

    def take(self, frame: CanFrame) -> bool:
        message = self._by_identifier.get(frame.identifier)
        if message is None or message.is_extended_frame != frame.extended:
            return False
        values = self._values(message, frame.data)
        if values is None:
            self.bad_frames += 1
            return False
        self._silent[message.name] = 0
        self._lost -= {message.name}
        changes: dict[str, Any] = {}
        for name, ref in self._given.items():
            if ref.message == message.name and ref.signal in values:
                changes |= self._taken(name, ref, float(values[ref.signal]))
        power = self._map.power
        if power.message == message.name and power.signal in values:
            self._words += 1
            self._told_power, self._told_fault = self._word(float(values[power.signal]))
        self.sample = replace(self.sample, **changes, power_updates=self._words)
        self._judge()
        return True

    def _taken(self, name: str, ref: SignalRef, value: float) -> dict[str, Any]:
        """The fields of a sample that a value changes; one that says nothing counts as told, and changes none."""
        fresh = {"updates": self.sample.updates + 1} if name == "position" else {}
        if not self._spans[name].holds(value) or value in self._no_values[name]:
            self._invalid |= {name}
            return fresh
        self._invalid -= {name}
        found = ref.si(value)
        if ref.wrap_rad is not None and self._is_placed:
            # the shorter way round, from the turn that it is in
            found = self.sample.position_rad + math.remainder(found - self.sample.position_rad, ref.wrap_rad)
        self._is_placed = self._is_placed or name == "position"
        rate = self._differentiated(found) if name == "position" and "rate" not in self._given else {}
        return {_FIELDS[name]: found, **fresh, **rate}

    def _differentiated(self, position_rad: float) -> dict[str, float]:
        """A rate where the drive tells none: the position's low-passed difference."""
        periods, self._periods = max(self._periods, 1), 0
        before = self.sample.rate_rad_s
        if before is None:
            return {"rate_rad_s": 0.0}
        rate = (position_rad - self.sample.position_rad) / (periods * self._period_s)
        return {"rate_rad_s": before + _RATE_SHARE * (rate - before)}

    def _word(self, word: float) -> tuple[Power, str]:
        """What the power signal says, and what of it is a fault; no state has a fraction, and what is no number is
        none.
        """
        power = self._map.power
        if word in power.fault or not word.is_integer():
            named = cast("dict[float, object]", self._signal(power.message, power.signal).choices or {})
            name = named.get(word)
            said = f"{power.message}.{power.signal} = {word:g}" + (f" ({name})" if name else "")
            return Power.FAULT if word in power.fault else Power.REACTING, said
        if word in power.stopping:
            return Power.STOPPING, ""
        return (Power.ON if word in power.on else Power.OFF), ""

    def _judge(self) -> None:
        """Power and fault from what it told, and from what it did not."""
        reasons = [self._told_fault] if self._told_fault else []
        reasons += [f"{name} has no valid value" for name in sorted(self._invalid)]
        reasons += [f"{name} stays away" for name in sorted(self._lost)]
        power = self._told_power
        if reasons:
            power = Power.REACTING if power.is_powered else Power.FAULT
        self.sample = replace(self.sample, power=power, fault=", ".join(reasons))

    def _signal(self, message: str, signal: str) -> Signal:
        return self._database.get_message_by_name(message).get_signal_by_name(signal)

    def _values(self, message: Message, data: bytes) -> Mapping[str, float] | None:
        """Signals of a frame whose CRC is good and whose counter moved on; behind a selector those that it carries."""
        guard = self._map.messages.get(message.name, MessageRef())
        try:
            values = cast("dict[str, float]", message.decode(data, decode_choices=False))
        except Exception:  # too short, or a selector that the DBC does not know
            return None
        if guard.crc is not None and (
            guard.crc not in values or int(values[guard.crc]) != self._map.crc.of(_without(message, guard.crc, data))
        ):
            return None
        if guard.counter is not None:
            if guard.counter.signal not in values:
                return None
            count = int(values[guard.counter.signal])
            if self._heard.get(message.name) == count:
                return None
            self._heard[message.name] = count
        return values

    def _told(self, word: int | None) -> list[CanFrame]:
        """A word of the map without torque; that for off where it has none."""
        return [self._command(0.0, self._map.enable.off if word is None else word)]

    def _command(self, torque_nm: float, enable: int) -> CanFrame:
        ref, message = self._map.torque, self._command_message
        guard = self._map.messages.get(message.name, MessageRef())
        span = self._torque_span
        values = self._standing | {
            ref.signal: min(max(ref.physical(torque_nm), span.low), span.high),
            self._map.enable.signal: enable,
        }
        if guard.counter is not None:
            count = self._sent[message.name] = (self._sent.get(message.name, -1) + 1) % guard.counter.modulo
            values[guard.counter.signal] = count
        data = message.encode(values, scaling=True, strict=False)
        if guard.crc is not None:
            values[guard.crc] = self._map.crc.of(_without(message, guard.crc, data))
            data = message.encode(values, scaling=True, strict=False)
        return CanFrame(message.frame_id + self._offset, data, message.is_extended_frame)

    def _require_writable(self, path: Path, largest_nm: float) -> None:
        """Whatever a tick may send is written once here, so that none ends in a traceback."""
        try:
            for word in self._map.enable.words().values():
                for torque_nm in (-largest_nm, largest_nm):
                    self._command(torque_nm, word)
        except Exception as error:  # cantools has errors of its own for each thing that a DBC can get wrong
            raise BadInputError(
                f"{path}: dbc",
                f"{self._command_message.name} cannot be written: {error}",
                "a message whose signals have a factor that is not 0, and selectors with values of theirs",
            ) from None
        self._sent.clear()

    def _grow_older(self) -> None:
        """A message with a stated rate that stays away is a fault: its last values say nothing any more."""
        self._periods += 1
        for name, guard in self._map.messages.items():
            if guard.rate_hz is None or name not in self._silent:
                continue
            self._silent[name] += 1
            if self._silent[name] * self._period_s * guard.rate_hz > _LOST_PERIODS:
                self._lost |= {name}
                self._judge()


_FIELDS = {
    "position": "position_rad",
    "rate": "rate_rad_s",
    "gyro": "gyro_rad_s",
    "torque": "torque_nm",
    "temperature": "temperature_degc",
    "supply": "supply_v",
}


def _without(message: Message, signal: str, data: bytes) -> bytes:
    """The bytes of a frame without that of its CRC."""
    place = message.get_signal_by_name(signal).start // 8
    return data[:place] + data[place + 1 :]
