"""A sequence of a few seconds with everything in it: moves, plateaus, a torque ramp that ends at break-away, references
from the start.
"""

from __future__ import annotations

from gimbal_hil.knowledge.experiments.experiment import Experiment, Row, Signals, Step, move_to, position_hold, step_of
from gimbal_hil.knowledge.experiments.plateau import plateau_mean
from gimbal_hil.loop.host import AxisCommand, EndCondition, EndKind, Mode, ReferenceOrigin, Shape

RATE_HZ = 1000.0
SPEED_RAD_S, TRAVEL_RAD = 0.05, 0.05


def small_sequence() -> Experiment:
    """Outer slides to and fro, inner is broken away and caught."""
    steps = [step_of("start", RATE_HZ, 0.6, (move_to(0.0, 0.5), move_to(0.2, 0.5)))]
    for sign, word in ((1, "forward"), (-1, "back")):
        ramp = AxisCommand(Mode.POSITION, Shape.RAMP, (0.0 if sign > 0 else TRAVEL_RAD, sign * SPEED_RAD_S, TRAVEL_RAD))
        commands = (ramp, position_hold(0.2))
        steps.append(step_of(word, RATE_HZ, TRAVEL_RAD / SPEED_RAD_S, commands, {"direction": sign}, measured=True))
    rise = AxisCommand(Mode.TORQUE, Shape.RAMP, (0.0, 0.2, 1.0), ReferenceOrigin.START)
    ends = (EndCondition(EndKind.RATE_ABOVE, 1, 0.02, 5),)
    steps.append(step_of("break away", RATE_HZ, 4.0, (position_hold(0.0), rise), ends=ends))
    here = AxisCommand(Mode.POSITION, Shape.HOLD, (0.0,), ReferenceOrigin.START)
    steps.append(step_of("caught", RATE_HZ, 0.5, (position_hold(0.0), here)))
    return Experiment("small", "A small sequence", tuple(steps), _measure, lambda rows, drawn: [], frozenset(("back",)))


def _measure(step: Step, signals: Signals) -> Row | None:
    mean = plateau_mean(signals, "outer", 0.01, 0.04)
    return None if mean is None else mean.as_row()
