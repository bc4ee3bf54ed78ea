"""Do the numbers that `identify` calls identified hold on joints that were drawn?

    python -m tests.benchmarks.numbers_of_drawn_joints [--seed N] [--joints 20]

The joints of `drawn_joints`, two logs each, without what their model would lack, but with the bump of 15 % that their
friction has towards standstill. A line a log; at the end how many identified numbers lie beside their interval.
"""

from __future__ import annotations

import argparse
from dataclasses import replace

import numpy as np

from gimbal_hil.knowledge.identification import Determination
from gimbal_hil.knowledge.identification.axis_motion import regression_rule
from gimbal_hil.knowledge.identification.rigid_axis import fit_rigid_axis
from tests.benchmarks.drawn_joints import HANGS, Drawn, drawn, log


def numbers(joint: Drawn, which: int) -> tuple[str, int, int]:
    """A line about one log, how many numbers are identified, and how many of those are beside their interval."""
    table = log(joint, which)
    position = table.position("pan")
    known = -joint.weight * np.sin(position + HANGS)
    time_s = np.arange(len(position)) * table.period_s
    fit = fit_rigid_axis(time_s, position, table.torque("pan"), regression_rule(table.period_s), known=known)
    true = {"inertia": joint.inertia, "viscous": joint.viscous, "coulomb": joint.coulomb}
    found = [one for one in fit.estimates if one.name in true]
    held = [one for one in found if one.verdict is Determination.IDENTIFIED]
    beside = [one.name for one in held if not one.interval.covers(true[one.name])]
    said = "; ".join(f"{one.name} {one.interval_text} (true {true[one.name]:.4g})" for one in found)
    return " ".join([f"{joint.along}, {joint.rate_hz:g} Hz: {said}", *beside]), len(held), len(beside)


def main() -> None:
    """Print the table and the sum."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--joints", type=int, default=20)
    chosen = parser.parse_args()
    counted = np.zeros(2, dtype=int)
    for index in range(chosen.joints):
        joint = replace(drawn(1000 * chosen.seed + index), extra="none")
        for which in (0, 1):
            line, *counts = numbers(joint, which)
            counted += counts
            print(line, flush=True)
    print(f"{counted[1]} of {counted[0]} identified numbers lie beside their interval")


if __name__ == "__main__":
    main()
