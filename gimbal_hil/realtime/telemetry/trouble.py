"""Why the antenna stands, in the words of the table of guards: what it is, since when, what happens, what to do."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from gimbal_hil.loop.host import DRIVE_GUARDS, HOST_GUARDS, HostCause, HostState, word_of

_GUARDS = {word_of(guard.cause): guard for guard in HOST_GUARDS}
_FAULTS = {word_of(guard.fault): guard for guard in DRIVE_GUARDS}
_STOPS = (word_of(HostState.FAULT), word_of(HostState.STOPPING))
_DRIVE_FAULT = word_of(HostCause.DRIVE_FAULT)


@dataclass(frozen=True, slots=True)
class StopTold:
    """One stop. `since_s` on the run's clock; the rest are words for people."""

    what: str
    since_s: float
    happens: str
    look_at: str
    left_by: str

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return asdict(self)


def trouble_of(state: str, cause: str, drive_fault: str | None, complaint: str, since_s: float) -> StopTold | None:
    """The stop that the host is in, by its state and why it last changed that (`word_of`); None where it is in none.

    An operator's own stop is one only where it is left by a reset.
    """
    guard = _GUARDS.get(cause) if state in _STOPS else None
    if guard is None:
        if state != _STOPS[0]:
            return None
        return StopTold("quick stop by an operator", since_s, "braked by the drive, and held", "", "operator's reset")
    what = f"{cause.replace('_', ' ')}: {guard.trigger}"
    fault = _FAULTS.get(drive_fault or "") if cause == _DRIVE_FAULT else None
    if cause == _DRIVE_FAULT and drive_fault not in (None, "none"):
        what = f"drive fault {str(drive_fault).replace('_', ' ')}" + (f": {fault.trigger}" if fault else "")
    if complaint:
        what += f" ({complaint})"
    return StopTold(what, since_s, fault.reaction if fault else guard.reaction, guard.look_at, guard.reset)
