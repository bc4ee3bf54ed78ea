"""What whoever is refused a motion is told, and can do about it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.compiling import interpreted
from gimbal_hil.loop.host import Host, HostState, braking, layout, limit_ahead, word_of

# for a call now and then, within the ticks: compiling them would outlast many
_limit_ahead, _braking = interpreted(limit_ahead), interpreted(braking)

_HINTS = {
    HostState.WAITING: ", which passes once the antenna answers",
    HostState.SYNCHRONISING: ", which passes once the antenna answers",
    HostState.STOPPING: ", which passes once the axes rest",
    HostState.FAULT: ", which `gimbal-hil reset` leaves (fault_reset)",
}
#: states in which torque is on
_MOVING = (HostState.ACTIVE, HostState.STOPPING)


def why_not_now(host: Host) -> str:
    """Why the host takes no motion in its state, and what ends that."""
    hint = _HINTS.get(host.state, "")
    return f"the host is in state {word_of(host.state)}{hint} (last cause: {word_of(host.cause)})"


def why_not_adjusted(host: Host, numbers: NDArray[np.float64]) -> str:
    """Why an axis may not have other numbers (an array `C`) as it moves now: with them it could no more be braked
    before a limit, and before, it could; or it would be too fast at once. Nothing for what may be.
    """
    H, G, C = host.memory.H, host.memory.G, host.memory.C
    for axis, name in enumerate(host.axes):
        h, c = layout.axis_h(axis), layout.axis_c(axis)
        rate, most = H[h + layout.MEASURED_RATE] - H[h + layout.BASE_RATE], numbers[c + layout.MAX_RATE]
        if host.state in _MOVING and most < abs(rate) <= C[c + layout.MAX_RATE]:
            return (
                f"{name} moves at {rate:.3g} rad/s, which limits.rate_rad_s = {most:.3g} would end as too fast: "
                "change it once it rests (`gimbal-hil stop`)"
            )
        if not _limit_ahead(H, G, numbers, axis):
            continue
        if not _limit_ahead(H, G, C, axis) or _braking(H, numbers, h, c) < _braking(H, C, h, c):
            return (
                f"{name} moves at {H[h + layout.MEASURED_RATE]:.3g} rad/s and could not be braked before its limit "
                "with these numbers: change them once it rests (`gimbal-hil stop`), or is further away"
            )
    return ""
