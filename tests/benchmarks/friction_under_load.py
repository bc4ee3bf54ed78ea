"""Do the numbers of `identify` hold where friction grows with the load of a weight?

    python -m tests.benchmarks.friction_under_load [--seed N] [--logs 16]

Joints of an own simulator under a weight, which their model has or lacks, with friction that grows with what the weight
takes by a share of none to 15 %, torque on time or two rows late, and encoders of 16 or 12 bits, all drawn. A line a
log; at the end, how many numbers were identified beside the truth.
"""

from __future__ import annotations

import argparse
from dataclasses import replace

import numpy as np

from gimbal_hil.knowledge.identification import Determination
from gimbal_hil.knowledge.identification.axis_motion import regression_rule
from gimbal_hil.knowledge.identification.rigid_axis import RigidAxisFit, fit_rigid_axis
from tests.cases.joint import BENCH, TRUE, Joint

SHARES = (0.0, 0.0, 0.05, 0.1, 0.15)
NUMBERS = ("inertia", "viscous", "coulomb")


def drawn_joint(rng: np.random.Generator) -> Joint:
    """The bench's joint under a weight, along other swings."""
    swings = {
        which: tuple(
            (size * rng.uniform(0.7, 1.5), hertz * rng.uniform(0.8, 1.2), phase + rng.uniform(0.0, 1.0))
            for size, hertz, phase in own
        )
        for which, own in BENCH.swings.items()
    }
    step = 2.0 * np.pi / float(rng.choice([65536, 4096]))
    return replace(
        BENCH, swings=swings, step=step, weight=float(rng.uniform(0.1, 0.5)), under_load=float(rng.choice(SHARES))
    )


def fitted(joint: Joint, which: str, is_known: bool, late_rows: int, seed: int) -> RigidAxisFit:
    """The regression on one log of a joint."""
    log = joint.log(which, seed=seed)
    torque = np.concatenate([np.full(late_rows, log.torque[0]), log.torque[: len(log.torque) - late_rows]])
    known = -joint.weight * np.sin(log.position) if is_known else None
    return fit_rigid_axis(log.time, log.position, torque, regression_rule(1.0 / joint.rate_hz), known=known)


def main() -> None:
    """Print the table and the sum."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--logs", type=int, default=16)
    chosen = parser.parse_args()
    rng = np.random.default_rng(chosen.seed)
    beside = 0
    for index in range(chosen.logs):
        joint, is_known, late = drawn_joint(rng), bool(rng.integers(2)), int(rng.choice([0, 0, 2]))
        fit = fitted(joint, "ab"[index % 2], is_known, late, int(rng.integers(2**31)))
        found = [one for one in fit.estimates if one.name in NUMBERS]
        wrong = [
            one.name
            for one in found
            if one.verdict is Determination.IDENTIFIED and not one.interval.covers(TRUE[one.name])
        ]
        beside += len(wrong)
        told = " told" if any(one.rule == "friction_under_load" for one in fit.warnings) else ""
        print(
            f"weight {joint.weight:.2f} N m {'known' if is_known else 'unknown'}, share {joint.under_load:.2f}{told}, "
            f"late {late}: " + ", ".join(f"{one.name} {one.interval_text}" for one in found),
            *wrong,
            flush=True,
        )
    print(f"{beside} of {len(NUMBERS) * chosen.logs} numbers are identified beside the truth")


if __name__ == "__main__":
    main()
