"""Checks of frames, feedback and identity. Each takes the antenna in SWITCH_ON_DISABLED and answers its evidence."""

from __future__ import annotations

import itertools
import random
import time
from collections.abc import Mapping

from firmware_protocol.codec import record
from firmware_protocol.enumerations import DriveState
from firmware_protocol.messages import AnyMessage, FeedbackInner, FeedbackOuter, Identity, IdentityUnit
from firmware_protocol.schema import MESSAGES, Direction
from gimbal_hil.proof.conformance.stand import NotShownError, Stand, UnmetError, control

Limits = Mapping[str, float]
#: messages that come at a period of more than one tick, and may be left out
_SLOW = tuple(m for m in MESSAGES if m.direction is Direction.DEVICE_TO_HOST and 1 < m.period_ticks < 1000)
_NOISE_SEED = 17


def frames_are_good(stand: Stand, limits: Limits) -> str:
    """Listen for some ticks."""
    stand.run(int(limits["ticks"]))
    if stand.counts.defects:
        raise UnmetError(
            f"of {stand.counts.frames} frames: "
            + ", ".join(f"{n} with {what}" for what, n in stand.counts.defects.items())
        )
    return f"{stand.counts.frames} frames, all good"


def counters_go_up_by_one(stand: Stand, limits: Limits) -> str:
    """Listen for some ticks; a link that loses frames shows here too."""
    stand.run(int(limits["ticks"]))
    if stand.counts.jumps:
        raise UnmetError(
            "a counter did not go up by one: " + ", ".join(f"{m} {n} times" for m, n in stand.counts.jumps.items())
        )
    return f"{stand.counts.frames} frames without a jump or a repeat"


def a_damaged_set_point_is_dropped(stand: Stand, limits: Limits) -> str:
    """Between good set-points, one with each bit wrong in turn: none of their sequences may be echoed."""
    bits = int(limits["bits"])
    stand.tick()
    mark = len(stand.sets)
    wrong = set()
    for bit in range(bits):
        good = stand.frame(stand.set_point())
        stand.counter_goes_back("set_point", 1)
        wrong.add(stand.sequence)
        damaged = bytearray(good)
        damaged[2 + bit // 8] ^= 1 << (bit % 8)
        stand.exchange(raw=bytes(damaged))
        stand.tick()
    stand.run(3)
    taken = [one.status.last_sequence for one in stand.sets[mark:] if one.status.last_sequence in wrong]
    if taken:
        raise UnmetError(f"{len(taken)} of {bits} damaged set-points were taken, sequence {taken[0]} first")
    return f"{bits} damaged set-points, none taken"


def fields_out_of_bounds_are_refused(stand: Stand, limits: Limits) -> str:
    """A deadman_config with window 0 and one with reaction 7, sealed rightly: the deadman must stay as it was."""
    settle = int(limits["settle_ticks"])
    window = stand.latest.status.deadman_margin_ticks
    for raw in ((0, 0), (9, 7)):
        stand.exchange(stand.set_point(), raw=stand.sealed("deadman_config", raw))
        stand.run(settle)
    shown = max(one.status.deadman_margin_ticks for one in stand.sets[-settle:])
    if shown < window - 2:
        raise UnmetError(f"the deadman's window was {window} ticks and is {shown} after a field out of its bounds")
    stand.exchange(stand.set_point(), raw=stand.sealed("drive_control", (9, 0, 0, 0, 0, 0, 0, 0)))
    stand.run(settle)
    if stand.state is not DriveState.SWITCH_ON_DISABLED:
        raise UnmetError(f"a request of 9, which there is not, led to {stand.state.name}")
    return "window 0, reaction 7 and request 9 changed nothing"


def a_repeated_counter_is_dropped(stand: Stand, limits: Limits) -> str:
    """Fresh sequences under alive counters that repeat or come late."""
    stand.run(int(limits["settle_ticks"]))
    mark = len(stand.sets)
    wrong = set()
    for late in range(5):
        # the last good frame had the counter before the next one: 0 late is that one again
        stand.counter_goes_back("set_point", late + 1)
        stand.exchange(stand.set_point())
        wrong.add(stand.sequence)
        stand.counter_goes_back("set_point", -late)
        stand.run(2)
    stand.run(3)
    taken = [one.status.last_sequence for one in stand.sets[mark:] if one.status.last_sequence in wrong]
    if taken:
        raise UnmetError(f"{len(set(taken))} of 5 set-points whose counter repeats or comes late were taken")
    return "5 set-points whose counter repeats or comes late, none taken"


def noise_changes_nothing(stand: Stand, limits: Limits) -> str:
    """Unknown identifiers, the antenna's own messages, random payloads, in bursts beside good set-points."""
    dice = random.Random(_NOISE_SEED)
    mark, sent = len(stand.sets), 0
    known = [m.can_id for m in MESSAGES]
    for k in range(int(limits["ticks"])):
        noise = b""
        for _ in range(int(limits["frames"]) // int(limits["ticks"])):
            identifier = dice.choice(known) if dice.random() < 0.5 else dice.randrange(2048)
            noise += record(identifier, dice.randbytes(8))
            sent += 1
        stand.exchange(stand.set_point(), *([control()] if k % 10 == 0 else []), raw=noise)
    stand.run(5)
    states = {one.status.state for one in stand.sets[mark:]} - {DriveState.SWITCH_ON_DISABLED}
    if states:
        raise UnmetError(f"after noise it was in {', '.join(sorted(state.name for state in states))}")
    if stand.latest.status.last_sequence != stand.sequence and stand.carrier.in_step:
        raise UnmetError("after noise it does not take good set-points any more")
    if len(stand.sets) - mark < 0.9 * limits["ticks"]:
        raise UnmetError(f"{len(stand.sets) - mark} feedback sets in {limits['ticks']:g} ticks of noise")
    return f"{sent} frames of noise, {len(stand.sets) - mark} sets, state unchanged"


def a_host_that_began_anew_is_heard(stand: Stand, limits: Limits) -> str:
    """After a silence the next alive counter looks one late, and must be taken."""
    for late in range(4):
        stand.run(5)
        stand.run(int(limits["silence_ticks"]), silent=True)
        stand.counter_goes_back("set_point", late + 1)
        point = stand.set_point()
        mark = len(stand.sets)
        stand.exchange(point)
        stand.run(int(limits["heard_ticks"]), silent=True)
        if all(one.status.last_sequence != point.sequence for one in stand.sets[mark:]):
            raise UnmetError(f"after {limits['silence_ticks']:g} ticks of silence a counter {late} back was not taken")
    return "4 new beginnings, each heard with its first set-point"


def one_set_a_tick(stand: Stand, limits: Limits) -> str:
    """Which messages of a set come, and in which order."""
    sets = stand.run(int(limits["ticks"]))[1:]
    for one in sets:
        kinds = [type(m).__name__ for m in one.messages if isinstance(m, FeedbackOuter | FeedbackInner)]
        if sorted(kinds) != ["FeedbackInner", "FeedbackOuter"]:
            raise UnmetError(
                f"tick {one.tick}: the set holds {', '.join(kinds) or 'no feedback'} before its drive_status"
            )
    return f"{len(sets)} sets, each whole and closed by drive_status"


def the_tick_counts(stand: Stand, limits: Limits) -> str:
    """Differences of drive_status.tick, through its wrapping."""
    sets = stand.run(int(limits["ticks"]))
    steps = [after.tick - before.tick for before, after in itertools.pairwise(sets)]
    ones = sum(step == 1 for step in steps)
    if not steps or ones < limits["share"] * len(steps):
        raise UnmetError(
            f"{len(steps) - ones} of {len(steps)} steps of the tick are not one; the largest is {max(steps, default=0)}"
        )
    return f"{ones} of {len(steps)} steps are one"


def sequences_are_echoed(stand: Stand, limits: Limits) -> str:
    """Each set-point's sequence in the sets of its own tick and of those after it."""
    stand.run(20)
    sent: dict[int, int] = {}
    mark = len(stand.sets)
    for _ in range(int(limits["ticks"])):
        tick = stand.ticks
        stand.tick()
        sent[stand.sequence] = tick
    stand.run(int(limits["lag_ticks"]) + 2)
    lags: dict[int, int] = {}
    for one in stand.sets[mark:]:
        sequence = one.status.last_sequence
        if sequence in sent:
            lags.setdefault(sequence, one.sent - sent[sequence])
    good = sum(0 <= lag <= limits["lag_ticks"] for lag in lags.values())
    # on a link that brings two at once the older one is not echoed
    if len(lags) < limits["echoed_share"] * len(sent) or good < limits["share"] * len(lags):
        raise UnmetError(
            f"{len(lags)} of {len(sent)} sequences were echoed, {good} of them within {limits['lag_ticks']:g} ticks"
        )
    return f"{len(lags)} of {len(sent)} sequences echoed, {good} of them within {limits['lag_ticks']:g} ticks"


def feedback_without_a_host(stand: Stand, limits: Limits) -> str:
    """Sets that come in silence; over a link against the wall clock."""
    stand.run(3)
    mark, began = stand.latest.tick, time.monotonic()
    sets = stand.run(int(limits["ticks"]), silent=True)
    if not sets:
        raise UnmetError(f"no feedback in {limits['ticks']:g} ticks without a host")
    passed = stand.latest.tick - mark
    expected = limits["ticks"] if stand.carrier.in_step else (time.monotonic() - began) * stand.rate_hz
    if abs(passed / expected - 1.0) > limits["rate_share"]:
        raise UnmetError(f"{passed} ticks of feedback in {expected:.0f} periods without a host")
    return f"{passed} ticks in {expected:.0f} periods"


def a_still_joint_reads_still(stand: Stand, limits: Limits) -> str:
    """Spread of position and rate, torque off."""
    sets = stand.run(int(limits["ticks"]))
    told = []
    for axis, name in enumerate(stand.axes):
        motion = [m for one in sets if (m := one.motion(axis)) is not None]
        spread = max(m.position_rad for m in motion) - min(m.position_rad for m in motion)
        rate = max(abs(m.rate_rad_s) for m in motion)
        if spread > limits["position_rad"] or rate > limits["rate_rad_s"]:
            raise UnmetError(
                f"{name}: position spreads {spread:.2g} rad and the rate reads up to {rate:.2g} rad/s, torque off"
            )
        told.append(f"{name} {spread:.2g} rad, {rate:.2g} rad/s")
    return "; ".join(told)


def slow_messages_keep_their_periods(stand: Stand, limits: Limits) -> str:
    """The antenna's tick between two of a kind."""
    mark = len(stand.sets)
    stand.run(int(limits["periods"]) * max(m.period_ticks for m in _SLOW))
    seen: dict[str, list[int]] = {}
    for one in stand.sets[mark:]:
        for message in one.messages:
            seen.setdefault(type(message).__name__, []).append(one.tick)
    found = {m.name: (m.period_ticks, seen[m.class_name]) for m in _SLOW if m.class_name in seen}
    if not found:
        raise NotShownError("it sends none of " + ", ".join(m.name for m in _SLOW))
    for name, (period, ticks) in found.items():
        gaps = [after - before for before, after in itertools.pairwise(ticks)]
        odd = [gap for gap in gaps if abs(gap - period) > limits["jitter_ticks"]]
        if odd or not gaps:
            raise UnmetError(f"{name}: {odd[0] if odd else 'no second one'} ticks after the one before, not {period}")
    left_out = [m.name for m in _SLOW if m.name not in found]
    return f"{', '.join(found)} in their periods" + (f"; left out: {', '.join(left_out)}" if left_out else "")


def identity_comes_by_itself(stand: Stand, limits: Limits) -> str:
    """Ticks until both have come, unasked."""
    first = stand.latest.tick
    most = int(limits["most_ticks"])
    for kind in (Identity, IdentityUnit):
        found = stand.until(lambda one, kind=kind: any(isinstance(m, kind) for m in one.messages), most)  # type: ignore[misc]
        if found is None:
            raise UnmetError(f"no {kind.__name__} within {most} ticks")
    return f"both within {stand.latest.tick - first} ticks"


def identity_comes_when_asked(stand: Stand, limits: Limits) -> str:
    """Asked right after both have come by themselves, so that none is due."""
    identity_comes_by_itself(stand, {"most_ticks": 1100})
    stand.run(20)
    mark = len(stand.sets)
    stand.exchange(control(identify=True), stand.set_point())
    stand.run(int(limits["most_ticks"]))
    for kind in (Identity, IdentityUnit):
        if not stand.said(kind, mark):
            raise UnmetError(f"no {kind.__name__} within {limits['most_ticks']:g} ticks after drive_control.identify")
    return "both in the set of the request or the next ones"


def identity_stays_the_same(stand: Stand, limits: Limits) -> str:
    """Asked several times."""
    mark = len(stand.sets)
    for _ in range(int(limits["times"])):
        stand.exchange(control(identify=True), stand.set_point())
        stand.run(5)
    heard: dict[type, set[AnyMessage]] = {
        kind: {m for _, m in stand.said(kind, mark)} for kind in (Identity, IdentityUnit)
    }
    for kind, different in heard.items():
        if len(different) != 1:
            raise UnmetError(f"{len(different)} different {kind.__name__} within {limits['times']:g} answers")
    (who,), (unit,) = heard[Identity], heard[IdentityUnit]
    assert isinstance(who, Identity) and isinstance(unit, IdentityUnit)
    if who.protocol_version != limits["protocol_version"]:
        raise UnmetError(f"protocol version {who.protocol_version}, not {limits['protocol_version']:g}")
    return (
        f"version {who.protocol_version}, name 0x{who.name:08X}, serial number {unit.serial_number}, torque exponents "
        f"{unit.torque_exponent_outer} and {unit.torque_exponent_inner}"
    )
