"""What an improvement may ask of the antenna: time under control, torque, travel; looked at before anything moves."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

from firmware_protocol.errors import BadInputError
from gimbal_hil.knowledge.experiments import TEARDOWN_S, Experiment, Step
from gimbal_hil.knowledge.improvement.rehearsal import Rehearsal
from gimbal_hil.loop.host import AxisCommand
from gimbal_hil.loop.settings import DaemonSettings

#: the way back to the safe pose and switching off, as the runner does it after every experiment
AFTERWARDS_S = 0.9 * TEARDOWN_S


@dataclass(frozen=True)
class Budgets:
    """Limits of one improvement; torque (N m) and travel (rad, low and high) by axis."""

    antenna_s: float
    rounds: int
    torque_nm: Mapping[str, float]
    travel_rad: Mapping[str, tuple[float, float]]

    def refusal(self, experiment: Experiment, rehearsal: Rehearsal, rate_hz: float, used_s: float) -> str | None:
        """Why an experiment would exceed a budget, judged by its rehearsal on the model; None when it would not."""
        needed = experiment.duration_s(rate_hz) + AFTERWARDS_S
        if used_s + needed > self.antenna_s:
            return (
                f"needs {needed:.0f} s of antenna time; {max(0.0, self.antenna_s - used_s):.0f} s of "
                f"{self.antenna_s:.0f} s are left"
            )
        if rehearsal.stopped is not None:
            return f"is stopped when it is rehearsed on the model: {rehearsal.stopped}"
        for axis in self.torque_nm:
            torque, (low, high) = rehearsal.torque_nm[axis], rehearsal.travel_rad[axis]
            if torque > self.torque_nm[axis]:
                return f"needs {torque:.3g} N m on {axis}; {self.torque_nm[axis]:.3g} N m are allowed"
            least, most = self.travel_rad[axis]
            if low < least or high > most:
                return f"moves {axis} over {low:.3f} to {high:.3f} rad; {least:.3f} to {most:.3f} rad are allowed"
        return None

    def guarded(self, experiment: Experiment) -> Experiment:
        """The same experiment with guards in every step: an antenna that does other than its model is stopped at the
        budget.
        """
        return replace(experiment, steps=tuple(self._guarded_step(step) for step in experiment.steps))

    def _guarded_step(self, step: Step) -> Step:
        outer, inner = self.torque_nm
        guarded = self._guarded_axis(outer, step.segment.outer), self._guarded_axis(inner, step.segment.inner)
        return replace(step, segment=replace(step.segment, outer=guarded[0], inner=guarded[1]))

    def _guarded_axis(self, axis: str, command: AxisCommand) -> AxisCommand:
        guard, (low, high) = command.guard, self.travel_rad[axis]
        tighter = replace(
            guard,
            low_rad=max(guard.low_rad, low),
            high_rad=min(guard.high_rad, high),
            torque_nm=min(guard.torque_nm, self.torque_nm[axis]),
        )
        return replace(command, guard=tighter)


def budgets_of(
    settings: DaemonSettings,
    antenna_s: float,
    rounds: int,
    torque: Mapping[str, float],
    travel: Mapping[str, tuple[float, float]],
) -> Budgets:
    """What was given, within the limits of the configuration; BadInputError where more was given than those allow."""
    for option, given in (("--torque", torque), ("--travel", travel)):
        for axis in given:
            if axis not in settings.axes:
                raise BadInputError(
                    f"{option} {axis}", "names no axis", "AXIS=VALUE with axis " + " or ".join(settings.axes)
                )
    torques, travels = {}, {}
    for axis in settings.axis_names:
        limits = settings.axes[axis].limits
        wrap = math.inf if limits.cable_wrap_turns is None else 2.0 * math.pi * limits.cable_wrap_turns
        low = -wrap if limits.position_low_rad is None else max(-wrap, limits.position_low_rad)
        high = wrap if limits.position_high_rad is None else min(wrap, limits.position_high_rad)
        torques[axis] = torque.get(axis, limits.torque_nm)
        travels[axis] = travel.get(axis, (low, high))
        if torques[axis] > limits.torque_nm:
            raise BadInputError(
                f"--torque {axis}={torques[axis]:g}",
                "is over the configuration's limit",
                f"at most {limits.torque_nm:g} N m",
            )
        if travels[axis][0] < low or travels[axis][1] > high:
            asked = f"--travel {axis}={travels[axis][0]:g}..{travels[axis][1]:g}"
            raise BadInputError(asked, "is over the configuration's limits", f"within {low:g} to {high:g} rad")
    return Budgets(antenna_s, rounds, torques, travels)


def torques_of(texts: list[str]) -> dict[str, float]:
    """`outer=3.5` (N m) by axis; BadInputError says what was expected."""
    return {axis: _number(f"--torque {text}", value) for text in texts for axis, value in (_split("--torque", text),)}


def travels_of(texts: list[str]) -> dict[str, tuple[float, float]]:
    """`inner=-0.8..0.8` (rad) by axis; BadInputError says what was expected."""
    found = {}
    for text in texts:
        axis, value = _split("--travel", text)
        low, dots, high = value.partition("..")
        if not dots:
            raise BadInputError(f"--travel {text}", "is no range", "AXIS=LOW..HIGH in rad, as in inner=-0.8..0.8")
        found[axis] = _number(f"--travel {text}", low), _number(f"--travel {text}", high)
        if found[axis][0] >= found[axis][1]:
            raise BadInputError(f"--travel {text}", "ends before it begins", "LOW below HIGH")
    return found


def _split(option: str, text: str) -> tuple[str, str]:
    axis, equals, value = text.partition("=")
    if not equals:
        raise BadInputError(f"{option} {text}", "names no axis", "AXIS=VALUE")
    return axis, value


def _number(where: str, text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        raise BadInputError(where, f"{text!r} is no number", "a number in SI units") from None
    if not math.isfinite(value):
        raise BadInputError(where, f"{text!r} is not finite", "a finite number")
    return value
