"""Why the antenna stands, in the words of the table of guards: what it is, since when, what happens, what to do."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass

from firmware_protocol.enumerations import DriveState
from gimbal_hil.loop.host import DRIVE_GUARDS, HOST_GUARDS, HostCause, HostState, word_of

#: states of a drive (CiA 402), for people
DRIVE_TOLD = {
    DriveState.NOT_READY: "not ready",
    DriveState.SWITCH_ON_DISABLED: "off",
    DriveState.READY_TO_SWITCH_ON: "off, ready",
    DriveState.SWITCHED_ON: "on, without torque",
    DriveState.OPERATION_ENABLED: "on",
    DriveState.QUICK_STOP_ACTIVE: "quick stop",
    DriveState.FAULT_REACTION_ACTIVE: "stopping by a fault",
    DriveState.FAULT: "fault",
}
_GUARDS = {word_of(guard.cause): guard for guard in HOST_GUARDS}
_FAULTS = {word_of(guard.fault): guard for guard in DRIVE_GUARDS}
_STOPS = (word_of(HostState.FAULT), word_of(HostState.STOPPING))
_DRIVE_FAULT = word_of(HostCause.DRIVE_FAULT)
_OPERATOR = word_of(HostCause.OPERATOR)
_QUICK_STOP = "quick stop by an operator"
#: why the host last changed its state where no guard did, for people
_OTHERWISE = {
    "operator": "an operator's command",
    "duration": "the end of a program",
    "end_condition": "the end of a program",
    "replaced": "another command",
}


@dataclass(frozen=True, slots=True)
class StopTold:
    """One stop. `since_s` on the run's clock; the rest are words for people: its name, what tripped it, what the
    antenna does, what to look at first, how it is left. All but name, `happens` and `left_by` may be empty.
    """

    what: str
    why: str
    since_s: float
    happens: str
    look_at: str
    left_by: str

    def as_dict(self) -> dict[str, object]:
        """For JSON."""
        return asdict(self)


def trouble_of(
    state: str,
    cause: str,
    drive_fault: str | None,
    complaint: str,
    since_s: float,
    axes: Sequence[str] = (),
    drive: DriveState | None = None,
) -> StopTold | None:
    """The stop that the host is in, by its state and why it last changed that (`word_of`), on these axes where they are
    known, and the state of the drive while it is heard; None where it is in none.

    An operator's own stop is one only where it is left by a reset.
    """
    guard = _GUARDS.get(cause) if state in _STOPS else None
    if guard is None:
        if state != _STOPS[0]:
            return None
        brakes = _now("the drive brakes, holds, then switches off", drive)
        return StopTold(_QUICK_STOP, "", since_s, brakes, "", "operator's reset")
    fault = _FAULTS.get(drive_fault or "") if cause == _DRIVE_FAULT else None
    what, why = cause, guard.trigger
    if cause == _DRIVE_FAULT and drive_fault not in (None, "none"):
        what, why = f"drive fault {drive_fault}", fault.trigger if fault else ""
    why = " ".join(part for part in (why, f"({complaint})" if complaint else "") if part)
    happens = fault.reaction if fault else guard.reaction
    where = f" on {' and '.join(axes)}" if axes else ""
    told = (
        f"{what.replace('_', ' ')}{where}",
        _plain(why),
        since_s,
        _now(_plain(happens), drive),
        _plain(guard.look_at),
        _plain(guard.reset),
    )
    return StopTold(*told)


def told_state(state: str, cause: str) -> str:
    """What the host does, for people, with what last made it do so (`word_of`). The state in which a drive stops by
    itself is `fault` for a guard and for an operator, of whom no fault is told.
    """
    if (state, cause) == (_STOPS[0], _OPERATOR):
        return _QUICK_STOP
    if cause == word_of(HostCause.NONE):
        return state
    return f"{state}, by {_OTHERWISE.get(cause, cause.replace('_', ' '))}"


def _now(happens: str, drive: DriveState | None) -> str:
    """What the antenna does, by what a stop makes of it; that is over where a drive that is heard gives no torque."""
    return happens if drive is None or drive.gives_torque else f"the drive gives no torque (the stop was: {happens})"


def _plain(text: str) -> str:
    """Marks of a page say nothing in a terminal."""
    return text.replace("`", "")
