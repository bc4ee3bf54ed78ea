"""The rows of the fault matrix: what goes wrong, in which motion, and within which bounds the antenna must then be
safe.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from firmware_protocol.schema import POSITION_STEP_RAD, RATE_STEP_RAD_S, TORQUE_STEP_NM
from sim_backend.device import Spoilt


class Motion(StrEnum):
    """What the faulty axis does when the fault comes; the other one holds its position."""

    REST = "at rest"
    SLOW = "slow"
    FAST = "fast"


#: joint rate of each motion, rad/s
SPEED_RAD_S = {Motion.REST: 0.0, Motion.SLOW: 0.1, Motion.FAST: 3.0}


class Trouble(StrEnum):
    """What goes wrong outside the axes' own sensors and motors."""

    FEEDBACK_CUT = "feedback cut"
    LINE_CUT = "line cut both ways"
    SET_POINTS_LOST = "set-points lost"
    HOST_SILENT = "host silent"
    FEEDBACK_FROZEN = "feedback frozen behind live counters"
    STATUS_FROZEN = "whole answer frozen behind live counters"
    ANTENNA_RESTARTED = "antenna restarted"
    STRANGER = "another antenna answers"
    UNDERVOLTAGE = "supply fails"
    HOT_WINDING = "winding too hot"
    NOISY_LINE = "one frame in fifty damaged"
    QUICK_STOP = "operator's quick stop"


@dataclass(frozen=True)
class FaultRow:
    """One row: a part of an axis spoilt, or trouble elsewhere.

    Bounds: safe within `safe_s`, peak rate at most `excess_rad_s` above the one before, travel at most `travel_rad`
    from where the fault came. `may_pass`: nothing need happen as long as the axis moves as it was asked to.
    """

    axis: int
    motion: Motion
    safe_s: float
    excess_rad_s: float
    travel_rad: float
    part: str = ""
    kind: Spoilt = Spoilt.NOTHING
    amount: int = 0
    trouble: Trouble | None = None
    may_pass: bool = False

    @property
    def rest_rad_s(self) -> float:
        """Below this an axis is at rest; a power stage that keeps its torque whatever it is told drags a shorted motor
        along.
        """
        return 0.1 if (self.part, self.kind) == ("motor", Spoilt.FROZEN) else 0.02

    @property
    def name(self) -> str:
        """In words."""
        what = f"{self.part} {self.kind.name.lower()}" if self.trouble is None else str(self.trouble)
        return f"{('outer', 'inner')[self.axis]} {self.motion}: {what}"


#: sensors and motors: kind, raw amount, by motion how long until safe (s), None where nothing need happen
_SENSOR_DRIFT = {Motion.REST: 0.4, Motion.SLOW: 0.4, Motion.FAST: 2.5}
_ENCODER = (
    (Spoilt.FROZEN, 0, {Motion.REST: None, Motion.SLOW: 0.45, Motion.FAST: 0.05}),
    (Spoilt.REVERSED, 0, {Motion.REST: None, Motion.SLOW: 0.25, Motion.FAST: 0.05}),
    (Spoilt.DRIFTING, round(0.25 / POSITION_STEP_RAD * 65.536), _SENSOR_DRIFT),
    (Spoilt.OFF, round(0.1 / POSITION_STEP_RAD), dict.fromkeys(Motion, 0.05)),
    (Spoilt.DEAD, 0, dict.fromkeys(Motion, 0.05)),
    (Spoilt.NOISY, round(0.2 / POSITION_STEP_RAD), dict.fromkeys(Motion, 0.25)),
)
_GYRO = (
    (Spoilt.FROZEN, 0, dict.fromkeys(Motion, 0.12)),
    (Spoilt.REVERSED, 0, {Motion.REST: 0.4, Motion.SLOW: 0.1, Motion.FAST: 0.05}),
    (Spoilt.DRIFTING, round(0.5 / RATE_STEP_RAD_S * 65.536), {Motion.REST: 0.8, Motion.SLOW: 0.8, Motion.FAST: 2.0}),
    (Spoilt.OFF, round(0.3 / RATE_STEP_RAD_S), {Motion.REST: 0.3, Motion.SLOW: 0.3, Motion.FAST: 1.5}),
    (Spoilt.DEAD, 0, dict.fromkeys(Motion, 0.05)),
    (Spoilt.NOISY, round(2.0 / RATE_STEP_RAD_S), dict.fromkeys(Motion, 0.25)),
)
_MOTOR = (
    (Spoilt.REVERSED, 0, dict.fromkeys(Motion, 0.05)),
    (Spoilt.DEAD, 0, {Motion.REST: None, Motion.SLOW: 0.15, Motion.FAST: 0.1}),
    (Spoilt.FROZEN, 0, {Motion.REST: None, Motion.SLOW: 0.5, Motion.FAST: 0.5}),
    (Spoilt.OFF, round(5.0 / TORQUE_STEP_NM), dict.fromkeys(Motion, 0.15)),
)
#: most that an axis gains in speed after any fault (rad/s), and how far it goes while it stops (rad)
EXCESS_RAD_S, STOPPING_RAD = 1.5, 0.3
_TROUBLES = {
    Trouble.FEEDBACK_CUT: 0.05,
    Trouble.LINE_CUT: 0.05,
    Trouble.SET_POINTS_LOST: 0.05,
    Trouble.HOST_SILENT: 0.05,
    Trouble.FEEDBACK_FROZEN: 0.12,
    Trouble.STATUS_FROZEN: 0.05,
    Trouble.ANTENNA_RESTARTED: 0.05,
    Trouble.STRANGER: 0.05,
    Trouble.UNDERVOLTAGE: 0.05,
    Trouble.HOT_WINDING: 0.05,
    Trouble.NOISY_LINE: 0.0,
    Trouble.QUICK_STOP: 0.05,
}


def fault_rows() -> tuple[FaultRow, ...]:
    """All rows."""
    rows = []
    for axis in range(2):
        for motion in Motion:
            for part, faults in (("encoder", _ENCODER), ("gyro", _GYRO), ("motor", _MOTOR)):
                for kind, amount, times in faults:
                    within = times[motion]
                    rows.append(
                        _row(
                            axis,
                            motion,
                            1.0 if within is None else within,
                            within is None,
                            part=part,
                            kind=kind,
                            amount=amount,
                        )
                    )
            for trouble, within_s in _TROUBLES.items():
                rows.append(_row(axis, motion, within_s, trouble is Trouble.NOISY_LINE, trouble=trouble))
    return tuple(rows)


def _row(axis: int, motion: Motion, safe_s: float, may_pass: bool, **what: object) -> FaultRow:
    travel = (SPEED_RAD_S[motion] + 0.3) * safe_s + STOPPING_RAD
    return FaultRow(axis, motion, safe_s, EXCESS_RAD_S, travel, may_pass=may_pass, **what)  # type: ignore[arg-type]
