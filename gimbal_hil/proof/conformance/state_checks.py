"""Checks of the drive's states. Each takes the antenna in SWITCH_ON_DISABLED and answers its evidence."""

from __future__ import annotations

import itertools
from collections.abc import Mapping

from firmware_protocol.enumerations import DriveRequest, DriveState, FaultCode
from gimbal_hil.proof.conformance.requirements import Requirement
from gimbal_hil.proof.conformance.stand import REACTIONS, NotShownError, Stand, UnmetError, control, events_in

Limits = Mapping[str, float]
#: states that requests leave
LADDER = (
    DriveState.SWITCH_ON_DISABLED,
    DriveState.READY_TO_SWITCH_ON,
    DriveState.SWITCHED_ON,
    DriveState.OPERATION_ENABLED,
    DriveState.QUICK_STOP_ACTIVE,
)


def it_starts_switched_off(stand: Stand, limits: Limits) -> str:
    """Nothing is asked; the antenna may have been on for long."""
    found = stand.until(lambda one: one.status.state is DriveState.SWITCH_ON_DISABLED, int(limits["most_ticks"]))
    if found is None:
        raise UnmetError(f"it is {stand.state.name} after {limits['most_ticks']:g} ticks in which nothing was asked")
    return f"SWITCH_ON_DISABLED at its tick {found.status.tick}"


def every_request_leads_where_the_table_says(stand: Stand, requirement: Requirement) -> str:
    """Every request in every state, one after the other."""
    settle = int(requirement.limits["settle_ticks"])
    tried = 0
    for state in LADDER:
        for request in DriveRequest:
            stand.settle()
            stand.to_state(state)
            wanted = requirement.destination(state, request)
            stand.step(f"{request.name} in {state.name}")
            mark = len(stand.sets)
            stand.ask(request, settle)
            passed = {one.status.state for one in stand.sets[mark:]} - {state, wanted}
            if stand.state is not wanted or passed:
                through = f" through {', '.join(one.name for one in passed)}" if passed else ""
                raise UnmetError(
                    f"{request.name} in {state.name} led to {stand.state.name}{through}, not to {wanted.name}"
                )
            tried += 1
    return f"{tried} pairs of state and request"


def each_transition_is_told(stand: Stand, limits: Limits) -> str:
    """Up to OPERATION_ENABLED and down again."""
    mark = len(stand.sets)
    stand.to_state(DriveState.OPERATION_ENABLED)
    stand.ask(DriveRequest.DISABLE_VOLTAGE, int(limits["settle_ticks"]))
    events = events_in(stand.sets[mark:])
    states = [stand.sets[mark - 1].status.state, *(one.status.state for one in stand.sets[mark:])]
    seen = [(before, after) for before, after in itertools.pairwise(states) if after is not before]
    if not events:
        raise NotShownError("it sends no drive_event")
    told = [(event.from_state, event.to_state) for event in events]
    if told != seen:
        raise UnmetError(
            f"{len(seen)} changes of state, {len(told)} events: "
            + ", ".join(f"{before.name} to {after.name}" for before, after in told)
        )
    return f"{len(told)} changes, each with its event"


def no_torque_before_set_points(stand: Stand, limits: Limits) -> str:
    """Requests alone, while no set-point comes."""
    stand.settle(int(limits["window_ticks"]))
    stand.to_state(DriveState.SWITCHED_ON)
    stand.run(int(limits["window_ticks"]) + int(limits["settle_ticks"]), silent=True)
    for _ in range(int(limits["settle_ticks"])):
        for one in stand.exchange(control(DriveRequest.ENABLE_OPERATION)):
            if one.status.state is DriveState.OPERATION_ENABLED:
                raise UnmetError(
                    f"OPERATION_ENABLED without set-points, {one.status.deadman_margin_ticks} ticks of the window left"
                )
    return f"ENABLE_OPERATION refused {limits['settle_ticks']:g} times"


def the_flag_quick_stop_outranks_the_request(stand: Stand, limits: Limits) -> str:
    """The flag beside DISABLE_VOLTAGE, which would switch off without a stop."""
    stand.to_state(DriveState.OPERATION_ENABLED)
    # once: said again in QUICK_STOP_ACTIVE the request is granted
    stand.tick((0.0, 0.0), (False, False), control(DriveRequest.DISABLE_VOLTAGE, quick_stop=True))
    stand.run(int(limits["settle_ticks"]))
    if stand.state is not DriveState.QUICK_STOP_ACTIVE:
        raise UnmetError(f"quick_stop beside DISABLE_VOLTAGE led to {stand.state.name}")
    return "QUICK_STOP_ACTIVE"


def a_fault_latches(stand: Stand, limits: Limits) -> str:
    """A deadman fault, then set-points again and every request."""
    into_fault(stand)
    for request in DriveRequest:
        stand.ask(request, int(limits["settle_ticks"]))
        status = stand.latest.status
        if status.state is not DriveState.FAULT or status.fault is not FaultCode.DEADMAN:
            raise UnmetError(f"{request.name} in FAULT led to {status.state.name}, fault {status.fault.name}")
    return f"{len(DriveRequest)} requests left it in FAULT, DEADMAN"


def a_fault_is_reset_by_an_edge(stand: Stand, limits: Limits) -> str:
    """A level that was high before the fault, then low, then high."""
    settle = int(limits["settle_ticks"])
    stand.settle(60)
    stand.to_state(DriveState.OPERATION_ENABLED)
    stand.ask(fault_reset=True)
    stand.until(lambda one: one.status.state is DriveState.FAULT, 9000, silent=True)
    for level, stays in ((True, True), (True, True), (False, True), (True, False)):
        stand.ask(ticks=settle, fault_reset=level)
        if (stand.state is DriveState.FAULT) is not stays:
            raise UnmetError(f"fault_reset {'high' if level else 'low'} led to {stand.state.name}")
    status = stand.latest.status
    if status.state is not DriveState.SWITCH_ON_DISABLED or status.fault is not FaultCode.NONE:
        raise UnmetError(f"the edge led to {status.state.name}, fault {status.fault.name}")
    return "a level that stood stayed without effect, the edge led to SWITCH_ON_DISABLED"


def into_fault(stand: Stand, window: int = 60) -> None:
    """Silence until the deadman has brought the antenna to FAULT; UnmetError where it does not go there."""
    stand.settle(window)
    stand.to_state(DriveState.OPERATION_ENABLED)
    if stand.until(lambda one: one.status.state in REACTIONS, 2 * window, silent=True) is None:
        raise UnmetError(f"the deadman did not trip within {2 * window} ticks of silence")
    if stand.until(lambda one: one.status.state is DriveState.FAULT, 9000) is None:
        raise UnmetError("FAULT is not reached within 9000 ticks after the deadman tripped")
