"""What whoever is refused a motion is told, and can do about it."""

from __future__ import annotations

from gimbal_hil.loop.host import Host, HostState, word_of

_HINTS = {
    HostState.WAITING: ", which passes once the antenna answers",
    HostState.SYNCHRONISING: ", which passes once the antenna answers",
    HostState.STOPPING: ", which passes once the axes rest",
    HostState.FAULT: ", which `gimbal-hil reset` leaves (fault_reset)",
}


def why_not_now(host: Host) -> str:
    """Why the host takes no motion in its state, and what ends that."""
    hint = _HINTS.get(host.state, "")
    return f"the host is in state {word_of(host.state)}{hint} (last cause: {word_of(host.cause)})"
