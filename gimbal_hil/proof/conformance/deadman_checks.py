"""Checks of the deadman. Each takes the antenna in SWITCH_ON_DISABLED and answers its evidence.

What they judge is in the antenna's own ticks, so that a tester that was late spoils nothing but his own silence.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from firmware_protocol.enumerations import DriveRequest, DriveState, FaultCode, StopReaction
from firmware_protocol.messages import DeadmanConfig
from gimbal_hil.proof.conformance.stand import REACTIONS, FeedbackSet, Stand, UnmetError

Limits = Mapping[str, float]


def silence_trips_the_deadman(stand: Stand, limits: Limits) -> str:
    """The margin of every set after the last set-point."""
    window = _armed(stand, limits)
    stand.tick()
    mark = len(stand.sets)
    stand.until(_tripped, 3 * window, silent=True)
    full = [k for k, one in enumerate(stand.sets) if k >= mark - 1 and one.status.deadman_margin_ticks == window]
    if not full:
        raise UnmetError(
            f"the margin after a fresh set-point is {stand.sets[mark - 1].status.deadman_margin_ticks}, not {window}"
        )
    last = stand.sets[full[-1]]
    for one in stand.sets[full[-1] + 1 :]:
        passed, status = one.tick - last.tick, one.status
        if status.deadman_margin_ticks != max(0, window - passed):
            raise UnmetError(
                f"{passed} ticks after the last set-point the margin is {status.deadman_margin_ticks} of {window}"
            )
        if status.state in REACTIONS:
            if status.fault is not FaultCode.DEADMAN:
                raise UnmetError(f"silence led to fault {status.fault.name}")
            if not window <= passed <= window + limits["late_ticks"]:
                raise UnmetError(f"it tripped {passed} ticks after the last set-point, its window is {window}")
            return f"tripped {passed} ticks after the last set-point, window {window}"
    raise UnmetError(f"it is {stand.state.name} after {3 * window} ticks of silence")


def a_repeated_sequence_does_not_feed(stand: Stand, limits: Limits) -> str:
    """The same sequence again and again, each under a fresh alive counter."""
    return _trips_while(stand, limits, lambda: stand.tick_repeated(0))


def an_older_sequence_does_not_feed(stand: Stand, limits: Limits) -> str:
    """Sequences that go back by one each."""
    return _trips_while(stand, limits, lambda: stand.tick_repeated(-1))


def damaged_set_points_do_not_feed(stand: Stand, limits: Limits) -> str:
    """Fresh sequences, each with one bit of its torque wrong."""

    def damaged() -> list[FeedbackSet]:
        frame = bytearray(stand.frame(stand.set_point()))
        frame[2 + stand.ticks % 4] ^= 1 << (stand.ticks % 8)
        return stand.exchange(raw=bytes(frame))

    return _trips_while(stand, limits, damaged)


def a_new_host_feeds_an_expired_deadman(stand: Stand, limits: Limits) -> str:
    """Silence beyond the window with torque off, then a sequence from behind."""
    window = int(limits["window_ticks"])
    stand.settle(window)
    stand.run(2 * window, silent=True)
    if stand.latest.status.deadman_margin_ticks:
        raise UnmetError(
            f"the margin is {stand.latest.status.deadman_margin_ticks} after {2 * window} ticks of silence"
        )
    mark = len(stand.sets)
    stand.exchange(stand.set_point(ahead=-300))
    stand.run(int(limits["heard_ticks"]), silent=True)
    if max(one.status.deadman_margin_ticks for one in stand.sets[mark:]) != window:
        raise UnmetError("a set-point with an older sequence was not taken although the deadman had expired")
    return "taken with its first set-point"


def the_deadman_stays_while_torque_is_on(stand: Stand, limits: Limits) -> str:
    """Another window in OPERATION_ENABLED, and again with torque off."""
    window, other = _armed(stand, limits), int(limits["other_ticks"])
    config = DeadmanConfig(other, StopReaction.COAST)
    for state, expected in ((DriveState.OPERATION_ENABLED, window), (DriveState.SWITCH_ON_DISABLED, other)):
        if state is DriveState.SWITCH_ON_DISABLED:
            stand.ask(DriveRequest.DISABLE_VOLTAGE, int(limits["settle_ticks"]))
        stand.tick((0.0, 0.0), (False, False), config)
        shown = max(one.status.deadman_margin_ticks for one in stand.run(int(limits["settle_ticks"]))[3:])
        if shown != expected:
            raise UnmetError(f"deadman_config of {other} ticks in {state.name}: the window is {shown}, not {expected}")
    return f"{window} ticks with torque on, {other} with torque off"


def each_reaction_ends_in_fault(stand: Stand, limits: Limits) -> str:
    """The four reactions one after the other, from rest."""
    told = []
    for reaction in StopReaction:
        _armed(stand, limits, reaction)
        stand.step(f"silence, reaction {reaction.name}")
        stand.until(_tripped, 3 * int(limits["window_ticks"]), silent=True)
        first = stand.latest
        ended = stand.until(lambda one: one.status.state is DriveState.FAULT, int(limits["most_ticks"]))
        if first.status.fault is not FaultCode.DEADMAN or ended is None:
            raise UnmetError(
                f"{reaction.name}: {stand.state.name}, fault {stand.latest.status.fault.name}, "
                f"{limits['most_ticks']:g} ticks after silence"
            )
        told.append(f"{reaction.name} {ended.tick - first.tick}")
    return "ticks from trip to FAULT: " + ", ".join(told)


def silence_of_drive_control_is_a_fault(stand: Stand, limits: Limits) -> str:
    """Set-points alone, in OPERATION_ENABLED."""
    stand.to_state(DriveState.OPERATION_ENABLED)
    stand.ask(ticks=5)
    began = stand.latest.tick
    silence = int(limits["silence_ticks"])
    for _ in range(silence + 5 * int(limits["late_ticks"])):
        for one in stand.tick():
            if one.status.state in REACTIONS:
                passed = one.tick - began
                if one.status.fault is not FaultCode.COMMUNICATION:
                    raise UnmetError(f"fault {one.status.fault.name} after {passed} ticks")
                if abs(passed - silence) > limits["late_ticks"]:
                    raise UnmetError(f"fault COMMUNICATION {passed} ticks after the last drive_control, not {silence}")
                return f"{passed} ticks after the last drive_control"
    raise UnmetError(f"it is {stand.state.name} after {stand.latest.tick - began} ticks without drive_control")


def a_stop_without_sensors_stays_one(stand: Stand, limits: Limits) -> str:
    """A quick stop that brakes, then silence with DECELERATE_AND_HOLD as the deadman's reaction: FAULT comes without
    the time for which that one holds.
    """
    told = []
    for stop in (StopReaction.COAST, StopReaction.BRAKE):
        _armed(stand, limits, StopReaction.DECELERATE_AND_HOLD)
        stand.ask(DriveRequest.QUICK_STOP, stop=stop)
        stand.until(_tripped, 3 * int(limits["window_ticks"]), silent=True)
        tripped = stand.latest
        without = stand.until(lambda one: one.status.state is DriveState.FAULT, int(limits["most_ticks"]))
        _armed(stand, limits, StopReaction.DECELERATE_AND_HOLD)
        stand.until(_tripped, 3 * int(limits["window_ticks"]), silent=True)
        held = stand.latest
        by_torque = stand.until(lambda one: one.status.state is DriveState.FAULT, int(limits["most_ticks"]))
        if tripped.status.state not in REACTIONS or without is None or by_torque is None:
            raise UnmetError(f"{stop.name}: FAULT is not reached within {limits['most_ticks']:g} ticks")
        short, long = without.tick - tripped.tick, by_torque.tick - held.tick
        if long > 200 and short > 0.75 * long:
            raise UnmetError(
                f"after a quick stop by {stop.name} it took {short} ticks to FAULT, as long as one that holds ({long})"
            )
        told.append(f"{stop.name} {short} ticks to FAULT, DECELERATE_AND_HOLD {long}")
    return "; ".join(told)


def _armed(stand: Stand, limits: Limits, reaction: StopReaction = StopReaction.BRAKE) -> int:
    """OPERATION_ENABLED with the window of the requirement, which is answered."""
    window = int(limits["window_ticks"])
    stand.settle(window, reaction)
    stand.to_state(DriveState.OPERATION_ENABLED)
    stand.run(5)
    return window


def _tripped(one: FeedbackSet) -> bool:
    return one.status.state in REACTIONS


def _trips_while(stand: Stand, limits: Limits, send: Callable[[], list[FeedbackSet]]) -> str:
    """Something that must not feed the deadman, sent until it trips."""
    window = _armed(stand, limits)
    stand.tick()
    began = stand.latest.tick
    for _ in range(3 * window):
        for one in send():
            passed = one.tick - began
            if one.status.state in REACTIONS:
                if one.status.fault is not FaultCode.DEADMAN or abs(passed - window) > limits["late_ticks"]:
                    raise UnmetError(f"fault {one.status.fault.name} after {passed} ticks, window {window}")
                return f"tripped after {passed} ticks, window {window}"
    raise UnmetError(
        f"it is {stand.state.name} after {3 * window} ticks; the margin is {stand.latest.status.deadman_margin_ticks}"
    )
