"""The YAML file that maps a drive's DBC: its form, and what is found wrong before anything is sent.

    schema: 1
    dbc: servo.dbc                 # beside this file
    id_step: 16                    # identifiers are those of the DBC plus this times the drive's id
    feedback:
      position: {message: Status, signal: Angle, unit: deg, scale: 1.0, sign: -1, wrap: 360, invalid: [-1]}
      rate: {message: Status, signal: Speed, unit: rpm}
    power: {message: Status, signal: State, on: [4], stopping: [5], fault: [15]}
    torque: {message: Command, signal: Torque, unit: N m}
    enable: {message: Command, signal: Run, on: 1, off: 0, reset: 2}
    constants: {Command: {Mode: 3}}
    messages:
      Status: {rate_hz: 1000, counter: {signal: Alive, modulo: 16}, crc: Check}
      Command: {counter: {signal: Alive, modulo: 16}, crc: Check}
    crc: {polynomial: 0x1D, start: 0xFF, final: 0xFF}
    watchdog: the drive lets go 20 ms after the last Command

Scale and offset of the DBC count first; `unit` says what its physical values are in. `wrap` is the span after which a
single-turn encoder begins again; `invalid` lists values that are none, beside those that the DBC's value table calls
so. `watchdog` says in words what stops the drive when its host is gone, for `doctor`.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, cast

from pydantic import Field

from firmware_protocol.adapters.signal_span import UNITS, span_of, spelled_as, step_of
from firmware_protocol.documents import Strict, read_yaml, validated
from firmware_protocol.errors import BadInputError

if TYPE_CHECKING:
    from cantools.database.can import Database

KINDS = {
    "position": ("rad", "deg", "turn"),
    "rate": ("rad/s", "deg/s", "rpm", "turn/s"),
    "gyro": ("rad/s", "deg/s", "rpm", "turn/s"),
    "torque": ("N m", "mN m"),
    "temperature": ("degC",),
    "supply": ("V", "mV"),
}
#: rad: no encoder of an axis under control has so large a step; a float without its value type looks like that
_COARSEST_POSITION_RAD = 0.1
#: rad: what begins again sooner folds a jump away before a guard can see it
_SHORTEST_WRAP_RAD = 0.5
#: bytes of a classic frame, and the largest identifiers, standard and extended
_FRAME_BYTES, _LAST_IDENTIFIERS = 8, (0x7FF, 0x1FFF_FFFF)
_EXPECTED = "a map of a DBC with the keys schema, dbc, feedback, power, torque, enable"


class SignalRef(Strict):
    """One signal of the DBC as a quantity of the axis."""

    message: str
    signal: str
    unit: str
    scale: float = 1.0
    sign: Literal[-1, 1] = 1
    #: values, as the DBC scales them, that say that there is none
    invalid: tuple[float, ...] = ()
    #: position only: span in `unit` after which a single-turn encoder begins again
    wrap: Annotated[float, Field(gt=0.0)] | None = None

    def si(self, value: float) -> float:
        """A physical value of the DBC in SI units of the axis."""
        return self.sign * self.scale * UNITS[self.unit] * value

    def physical(self, value: float) -> float:
        """The other way."""
        return value / (self.sign * self.scale * UNITS[self.unit])

    @property
    def wrap_rad(self) -> float | None:
        """The span of a single-turn encoder in rad."""
        return None if self.wrap is None else abs(self.scale) * UNITS[self.unit] * self.wrap


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
        return {name: ref for name in KINDS if (ref := getattr(self, name)) is not None}


class PowerRef(Strict):
    """The signal that says whether torque can be applied; `stopping` are values of a drive that stops, or holds after a
    stop, with torque of its own. Every other value says that there is none.
    """

    message: str
    signal: str
    on: tuple[int, ...]
    stopping: tuple[int, ...] = ()
    fault: tuple[int, ...] = ()


class EnableRef(Strict):
    """The signal that asks for torque; `reset` is sent once to clear a fault."""

    message: str
    signal: str
    on: int = 1
    off: int = 0
    reset: int | None = None
    #: for a quick stop by the drive's own sensor, and to short the winding, a stop without a sensor; `off` without them
    stop: int | None = None
    short: int | None = None

    def words(self) -> dict[str, int]:
        """Values that may be sent, by key."""
        found = {"on": self.on, "off": self.off, "reset": self.reset, "stop": self.stop, "short": self.short}
        return {key: word for key, word in found.items() if word is not None}


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

    def meanings(self) -> list[tuple[str, str, str]]:
        """(key, message, signal) of everything that is read from a frame or written into one."""
        found = [(key, ref.message, ref.signal) for key, ref in self.quantities().items()]
        found += [
            ("power", self.power.message, self.power.signal),
            ("enable", self.enable.message, self.enable.signal),
        ]
        found += [(f"constants.{name}", name, signal) for name, values in self.constants.items() for signal in values]
        for name, message in self.messages.items():
            signals = [message.counter.signal if message.counter else None, message.crc]
            found += [(f"messages.{name}", name, signal) for signal in signals if signal]
        return found

    def quantities(self) -> dict[str, SignalRef]:
        """Signals that are numbers with a unit, by their key in the file."""
        return {f"feedback.{name}": ref for name, ref in self.feedback.given().items()} | {"torque": self.torque}

    def received(self) -> set[str]:
        """Messages that the drive sends."""
        return {ref.message for ref in self.feedback.given().values()} | {self.power.message}


def load_map(path: Path) -> tuple[DriveMap, Database]:
    """A map and its DBC (of cantools); BadInputError names file and key of what is wrong or not in the DBC."""
    found = validated(DriveMap, read_yaml(path, _EXPECTED), str(path))
    try:
        import cantools
    except ImportError:
        raise BadInputError(str(path), "needs the package cantools", "pip install 'gimbal-hil[dbc]'") from None
    place = path.parent / found.dbc
    try:
        database = cast("Database", cantools.database.load_file(place, database_format="dbc"))
    except Exception as error:  # cantools has errors of its own for every line that it cannot read
        raise BadInputError(f"{path}: dbc", f"{place} cannot be read: {error}", "a DBC file beside the map") from None
    _require_signals(found, database, path)
    for key, ref in {
        **{f"feedback.{name}": ref for name, ref in found.feedback.given().items()},
        "torque": found.torque,
    }.items():
        _require_unit(key, ref, database, path)
    _require_words(found, database, path)
    _require_checksums(found, database, path)
    _require_sendable(found, database, path)
    return found, database


def require_torque(path: Path, torque_nm: float) -> None:
    """BadInputError where the torque signal of a map cannot carry `torque_nm`, N m at the shaft, to both sides."""
    found, database = load_map(path)
    signal = database.get_message_by_name(found.torque.message).get_signal_by_name(found.torque.signal)
    span = span_of(signal)
    ends = sorted((found.torque.si(span.low), found.torque.si(span.high)))
    if ends[0] > -torque_nm or ends[1] < torque_nm:
        raise BadInputError(
            f"{path}: torque.signal",
            f"{found.torque.message}.{found.torque.signal} carries {ends[0]:.6g} to {ends[1]:.6g} N m, "
            f"the drive may be asked for {-torque_nm:.6g} to {torque_nm:.6g}",
            "a smaller torque_nm of the drive, or a signal (bits, sign, factor, range) that carries it",
        )


def identifiers(path: Path, drive_id: int) -> frozenset[int]:
    """CAN identifiers of all messages that a map uses for the drive of this id."""
    found, database = load_map(path)
    used: set[int] = set()
    for name in (*sorted(found.received()), found.torque.message):
        message = database.get_message_by_name(name)
        identifier, last = message.frame_id + found.id_step * drive_id, _LAST_IDENTIFIERS[message.is_extended_frame]
        if identifier > last:
            raise BadInputError(
                f"{path}: id_step",
                f"{name} of the drive {drive_id} would have the identifier 0x{identifier:X}",
                f"one up to 0x{last:X}: a smaller id or id_step",
            )
        used.add(identifier)
    return frozenset(used)


def _require_signals(found: DriveMap, database: Database, path: Path) -> None:
    named = found.quantities()
    for key, ref in named.items():
        units = KINDS[key.rpartition(".")[2]]
        if ref.unit not in units:
            raise BadInputError(f"{path}: {key}.unit", f"{ref.unit!r}", " or ".join(units))
        if ref.wrap is not None and key != "feedback.position":
            raise BadInputError(f"{path}: {key}.wrap", "only a position begins again after a turn", "no such key")
    known = {message.name: [one.name for one in message.signals] for message in database.messages}
    meant: dict[tuple[str, str], str] = {}
    for key, name, signal in found.meanings():
        if name not in known:
            raise BadInputError(f"{path}: {key}", f"the DBC has no message {name!r}", ", ".join(known))
        if signal not in known[name]:
            raise BadInputError(f"{path}: {key}", f"{name} has no signal {signal!r}", ", ".join(known[name]))
        if (name, signal) in meant:
            said = f"{name}.{signal} is that of {meant[name, signal]} already"
            raise BadInputError(f"{path}: {key}", said, "a signal of its own for each meaning")
        meant[name, signal] = key
    if found.enable.message != found.torque.message:
        raise BadInputError(
            f"{path}: enable.message", f"{found.enable.message!r}", f"that of torque, {found.torque.message!r}"
        )


def _require_unit(key: str, ref: SignalRef, database: Database, path: Path) -> None:
    """The DBC's own unit is that of the map, and a position has a step that an encoder can have."""
    signal = database.get_message_by_name(ref.message).get_signal_by_name(ref.signal)
    told = spelled_as(signal.unit)
    if told is not None and told != ref.unit and ref.scale == 1.0:
        raise BadInputError(
            f"{path}: {key}.unit",
            f"{ref.unit!r}, but the DBC says {signal.unit!r} of {ref.message}.{ref.signal}",
            f"{told!r}, or a scale where the DBC is wrong",
        )
    step = abs(ref.si(step_of(signal)))
    if ref.scale == 0.0 or (not signal.is_float and step == 0.0):
        raise BadInputError(
            f"{path}: {key}", f"{ref.message}.{ref.signal} always says the same", "a scale that is not 0"
        )
    if ref.wrap_rad is not None and ref.wrap_rad < _SHORTEST_WRAP_RAD:
        raise BadInputError(
            f"{path}: {key}.wrap", f"{ref.wrap:g} {ref.unit}", f"a span of at least {_SHORTEST_WRAP_RAD} rad, in `unit`"
        )
    if key == "feedback.position" and step > _COARSEST_POSITION_RAD:
        raise BadInputError(
            f"{path}: {key}.signal",
            f"one count of {ref.message}.{ref.signal} is {step:.4g} rad",
            "a factor in the DBC, or, for a float, its line SIG_VALTYPE_",
        )


def _require_words(found: DriveMap, database: Database, path: Path) -> None:
    """No word means two things: least of all one that lets go, or stops, and the one for torque."""
    words = found.enable.words()
    others = [key for key, word in words.items() if key != "on" and word == found.enable.on]
    if others:
        raise BadInputError(
            f"{path}: enable.{others[0]}", f"{found.enable.on} is the word for on", "a word that asks for no torque"
        )
    told = [(key, word) for key in ("on", "stopping", "fault") for word in getattr(found.power, key)]
    bits = span_of(database.get_message_by_name(found.power.message).get_signal_by_name(found.power.signal), True)
    meant: dict[int, str] = {}
    for key, word in told:
        if not bits.holds(word):
            raise BadInputError(
                f"{path}: power.{key}", f"{word} is never said", f"{bits.low:.6g} to {bits.high:.6g}, as the bits carry"
            )
        if meant.setdefault(word, key) != key:
            raise BadInputError(f"{path}: power.{key}", f"{word} is {meant[word]} already", "one meaning for each word")
    if not found.power.on:
        raise BadInputError(f"{path}: power.on", "is empty", "the words of a drive that has torque")


def _require_checksums(found: DriveMap, database: Database, path: Path) -> None:
    """A CRC is a byte of its own, as it is."""
    for name, guard in found.messages.items():
        if guard.crc is None:
            continue
        signal = database.get_message_by_name(name).get_signal_by_name(guard.crc)
        first = 0 if signal.byte_order == "little_endian" else 7
        is_byte = signal.length == 8 and signal.start % 8 == first and not (signal.is_signed or signal.is_float)
        if not is_byte or (signal.scale, signal.offset) != (1, 0):
            raise BadInputError(
                f"{path}: messages.{name}.crc", f"{name}.{guard.crc} is no whole byte", "8 bits (1,0) that fill a byte"
            )


def _require_sendable(found: DriveMap, database: Database, path: Path) -> None:
    """Whatever is sent fits the bits of its signal."""
    message = database.get_message_by_name(found.torque.message)
    if message.length > _FRAME_BYTES:
        raise BadInputError(
            f"{path}: torque.message",
            f"{message.name} has {message.length} bytes",
            f"{_FRAME_BYTES} at most: no CAN FD",
        )
    guard = found.messages.get(message.name, MessageRef())
    torque = span_of(message.get_signal_by_name(found.torque.signal))
    if not torque.holds(0.0):
        raise BadInputError(
            f"{path}: torque.signal", f"{message.name}.{found.torque.signal} cannot carry zero", "a range that holds it"
        )
    sent: dict[str, tuple[str, float]] = {
        f"enable.{key}": (found.enable.signal, float(word)) for key, word in found.enable.words().items()
    }
    sent |= {
        f"constants.{message.name}.{key}": (key, value) for key, value in found.constants.get(message.name, {}).items()
    }
    if guard.counter is not None:
        sent[f"messages.{message.name}.counter.modulo"] = (guard.counter.signal, float(guard.counter.modulo - 1))
    for key, (name, value) in sent.items():
        bits = span_of(message.get_signal_by_name(name), by_bits=True)
        if not (math.isfinite(value) and bits.low <= value <= bits.high):
            raise BadInputError(
                f"{path}: {key}",
                f"{value:.6g} does not fit {message.name}.{name}",
                f"{bits.low:.6g} to {bits.high:.6g}",
            )
    if message.is_multiplexed():
        selectors = [one.name for one in message.signals if one.is_multiplexer]
        missing = [name for name in selectors if name not in found.constants.get(message.name, {})]
        if missing:
            raise BadInputError(
                f"{path}: constants", f"{message.name} has the selector {missing[0]}, and no value for it", "its value"
            )
