"""Runs that tell causes apart which look alike. An effect names those that separate it; effects that share a run are a
class.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class SeparatingRun:
    """A run in words, and the experiment of that name that makes it; None where it needs a person."""

    text: str
    sequence: str | None = None


PLATEAUS = SeparatingRun("five or more plateau speeds over a decade, both directions", "plateaus")
FULL_TRAVEL = SeparatingRun("the whole travel, a full turn if it can", "full_turn")
TWO_TILTS = SeparatingRun("the same motion at two base tilts")
TWO_SPEEDS = SeparatingRun("two constant speeds over a full turn in both directions, gyro recorded", "full_turn")
KNOWN_LOAD = SeparatingRun("a known added inertia, or a stall run against the stop")
TORQUE_SWEEP = SeparatingRun("a chirp or pulses of torque beyond half the resonance", "sweep")
CREEP = SeparatingRun("plateaus below the Stribeck velocity and ramps below break-away", "creep")
REVERSAL_SIZES = SeparatingRun("an amplitude sweep of reversals: a gap has a fixed width", "reversals")
WARM_AND_COOL = SeparatingRun("warm up at speed, then cool down, plateaus in between", "warm_and_cool")
TWO_LOADS = SeparatingRun("the same motion at two loads: in several poses", "two_loads")
ONE_LOCKED = SeparatingRun("drive one axis with the other locked, then reverse", "one_locked")
MEASURED_TORQUE = SeparatingRun("the same plateaus with the torque measured from motor current")

#: in the order in which they are proposed
RUNS = (
    PLATEAUS, FULL_TRAVEL, TWO_TILTS, TWO_SPEEDS, KNOWN_LOAD, TORQUE_SWEEP, CREEP, REVERSAL_SIZES, WARM_AND_COOL,
    TWO_LOADS, ONE_LOCKED,
    MEASURED_TORQUE,
)  # fmt: skip
