"""Chapter 3: rate loops on a moving base, with dynamic unbalance, static unbalance, and with neither.

No friction, as in the thesis' chapter 3. The balanced antenna is run beside the others because (I_xx - I_zz) w_x w_z,
which the thesis counts as unbalance, acts on a balanced gimbal too.
"""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np

from gimbal_hil.loop.control import Mode
from gimbal_hil.proof.thesis.closed_loop import AxisLoop, Gains, LoopResponse, run_closed_loop
from gimbal_hil.proof.thesis.inferred import LEVEL
from gimbal_hil.proof.thesis.printed import OTHER_AXIS_RAD_S, UNBALANCE_GAINS, UNBALANCE_REFERENCES_RAD_S
from sim_backend.model import THESIS_BASE_CASES, AntennaModel, model_from_document
from sim_backend.thesis_slips import Slip

_RATE_HZ, _DURATION_S, _STEP_S = 1000.0, 24.0, 0.2
#: the step's own transient is over
_SETTLED_S = 4.0


class Unbalance(Enum):
    """Which unbalance the antenna has."""

    NONE = "none"
    DYNAMIC = "dynamic"
    STATIC = "static"

    @property
    def table(self) -> str:
        """The table of base motions that the thesis runs it on."""
        return "3.2" if self is Unbalance.STATIC else "3.1"


@dataclass(frozen=True)
class UnbalanceRun:
    """One run: the steady oscillation of the axis under test, after its step has settled."""

    unbalance: Unbalance
    axis: str
    reference_rad_s: float
    case: int
    #: half the peak-to-peak swing of the rate, percent of the reference
    ripple_percent: float
    #: largest magnitude of the motor's torque, N m
    torque_peak_nm: float
    #: swing in the second half of the steady part over that in the first half: about 1 is a bounded, forced oscillation
    growth: float
    response: LoopResponse


def run_unbalance(
    unbalance: Unbalance, axis: str, reference_rad_s: float, case: int, slips: Slip = Slip.NONE
) -> UnbalanceRun:
    """Run one case (counted from 1, as printed) of table 3.1 or 3.2, optionally with slips of the thesis switched
    on.
    """
    model = antenna_with(unbalance, slips).with_base({"motion": "case", "table": unbalance.table, "case": case})
    index = model.axes.index(axis)
    reference = np.zeros((round(_DURATION_S * _RATE_HZ), 2))
    first = round(_STEP_S * _RATE_HZ)
    reference[first:, index], reference[first:, 1 - index] = reference_rad_s, OTHER_AXIS_RAD_S
    loops = [
        AxisLoop(
            Mode.RATE,
            Gains(*UNBALANCE_GAINS[name]),
            torque_per_unit_nm=LEVEL.drive(name).per_unit_nm,
            torque_limit_nm=LEVEL.drive(name).limit_nm,
        )
        for name in model.axes
    ]
    response = run_closed_loop(model, loops[0], loops[1], reference, _RATE_HZ)
    steady = response.time_s > _SETTLED_S
    rate, torque = response.rate_rad_s[steady, index], response.torque_nm[steady, index]
    early, late = np.array_split(rate, 2)
    growth = float(np.ptp(late) / np.ptp(early)) if np.ptp(early) > 0.0 else 1.0
    return UnbalanceRun(
        unbalance,
        axis,
        reference_rad_s,
        case,
        100.0 * float(np.ptp(rate)) / 2.0 / reference_rad_s,
        float(np.abs(torque).max()),
        growth,
        response,
    )


def run_all_cases() -> tuple[UnbalanceRun, ...]:
    """Every case of tables 3.1 and 3.2, both axes, both references; table 3.1 also on the balanced antenna."""
    return tuple(
        run_unbalance(unbalance, axis, reference, case)
        for unbalance in Unbalance
        for axis in UNBALANCE_GAINS
        for reference in UNBALANCE_REFERENCES_RAD_S
        for case in range(1, 1 + len(THESIS_BASE_CASES[unbalance.table]))
    )


def antenna_with(unbalance: Unbalance, slips: Slip = Slip.NONE) -> AntennaModel:
    """The thesis' antenna without friction, with one kind of unbalance, and with slips of the thesis switched on."""
    model = LEVEL.antenna()
    document = copy.deepcopy(model.document)
    for axis in model.axes:
        section = document["axes"][axis]
        section["friction"] = {}
        if unbalance is not Unbalance.STATIC:
            section["body"]["cog"] = {}
        if unbalance is not Unbalance.DYNAMIC:
            section["body"]["inertia"] = {key: section["body"]["inertia"][key] for key in ("xx", "yy", "zz")}
    document["thesis_slips"] = [slip.name.lower() for slip in Slip if slip in slips and slip.name]
    return model_from_document(document, "the thesis' antenna of chapter 3")


@dataclass(frozen=True)
class Claim:
    """A statement of the thesis' chapter 3, whether it holds here, and the figures behind that."""

    text: str
    holds: bool
    evidence: str


def claims(runs: Sequence[UnbalanceRun], with_gravity_slip: UnbalanceRun) -> tuple[Claim, ...]:
    """Chapter 3's statements against the runs; `with_gravity_slip` is outer, static, case 1 with eq. 3.10 as
    printed.
    """
    at = {(run.unbalance, run.axis, run.reference_rad_s, run.case): run for run in runs}
    low, high = UNBALANCE_REFERENCES_RAD_S
    axes = tuple(UNBALANCE_GAINS)
    dynamic = [run for run in runs if run.unbalance is Unbalance.DYNAMIC]
    still = max(run.ripple_percent for run in dynamic if run.case == 1)
    moving = min(run.ripple_percent for run in dynamic if run.case >= 3)
    fast = max(
        at[Unbalance.DYNAMIC, a, high, c].ripple_percent / at[Unbalance.DYNAMIC, a, low, c].ripple_percent
        for a in axes
        for c in (3, 4, 5)
    )
    growth = max(run.growth for run in dynamic if run.case >= 3)
    swing = {
        (kind, axis): max(run.torque_peak_nm for run in runs if run.unbalance is kind and run.axis == axis)
        for kind in (Unbalance.DYNAMIC, Unbalance.STATIC)
        for axis in axes
    }
    outer_still = at[Unbalance.STATIC, "outer", low, 1]
    balanced = (
        at[Unbalance.NONE, "inner", low, 5].ripple_percent / at[Unbalance.DYNAMIC, "inner", low, 5].ripple_percent
    )
    return (
        Claim(
            "dynamic: cases 3 to 5 oscillate, case 1 does not",
            still < 0.01 * moving,
            f"case 1 {still:.1g} %, cases 3 to 5 at least {moving:.2f} %",
        ),
        Claim(
            "dynamic: relative swing is smaller at 0.5 than at 0.1 rad/s",
            fast < 1.0,
            f"at most {fast:.2f} of it, cases 3 to 5",
        ),
        Claim(
            "dynamic: the loops become unstable",
            growth > 2.0,
            f"swing of the second half over the first at most {growth:.2f}: bounded, forced",
        ),
        Claim(
            "outer: static outweighs dynamic by far",
            swing[Unbalance.STATIC, "outer"] > 5.0 * swing[Unbalance.DYNAMIC, "outer"],
            _against(swing, "outer"),
        ),
        Claim(
            "inner: dynamic dominates static",
            swing[Unbalance.DYNAMIC, "inner"] > swing[Unbalance.STATIC, "inner"],
            _against(swing, "inner"),
        ),
        Claim(
            "static: the outer gimbal is disturbed without base motion",
            outer_still.torque_peak_nm > 0.1,
            f"{outer_still.torque_peak_nm:.2g} N m of motor torque; with eq. 3.10 as printed "
            f"{with_gravity_slip.torque_peak_nm:.1f} N m",
        ),
        Claim(
            "inner: the oscillation of table 3.1 is dynamic unbalance",
            balanced < 0.5,
            f"a balanced antenna has {100 * balanced:.0f} % of it: it is (I_xx - I_zz) w_x w_z",
        ),
    )


def _against(peak: dict[tuple[Unbalance, str], float], axis: str) -> str:
    return f"{peak[Unbalance.STATIC, axis]:.2f} N m static against {peak[Unbalance.DYNAMIC, axis]:.2f} N m dynamic"
