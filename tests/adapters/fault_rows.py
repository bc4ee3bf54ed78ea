"""What can be wrong with the feedback of a drive of another make: the rows of the matrix of `tests.adapters.faults`.

What is spoilt is what an adapter last heard, so that every row holds for every make.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from firmware_protocol.adapters import AxisSample, Power

#: an axis that is held, moves slowly and fast to a position, and is pushed by a torque
MOTIONS = ("rest", "slow", "fast", "pushed")
_TURN = 2.0 * math.pi
#: samples from before the fault that are kept, one a tick
KEPT = 100


@dataclass(frozen=True)
class Seen:
    """What a spoiler may use: the true sample, ticks since the fault began, samples from before it, oldest first, and
    what a link that is late has still to give.
    """

    now: AxisSample
    ticks: int
    before: Sequence[AxisSample]
    since: Sequence[AxisSample]

    @property
    def then(self) -> AxisSample:
        return self.before[-1]


Spoil = Callable[[Seen], AxisSample]


@dataclass(frozen=True)
class Row:
    """A fault of feedback; within how many ticks it is noticed, and why it need not be in some motions; how far (rad)
    an axis may go, on its own way until then and coasting after it.
    """

    name: str
    spoil: Spoil
    within: int
    not_in: tuple[str, ...] = ()
    reason: str = ""
    gone_rad: float = 5.0


def _shifted(by_rad: float) -> Spoil:
    return lambda seen: replace(seen.now, position_rad=seen.now.position_rad + by_rad)


def _frozen(seen: Seen) -> AxisSample:
    return replace(seen.then, updates=seen.now.updates, power=seen.now.power, power_updates=seen.now.power_updates)


def _stuck_and_moving(seen: Seen) -> AxisSample:
    return replace(seen.now, position_rad=seen.then.position_rad, rate_rad_s=1.0)


def _repeated(seen: Seen) -> AxisSample:
    old = seen.before[seen.ticks % len(seen.before)]
    return replace(old, updates=seen.now.updates, power=seen.now.power, power_updates=seen.now.power_updates)


def _restarted(seen: Seen) -> AxisSample:
    """Off for 50 ms, then as before with its zero where it stood."""
    power = Power.OFF if seen.ticks < 50 else seen.now.power
    return replace(seen.now, position_rad=seen.now.position_rad - seen.then.position_rad + 0.3, power=power)


def _silent_then_a_turn_off(seen: Seen) -> AxisSample:
    if seen.ticks < 1000:
        return replace(seen.then, power=seen.now.power)
    return replace(seen.now, position_rad=seen.now.position_rad - _TURN)


def _late(ticks: int) -> Spoil:
    def old(seen: Seen) -> AxisSample:
        whole = (*seen.before, *seen.since)
        now = seen.now
        return replace(whole[-ticks], updates=now.updates, power=now.power, power_updates=now.power_updates)

    return old


def _still_but_for_noise(seen: Seen) -> AxisSample:
    """A sensor that has come loose, with the noise that it had: 10 urad, 1 mrad/s."""
    place = seen.then.position_rad + 1e-5 * math.sin(seen.ticks**1.3)
    return replace(seen.now, position_rad=place, rate_rad_s=1e-3 * math.sin(seen.ticks**1.7))


def _halved(seen: Seen) -> AxisSample:
    """As of a gear of twice its turns."""
    moved = seen.now.position_rad - seen.then.position_rad
    half = 0.5 * (seen.now.rate_rad_s or 0.0)
    return replace(seen.now, position_rad=seen.then.position_rad + 0.5 * moved, rate_rad_s=half)


def _creeping_alike(seen: Seen) -> AxisSample:
    rate = 0.1 + (seen.now.rate_rad_s or 0.0)
    return replace(seen.now, position_rad=seen.now.position_rad + 1e-4 * seen.ticks, rate_rad_s=rate)


def _slower(seen: Seen) -> AxisSample:
    return replace(seen.now, rate_rad_s=0.5 * (seen.now.rate_rad_s or 0.0))


_HUNTING = "the loops hold an axis so, with a swing that any lag in them makes"
_NO_WAY = "the axis hardly moves, and half of no rate is none"
_HEAVY = (
    "two numbers of one sensor agree, and an axis of twice the inertia moves so: `expectation` allows for half of it"
)
_LOAD = (
    "a load that grows with the torque holds an axis so; `expectation.disturbance_nm` says how large one may be, and "
    "`init` writes 30 % of the torque"
)
_STEP = "a coarse encoder makes such steps, up to 0.05 rad"
_STILL = "true feedback of an axis that stands still is the same, until a loop asks for more torque than may hold it"
ROWS = (
    Row("all of it stands still", _frozen, 1200),
    Row(
        "the position stands still, the rate is true",
        lambda seen: replace(seen.now, position_rad=seen.then.position_rad),
        1500,
        ("rest",),
        _STILL,
    ),
    Row("the position stands still, the rate says 1 rad/s", _stuck_and_moving, 600),
    Row(
        "the rate stands still, the position is true",
        lambda seen: replace(seen.now, rate_rad_s=seen.then.rate_rad_s),
        2500,
    ),
    Row("the rate has the wrong sign", lambda seen: replace(seen.now, rate_rad_s=-(seen.now.rate_rad_s or 0.0)), 1500),
    Row(
        "position and rate have the wrong sign",
        lambda seen: replace(
            seen.now,
            position_rad=2 * seen.then.position_rad - seen.now.position_rad,
            rate_rad_s=-(seen.now.rate_rad_s or 0.0),
        ),
        1500,
    ),
    Row(
        "the position creeps, the rate says rest",
        lambda seen: replace(seen.now, position_rad=seen.now.position_rad + 2e-4 * seen.ticks),
        1500,
    ),
    Row(
        "position and rate creep alike",
        _creeping_alike,
        1200,
        ("rest", "slow", "fast"),
        "two numbers of one sensor agree, and the axis does what they say: only a second sensor can tell",
    ),
    Row("samples of 0.1 s repeat themselves for ever", _repeated, 1500),
    Row("every sample is 60 ms late", _late(60), 1500),
    Row("every sample is 20 ms late", _late(20), 1500, MOTIONS, _HUNTING),
    Row("the rate is half of what it was", _slower, 1500, ("rest", "slow"), _NO_WAY),
    Row("position and rate are half of what they were", _halved, 1500, ("rest", "slow"), _HEAVY, 20.0),
    Row("it stands still but for its noise", _still_but_for_noise, 1500, ("rest",), _LOAD, 35.0),
    Row(
        "the position creeps by 0.04 rad/s, the rate says rest",
        lambda seen: replace(seen.now, position_rad=seen.now.position_rad + 4e-5 * seen.ticks),
        6000,
    ),
    Row("the position jumps by 2 degrees", _shifted(math.radians(2.0)), 500, MOTIONS, _STEP),
    Row("the drive restarts and its zero is lost", _restarted, 100),
    Row("the position jumps by 18 degrees", _shifted(math.radians(18.0)), 5),
    Row(
        "one sample in fifty is 1 rad off",
        lambda seen: replace(seen.now, position_rad=seen.now.position_rad + (seen.ticks % 50 == 0)),
        55,
    ),
    Row("a whole turn is lost", _shifted(-_TURN), 5),
    Row("a whole turn is lost in a silence of a second", _silent_then_a_turn_off, 1100),
    Row("the position is nine turns off", _shifted(9 * _TURN), 5),
    Row("a count of 32 bits wraps", _shifted(-(2**32) / 2**14 * _TURN), 5),
    Row("the position is no number", lambda seen: replace(seen.now, position_rad=math.nan), 5),
    Row("the rate is beyond all reason", lambda seen: replace(seen.now, rate_rad_s=1e6), 5),
    Row("the rate is no number", lambda seen: replace(seen.now, rate_rad_s=math.nan), 5),
)
