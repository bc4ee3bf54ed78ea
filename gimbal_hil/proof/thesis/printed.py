"""Numbers that the thesis prints (T. Seref, METU 2018), by table number. Facts, not truth:
docs/explanation/reading-the-thesis.md says which hold.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class Loop(Enum):
    """What a table's step goes to."""

    RATE = "rate"
    POSITION = "position"


@dataclass(frozen=True)
class PrintedRow:
    """One row: the swept number (a gain, or the step in rad), overshoot in percent, settling time in s."""

    swept: float
    overshoot_percent: float
    settling_s: float


@dataclass(frozen=True)
class StepTable:
    """A table of step responses; `kp` or `ki` is None where it is what the rows sweep, both are where the step's size
    is.
    """

    number: str
    loop: Loop
    axis: str
    swept: str
    kp: float | None
    ki: float | None
    rows: tuple[PrintedRow, ...]
    #: with the prefilter of table 5.11, and every inertia times this
    prefilter: bool = False
    inertia_factor: float = 1.0


def _rows(*numbers: tuple[float, float, float]) -> tuple[PrintedRow, ...]:
    return tuple(PrintedRow(*row) for row in numbers)


GAIN_TABLES: tuple[StepTable, ...] = (
    StepTable("5.2", Loop.RATE, "outer", "Kp", None, 300.0, _rows(
        (20, 19.45, 0.42), (40, 11.25, 0.48), (60, 7.86, 0.52), (80, 6.01, 0.54), (90, 5.39, 0.54), (120, 4.07, 0.55),
        (140, 3.47, 0.49))),
    StepTable("5.3", Loop.RATE, "outer", "Ki", 140.0, None, _rows(
        (250, 2.87, 0.44), (300, 3.47, 0.49), (350, 4.06, 0.52), (400, 4.65, 0.54), (450, 5.22, 0.55))),
    StepTable("5.4", Loop.RATE, "inner", "Kp", None, 300.0, _rows(
        (5, 19.29, 0.26), (10, 11.26, 0.27), (15, 8.02, 0.28), (20, 6.26, 0.31), (25, 5.19, 0.32), (30, 4.47, 0.32),
        (35, 3.95, 0.33))),
    StepTable("5.5", Loop.RATE, "inner", "Ki", 35.0, None, _rows(
        (250, 3.48, 0.29), (300, 3.95, 0.30), (350, 4.46, 0.30), (400, 4.95, 0.30), (450, 5.49, 0.29))),
    StepTable("5.6", Loop.POSITION, "outer", "Kp", None, 10.0, _rows(
        (5, 29.67, 2.39), (5.5, 28.75, 1.65), (6, 28.01, 1.66), (6.5, 27.26, 1.68), (7, 26.68, 1.69),
        (7.5, 27.97, 1.69), (7.75, 30.63, 1.68))),
    StepTable("5.7", Loop.POSITION, "outer", "Ki", 7.0, None, _rows(
        (7, 20.86, 1.95), (8, 22.82, 1.85), (9, 24.74, 1.77), (10, 26.68, 1.69), (11, 28.69, 1.62))),
    StepTable("5.8", Loop.POSITION, "inner", "Kp", None, 25.0, _rows(
        (8, 25.08, 1.17), (8.5, 25.24, 1.18), (9, 24.85, 1.19), (9.5, 24.53, 1.22), (10, 24.34, 1.23),
        (10.5, 23.71, 1.24), (11, 23.55, 1.25))),
    StepTable("5.9", Loop.POSITION, "inner", "Ki", 11.0, None, _rows(
        (20, 20.18, 1.50), (25, 23.56, 1.26), (30, 27.09, 1.10), (35, 31.43, 0.99), (40, 36.90, 0.91))),
)  # fmt: skip

PREFILTER_TABLES: tuple[StepTable, ...] = (
    StepTable("5.12", Loop.POSITION, "outer", "step", None, None, _rows(
        (0.5, 2.85, 1.53), (0.8, 2.87, 1.62), (1.0, 2.86, 1.60), (1.5, 2.89, 1.74), (2.0, 2.92, 1.75),
        (2.5, 3.27, 1.78)), True),
    StepTable("5.13", Loop.POSITION, "inner", "step", None, None,
    _rows((0.2, 1.62, 0.98), (0.8, 0.45, 0.72), (1.0, 0.41, 0.65)), True),
    StepTable("5.14", Loop.POSITION, "outer", "step", None, None, _rows(
        (0.5, 5.51, 1.83), (0.8, 3.41, 1.81), (1.0, 2.87, 1.75), (1.5, 2.84, 1.74), (2.0, 2.95, 1.81),
        (2.5, 4.39, 1.83)), True, 1.2),
    StepTable("5.15", Loop.POSITION, "inner", "step", None, None, _rows(
        (0.2, 2.61, 1.10), (0.8, 1.30, 0.72), (1.0, 0.47, 0.68)), True, 1.2),
)  # fmt: skip

#: (Kp, Ki): tables 5.10 and 5.11
RATE_GAINS = {"outer": (140.0, 250.0), "inner": (35.0, 250.0)}
POSITION_GAINS = {"outer": (7.0, 7.0), "inner": (11.0, 20.0)}
PREFILTER_RATE_GAINS = {"outer": (150.0, 350.0), "inner": (35.0, 250.0)}
PREFILTER_POSITION_GAINS = {"outer": (8.0, 30.0), "inner": (25.0, 300.0)}
#: num / (den[0] s + den[1]): section 5.3.5
PREFILTERS = {"outer": (4.72, 1.3, 4.72), "inner": (6.28, 1.0, 6.28)}

#: chapter 3: eq. 3.5 and 3.6, references (rad/s), rate of the axis that is not under test
UNBALANCE_GAINS = {"outer": (20.0, 50.0), "inner": (10.0, 30.0)}
UNBALANCE_REFERENCES_RAD_S = (0.1, 0.5)
OTHER_AXIS_RAD_S = 0.05

#: section 4.3.1: speeds of the sliding experiment
SLIDING_SPEEDS, SLIDING_LOW_RAD_S, SLIDING_HIGH_RAD_S = 45, 0.001, 0.1
#: tables 4.3 and 4.4: angle (deg) and torque (N m) of the presliding runs, bristle deflection (rad)
PRESLIDING = {"outer": (0.63, 0.254, 0.00106), "inner": (0.34, 0.144, 0.00060)}
#: LuGre numbers Ts, Tc (N m), vs (rad/s), sigma2 (N m s/rad), delta, sigma0 (N m/rad), sigma1 (N m s/rad): tables 4.1
#: to 4.6, measured
FRICTION = {
    "outer": (0.2585, 0.2412, 0.0054, 0.0609, 1.0459, 238.88, 16.02),
    "inner": (0.1451, 0.1376, 0.0075, 0.0336, 1.4628, 271.68, 6.97),
}
#: the same as the thesis' own fit of its simulation found them again: tables 4.7 to 4.10
FRICTION_RECOVERED = {
    "outer": (0.2555, 0.2455, 0.0055, 0.0655, 1.05, 230.99, 14.99),
    "inner": (0.1455, 0.1350, 0.0071, 0.0310, 1.4510, 270.01, 5.99),
}
