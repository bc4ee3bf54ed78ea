"""Checks that apply torque. Each takes the antenna in SWITCH_ON_DISABLED and answers its evidence.

Torque is a share of what the wire carries (with the antenna's exponents: of what its axis carries), for some ticks, one
axis at a time; the pulse is taken back by one the other way.
"""

from __future__ import annotations

from collections.abc import Mapping

from firmware_protocol.enumerations import DriveRequest, DriveState, LimitFlags, StopReaction
from gimbal_hil.proof.conformance.stand import FeedbackSet, NotShownError, Stand, UnmetError

Limits = Mapping[str, float]
_LIMITED = (LimitFlags.OUTER_TORQUE, LimitFlags.INNER_TORQUE)


def torque_turns_the_way_of_its_sign(stand: Stand, limits: Limits) -> str:
    """A pulse each way on each axis: change of rate by gyro, and by encoder."""
    told = []
    for axis, name in enumerate(stand.axes):
        for sign in (1.0, -1.0):
            stand.settle()
            stand.to_state(DriveState.OPERATION_ENABLED)
            gyro, encoder = _pulse(stand, limits, axis, sign, enabled=True)
            if gyro * sign < limits["least_rate_rad_s"]:
                raise UnmetError(f"{name}: torque of sign {sign:+g} changed the gyro's rate by {gyro:+.3g} rad/s")
            if encoder * sign < limits["agree_share"] * abs(gyro):
                raise UnmetError(f"{name}: the gyro changed by {gyro:+.3g} rad/s, the encoder's rate by {encoder:+.3g}")
            told.append(f"{name} {gyro:+.3g} and {encoder:+.3g}")
    return "rad/s by gyro and encoder: " + ", ".join(told)


def an_axis_that_is_not_enabled_gets_none(stand: Stand, limits: Limits) -> str:
    """The same pulse without the axis' enable flag."""
    stand.to_state(DriveState.OPERATION_ENABLED)
    return _stays_still(stand, limits)


def torque_is_off_below_operation_enabled(stand: Stand, limits: Limits) -> str:
    """The same pulse, enabled, in SWITCHED_ON and the states below it."""
    told = []
    for state in (DriveState.SWITCH_ON_DISABLED, DriveState.READY_TO_SWITCH_ON, DriveState.SWITCHED_ON):
        stand.settle()
        stand.to_state(state)
        told.append(f"{state.name}: {_stays_still(stand, limits, enabled=True)}")
    return "; ".join(told)


def torque_beyond_the_limit_is_held(stand: Stand, limits: Limits) -> str:
    """The most that the wire carries, on one axis after the other."""
    told = []
    for axis, name in enumerate(stand.axes):
        stand.settle()
        stand.to_state(DriveState.OPERATION_ENABLED)
        mark = len(stand.sets)
        enable = (axis == 0, axis == 1)
        for sign in (1.0, -1.0):
            for _ in range(int(limits["ticks"])):
                stand.tick(_on(axis, sign), enable)
        stand.ask(DriveRequest.DISABLE_VOLTAGE)
        flagged = [one for one in stand.sets[mark:] if one.status.limits & _LIMITED[axis]]
        if not flagged:
            raise NotShownError(f"{name} takes all torque that the wire carries, or does not tell its limit")
        told.append(f"{name} in {len(flagged)} sets")
    return "flagged: " + ", ".join(told)


def a_quick_stop_comes_to_rest(stand: Stand, limits: Limits) -> str:
    """A pulse, then each stop; how far the encoder still moves after a while."""
    told = []
    rest_rad = {
        StopReaction.BRAKE: limits["creep_rad_s"] * limits["over_ticks"] / stand.rate_hz,
        StopReaction.DECELERATE_AND_HOLD: limits["rest_rad"],
        StopReaction.GYRO_STOP: limits["creep_rad_s"] * limits["over_ticks"] / stand.rate_hz,
    }
    for axis, name in enumerate(stand.axes):
        for stop, most_rad in rest_rad.items():
            stand.settle()
            stand.to_state(DriveState.OPERATION_ENABLED)
            for _ in range(int(limits["ticks"])):
                stand.tick(_on(axis, limits["torque_share"]), (axis == 0, axis == 1))
            stand.step(f"quick stop, {stop.name}, {name}")
            stand.ask(DriveRequest.QUICK_STOP, quick_stop=True, stop=stop)
            stand.run(int(limits["most_ticks"]))
            spread = _spread(stand.sets[-int(limits["over_ticks"]) :], axis)
            if stand.state is not DriveState.QUICK_STOP_ACTIVE or spread > most_rad:
                raise UnmetError(
                    f"{stop.name}, {name}: {stand.state.name}, and the position moves by {spread:.3g} rad in "
                    f"{limits['over_ticks']:g} ticks, {limits['most_ticks']:g} ticks after the quick stop"
                )
            told.append(f"{stop.name} {name} {spread:.2g}")
    return f"rad in {limits['over_ticks']:g} ticks: " + ", ".join(told)


def _stays_still(stand: Stand, limits: Limits, enabled: bool = False) -> str:
    changes = []
    for axis, name in enumerate(stand.axes):
        gyro, _ = _pulse(stand, limits, axis, 1.0, enabled)
        if abs(gyro) > limits["most_rate_rad_s"]:
            raise UnmetError(f"{name} in {stand.state.name}: its rate changed by {gyro:+.3g} rad/s")
        changes.append(f"{gyro:+.2g}")
    return f"rate changed by {' and '.join(changes)} rad/s"


def _pulse(stand: Stand, limits: Limits, axis: int, sign: float, enabled: bool) -> tuple[float, float]:
    """Change of the rate by gyro and by encoder at the end of a pulse, rad/s; then as long the other way."""
    ticks, share = int(limits["ticks"]), limits["torque_share"]
    enable = (enabled and axis == 0, enabled and axis == 1)
    stand.run(10)
    before = stand.latest
    mark = len(stand.sets)
    for _ in range(ticks):
        stand.tick(_on(axis, sign * share), enable)
    sets = stand.sets[mark:]
    for _ in range(ticks):
        stand.tick(_on(axis, -sign * share), enable)
    stand.run(10)
    half = sets[len(sets) // 2 :]
    first, last, still = half[0].motion(axis), half[-1].motion(axis), before.motion(axis)
    if first is None or last is None or still is None:
        raise UnmetError(f"{stand.axes[axis]}: feedback is missing during the pulse")
    seconds = (half[-1].tick - half[0].tick) / stand.rate_hz
    rates = [m.rate_rad_s for one in half if (m := one.motion(axis)) is not None]
    return sum(rates) / len(rates) - still.rate_rad_s, (last.position_rad - first.position_rad) / seconds


def _on(axis: int, share: float) -> tuple[float, float]:
    return (share, 0.0) if axis == 0 else (0.0, share)


def _spread(sets: list[FeedbackSet], axis: int) -> float:
    positions = [m.position_rad for one in sets if (m := one.motion(axis)) is not None]
    return max(positions) - min(positions)
