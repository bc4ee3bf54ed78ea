"""Antennas that break one requirement: the virtual one with something done to its frames."""

from __future__ import annotations

from collections.abc import Callable

from firmware_protocol.codec import pack_raw, record, records, unpack_raw
from firmware_protocol.schema import BY_CAN_ID, BY_NAME
from firmware_protocol.words import extract
from sim_backend.device import Device
from tests.device.bench import bench_model

Frames = list[tuple[int, bytes]]
ID = {name: message.can_id for name, message in BY_NAME.items()}


class Altered:
    """The virtual antenna, with what it hears and what it says passed through functions."""

    def __init__(
        self,
        heard: Callable[[Frames, int], Frames] = lambda frames, tick: frames,
        said: Callable[[Frames, int], Frames] = lambda frames, tick: frames,
    ) -> None:
        self.device, self._heard, self._said, self._ticks = Device(bench_model(), seed=1), heard, said, 0
        self._counters: dict[int, int] = {}

    def tick(self, received: bytes = b"") -> bytes:
        self._ticks += 1
        block = _block(self._heard(list(records(received)), self._ticks))
        return _block(self._said(list(records(self.device.tick(block))), self._ticks))


def _block(frames: Frames) -> bytes:
    return b"".join(record(can_id, payload) for can_id, payload in frames)


def _resealed(can_id: int, payload: bytes, change: Callable[[list[int]], None], counter: int | None = None) -> bytes:
    """A payload with other fields, sealed anew."""
    definition = BY_CAN_ID[can_id]
    raw = unpack_raw(definition, payload)
    assert isinstance(raw, tuple)
    fields = list(raw)
    change(fields)
    return pack_raw(definition, fields, payload[6] & 15 if counter is None else counter)


def each(name: str, change: Callable[[list[int]], None]) -> Callable[[Frames, int], Frames]:
    """A message's fields changed in every frame."""

    def altered(frames: Frames, tick: int) -> Frames:
        return [(i, _resealed(i, p, change) if i == ID[name] else p) for i, p in frames]

    return altered


def bad_crc_now_and_then(frames: Frames, tick: int) -> Frames:
    return [(i, bytes([p[0] ^ 1, *p[1:]]) if tick % 97 == 0 else p) for i, p in frames]


def counter_stands_still(frames: Frames, tick: int) -> Frames:
    return [(i, _resealed(i, p, lambda raw: None, 3) if i == ID["drive_status"] else p) for i, p in frames]


def inner_feedback_lost_now_and_then(frames: Frames, tick: int) -> Frames:
    return frames if tick % 50 else [frame for frame in frames if frame[0] != ID["feedback_inner"]]


class OnlyAnswers(Altered):
    """Sends feedback only when something came."""

    def tick(self, received: bytes = b"") -> bytes:
        answer = super().tick(received)
        return answer if received else b""


class AcceptsAnyCrc(Altered):
    """Seals what it hears anew, whatever its CRC."""

    def tick(self, received: bytes = b"") -> bytes:
        repaired = []
        for can_id, payload in records(received):
            definition = BY_CAN_ID.get(can_id)
            if definition is not None and definition.direction == 0:
                fields = int.from_bytes(payload[:6], "little")
                raw = [extract(fields, definition.start(f.name), f.bits, int(f.signed)) for f in definition.fields]
                payload = pack_raw(definition, raw, payload[6] & 15)
            repaired.append((can_id, payload))
        return super().tick(_block(repaired))


class IgnoresCounters(Altered):
    """Gives every set-point the next alive counter, whatever it came with."""

    def tick(self, received: bytes = b"") -> bytes:
        frames = []
        for can_id, payload in records(received):
            if can_id == ID["set_point"] and isinstance(unpack_raw(BY_CAN_ID[can_id], payload), tuple):
                self._counters[can_id] = (self._counters.get(can_id, 0) + 1) & 15
                payload = _resealed(can_id, payload, lambda raw: None, self._counters[can_id])
            frames.append((can_id, payload))
        return super().tick(_block(frames))


class CountsItsOwnSequences(IgnoresCounters):
    """Takes every set-point for a fresh one."""

    def __init__(self) -> None:
        super().__init__(heard=self._renumber)
        self._sequence = 0

    def _renumber(self, frames: Frames, tick: int) -> Frames:
        def number(raw: list[int]) -> None:
            self._sequence = (self._sequence + 1) % 1024
            raw[2] = self._sequence

        good = [(i, p) for i, p in frames if i != ID["set_point"] or isinstance(unpack_raw(BY_CAN_ID[i], p), tuple)]
        return [(i, _resealed(i, p, number) if i == ID["set_point"] else p) for i, p in good]


class FedByItself(Altered):
    """Has a set-point of its own in every tick in which none came: its deadman never runs out."""

    def __init__(self) -> None:
        super().__init__(heard=self._fed)
        self._sequence = self._counter = 0

    def _fed(self, frames: Frames, tick: int) -> Frames:
        for i, p in frames:
            if i == ID["set_point"]:
                raw = unpack_raw(BY_CAN_ID[i], p)
                if isinstance(raw, tuple):
                    self._sequence, self._counter = raw[2], p[6] & 15
                return frames
        self._sequence, self._counter = (self._sequence + 1) % 1024, (self._counter + 1) & 15
        own = pack_raw(BY_NAME["set_point"], [0, 0, self._sequence, 0, 0], self._counter)
        return [*frames, (ID["set_point"], own)]


def set_to(place: int, value: int) -> Callable[[list[int]], None]:
    def change(raw: list[int]) -> None:
        raw[place] = value

    return change


def negate(*places: int) -> Callable[[list[int]], None]:
    def change(raw: list[int]) -> None:
        for place in places:
            raw[place] = -raw[place]

    return change


def add(place: int, amount: int, most: int) -> Callable[[list[int]], None]:
    def change(raw: list[int]) -> None:
        raw[place] = min(most, raw[place] + amount)

    return change


def without(*names: str) -> Callable[[Frames, int], Frames]:
    identifiers = {ID[name] for name in names}
    return lambda frames, tick: [(i, p) for i, p in frames if i not in identifiers]


def slow_motor_messages(frames: Frames, tick: int) -> Frames:
    return [(i, p) for i, p in frames if i != ID["motor_status_outer"] or tick // 50 % 3]


def late_identity(frames: Frames, tick: int) -> Frames:
    """Only what comes by itself: asked for, nothing."""
    return each("drive_control", set_to(7, 0))(frames, tick)


def never_stops(frames: Frames, tick: int) -> Frames:
    def change(raw: list[int]) -> None:
        raw[0], raw[2] = 0 if raw[0] == 6 else raw[0], 0

    return each("drive_control", change)(frames, tick)


#: requirement -> an antenna that breaks it
BROKEN: dict[str, Callable[[], Altered]] = {
    "W-01": lambda: Altered(said=bad_crc_now_and_then),
    "W-02": lambda: Altered(said=counter_stands_still),
    "W-03": AcceptsAnyCrc,
    "W-04": AcceptsAnyCrc,
    "W-05": IgnoresCounters,
    "F-01": lambda: Altered(said=inner_feedback_lost_now_and_then),
    "F-02": lambda: Altered(said=each("drive_status", set_to(5, 77))),
    "F-03": lambda: Altered(said=each("drive_status", set_to(2, 5))),
    "F-04": OnlyAnswers,
    "F-05": lambda: Altered(said=each("feedback_inner", add(1, 20000, 2**21 - 1))),
    "F-06": lambda: Altered(said=slow_motor_messages),
    "I-01": lambda: Altered(said=without("identity_unit")),
    "I-02": lambda: Altered(heard=late_identity),
    "I-03": lambda: Altered(said=each("identity", set_to(0, 1))),
    "S-01": lambda: Altered(said=each("drive_status", set_to(0, 0))),
    "S-02": lambda: Altered(heard=each("drive_control", lambda raw: raw.__setitem__(0, 3 if raw[0] == 2 else raw[0]))),
    "S-03": lambda: Altered(said=each("drive_event", set_to(1, 6))),
    "S-04": FedByItself,
    "S-05": lambda: Altered(heard=each("drive_control", set_to(2, 0))),
    "D-01": FedByItself,
    "D-02": CountsItsOwnSequences,
    "D-03": CountsItsOwnSequences,
    "D-05": lambda: Altered(said=each("drive_status", add(3, 1, 255))),
    "D-06": AcceptsAnyCrc,
    "T-01": lambda: Altered(said=each("feedback_inner", negate(1))),
    "T-02": lambda: Altered(heard=each("set_point", lambda raw: raw.__setitem__(slice(3, 5), [1, 1]))),
    "T-05": lambda: Altered(heard=never_stops),
}
