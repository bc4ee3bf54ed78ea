"""Sessions between a host that does all sorts of things and two devices that must do the same: a list of actions, drawn
by hypothesis or by a seeded generator, and the two that take them.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterable
from typing import Any

from hypothesis import strategies as st

from firmware_protocol.codec import pack_raw, record
from firmware_protocol.schema import BY_NAME, MESSAGES
from sim_backend.device import Device, FirmwareSettings, Spoilt
from sim_backend.layout import POSITION, RATE, TEMPERATURE
from sim_backend.model import AntennaModel

#: (what, numbers): see `Pair.act`
Action = tuple[str, tuple[float, ...]]
_HOST = ("drive_control", "set_point", "deadman_config")
_PARTS = ("encoder", "gyro", "motor")

_axis = st.integers(0, 1)
_drive = st.tuples(
    st.just("drive_control"),
    st.tuples(
        st.sampled_from([0, 1, 2, 2, 3, 3, 3, 4, 5, 6, 7]),
        *(st.integers(0, 1) for _ in range(3)),
        st.integers(0, 4),
        st.integers(0, 3),
        st.integers(0, 3),
        st.integers(0, 1),
    ),
)
_torque = st.integers(-131072, 131071)
_set_point = st.tuples(
    st.just("set_point"), st.tuples(_torque, _torque, st.sampled_from([1, 1, 1, 1, 0, 2, -1, 600]), _axis, _axis)
)
_deadman = st.tuples(st.just("deadman_config"), st.tuples(st.sampled_from([0, 1, 3, 10, 40, 255]), st.integers(0, 4)))
_ticks = st.tuples(
    st.sampled_from(["run", "run", "silence", "late"]), st.tuples(st.sampled_from([1, 2, 5, 12, 40, 120]))
)
_damage = st.tuples(st.just("damage"), st.tuples(st.integers(0, 79)))
_enable = st.tuples(st.just("enable"), st.just(()))
_place = st.tuples(st.just("place"), st.tuples(_axis, st.floats(-60.0, 60.0)))
_spin = st.tuples(st.just("spin"), st.tuples(_axis, st.floats(-25.0, 25.0)))
_heat = st.tuples(st.just("heat"), st.tuples(_axis, st.floats(-40.0, 200.0)))
_supply = st.tuples(st.just("supply"), st.tuples(st.floats(0.0, 60.0)))
_spoil = st.tuples(
    st.just("spoil"), st.tuples(_axis, st.integers(0, 2), st.integers(0, 6), st.integers(-200000, 200000))
)
_noise = st.tuples(st.just("noise"), st.tuples(st.integers(0, 2**31)))
ACTIONS = st.lists(
    st.one_of(
        _drive, _drive, _set_point, _set_point, _set_point, _enable, _enable, _ticks, _ticks, _ticks, _deadman, _damage,
        _place, _spin, _heat, _supply, _spoil, _noise,
    ),
    max_size=40,
)  # fmt: skip


class Pair:
    """Two devices that are given the same, tick by tick; AssertionError where they differ in a frame."""

    def __init__(self, first: Device, second: Device) -> None:
        self.both = (first, second)
        self.frames = self.ticks = 0
        self.states: set[int] = set()
        self.faults: set[int] = set()
        self._counters = dict.fromkeys(_HOST, 0)
        self._sequence = 0
        self._waiting = b""

    def act(self, action: Action) -> None:
        """Frames wait for the next tick, `run` and the like let ticks pass, all else is done to both antennas."""
        what, numbers = action
        if what in _HOST:
            self._waiting += self._frame(what, [int(n) for n in numbers])
        elif what == "damage":
            bit = int(numbers[0])
            frame = bytearray(self._frame("set_point", [5000, -5000, 1, 1, 1]))
            frame[bit // 8] ^= 1 << bit % 8
            self._waiting += bytes(frame)
        elif what == "noise":
            dice = random.Random(int(numbers[0]))
            known = [message.can_id for message in MESSAGES]
            self._waiting += b"".join(record(dice.choice(known), dice.randbytes(8)) for _ in range(20)) + b"\x10"
        elif what == "enable":
            for request, reset in ((0, 0), (0, 1), (1, 0), (2, 0), (3, 0)):
                self._waiting += self._frame("drive_control", [request, reset, 0, 0, 2, 0, 0, 0])
                self._waiting += self._frame("set_point", [0, 0, 1, 1, 1])
                self.tick()
        elif what in ("run", "silence", "late"):
            for k in range(int(numbers[0])):
                if what == "run" or (what == "late" and k % 3 == 0):
                    self._waiting += self._frame("set_point", [3000, -800, 1, 1, 1])
                self.tick()
        else:
            for device in self.both:
                _done_to(device, what, numbers)

    def tick(self) -> None:
        """One tick of both."""
        block, self._waiting = self._waiting, b""
        first, second = (device.tick(block) for device in self.both)
        self.ticks += 1
        self.frames += len(first) // 10
        assert first == second, f"tick {self.ticks}: {first.hex()} and {second.hex()}"
        self.states.add(int(self.both[0].drive.state))
        self.faults.add(int(self.both[0].drive.fault))

    def _frame(self, name: str, raw: list[int]) -> bytes:
        if name == "set_point":
            self._sequence = (self._sequence + raw[2]) % 1024
            raw = [*raw[:2], self._sequence, *raw[3:]]
        counter = self._counters[name]
        self._counters[name] = (counter + 1) & 15
        definition = BY_NAME[name]
        return record(definition.can_id, pack_raw(definition, raw, counter))


def _done_to(device: Device, what: str, numbers: tuple[float, ...]) -> None:
    axis = min(int(numbers[0]), len(device.model.axes) - 1)
    if what == "place":
        device.X[POSITION + axis] = numbers[1]
    elif what == "spin":
        device.X[RATE + axis] = numbers[1]
    elif what == "heat":
        device.X[TEMPERATURE + axis] = numbers[1]
    elif what == "supply":
        device.set_supply(numbers[0])
    else:
        device.spoil(axis, _PARTS[int(numbers[1])], Spoilt(int(numbers[2])), int(numbers[3]))


def run_both(
    make: Callable[..., Device], other: Callable[..., Device], model: AntennaModel, actions: Iterable[Action],
    settings: FirmwareSettings | None = None, rate_hz: float = 1000.0,
) -> Pair:  # fmt: skip
    """Both devices through all actions; they must leave the same frames, and the plants the same motion."""
    pair = Pair(make(model, settings, rate_hz, 5), other(model, settings, rate_hz, 5))
    for action in actions:
        pair.act(action)
    pair.tick()
    first, second = pair.both
    assert first.X.tobytes() == second.X.tobytes()
    assert (first.set_points, first.repeated_frames) == (second.set_points, second.repeated_frames)
    return pair


def random_actions(seed: int, count: int) -> list[Action]:
    """A long session of the same kinds of actions, mostly ones that keep torque on."""
    dice = random.Random(seed)

    def numbers(*bounds: tuple[float, float]) -> tuple[float, ...]:
        return tuple(dice.randint(int(a), int(b)) if isinstance(a, int) else dice.uniform(a, b) for a, b in bounds)

    kinds: dict[str, tuple[int, Callable[[], tuple[Any, ...]]]] = {
        "run": (8, lambda: (dice.choice([1, 3, 20, 80]),)),
        "silence": (2, lambda: (dice.choice([1, 5, 30, 400]),)),
        "late": (1, lambda: (30,)),
        "enable": (3, lambda: ()),
        "set_point": (6, lambda: numbers((-131072, 131071), (-131072, 131071), (1, 1), (0, 1), (0, 1))),
        "drive_control": (5, lambda: numbers((0, 6), (0, 1), (0, 1), (0, 1), (0, 3), (0, 2), (0, 2), (0, 1))),
        "deadman_config": (1, lambda: numbers((1, 60), (0, 3))),
        "damage": (1, lambda: numbers((0, 79))),
        "noise": (1, lambda: numbers((0, 2**31))),
        "place": (1, lambda: numbers((0, 1), (-2.5, 2.5))),
        "spin": (1, lambda: numbers((0, 1), (-20.0, 20.0))),
        "heat": (1, lambda: numbers((0, 1), (0.0, 130.0))),
        "supply": (1, lambda: (dice.choice([28.0, 28.0, 17.0, 0.0]),)),
        "spoil": (1, lambda: numbers((0, 1), (0, 2), (0, 6), (-200000, 200000))),
    }
    weights = [weight for weight, _ in kinds.values()]
    chosen = dice.choices(list(kinds), weights, k=count)
    actions = [(name, kinds[name][1]()) for name in chosen]
    # what was spoilt, hot or without supply is mended now and then
    for at in range(40, count, 40):
        actions[at : at + 6] = [
            *(("spoil", (axis, part, 0, 0)) for axis in (0, 1) for part in range(3)),
        ]
        actions[at + 6 : at + 10] = [("heat", (0, 20.0)), ("heat", (1, 20.0)), ("supply", (28.0,)), ("place", (0, 0.0))]
    return actions
