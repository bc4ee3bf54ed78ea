"""One controller in one scenario on one antenna: run in lockstep, judged by the antenna's true motion."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gimbal_hil.knowledge.tuning import PredictedJoint
from gimbal_hil.loop.host import (
    AXIS_NAMES,
    AxisCommand,
    Guard,
    HostState,
    Mode,
    Program,
    ReferenceOrigin,
    Segment,
    Shape,
    program_of,
)
from gimbal_hil.loop.settings import DaemonSettings
from gimbal_hil.pointing.arena.base_motions import ROW_HZ, AircraftMotion
from gimbal_hil.pointing.arena.predictive_run import PredictivePath
from gimbal_hil.pointing.arena.scenarios import Scenario, Score
from gimbal_hil.pointing.arena.wrong_numbers import with_wrong_law, with_wrong_model
from gimbal_hil.proof.thesis import step_figures
from gimbal_hil.realtime.lockstep import FramePath, LawPath, Recorded
from sim_backend.layout import POSITION
from sim_backend.model import AntennaModel

Table = NDArray[np.float64]
#: after a reversal of the reference, s
_PEAK_S = 0.4
#: points of a drawn error
_DRAWN = 1500
_LEAD, _JUDGED = 0, 1
#: powers of the inverse of the plastic number: multiples of both together fill a square evenly
_SPREAD = (0.7548776662466927, 0.5698402909980532)
#: modes whose values are positions of the joints, or nearly
_PLACES = (Mode.POSITION, Mode.POINTING)


@dataclass(frozen=True)
class Trial:
    """What is run: all of it can be sent to another process."""

    scenario: Scenario
    controller: str
    settings: DaemonSettings
    antenna: str
    model: AntennaModel
    seed: int
    #: whether its error is kept for drawing
    drawn: bool = False
    #: by what share of itself every number is off of the model that the loops use
    wrong: float = 0.0
    #: what closes the loops in place of the settings
    law: Table | tuple[PredictedJoint, ...] | None = None


@dataclass(frozen=True)
class TrialOutcome:
    """What came of a trial. Errors are of the true joints against the reference, in rad; what a scenario does not ask
    for is NaN.
    """

    scenario: str
    controller: str
    antenna: str
    seed: int
    #: why the host or the antenna stopped; then no figure is given
    tripped: str = ""
    #: angle between where the boresight looks and where it should
    los_rms: float = math.nan
    #: (outer, inner)
    rms: tuple[float, float] = (math.nan, math.nan)
    reversal_peak: tuple[float, float] = (math.nan, math.nan)
    #: percent of the step; s from the step into a band of 2 %, infinite where it never stays there
    overshoot: float = math.nan
    settling_s: float = math.nan
    torque_rms: tuple[float, float] = (math.nan, math.nan)
    #: time (s) and line-of-sight error, thinned
    trace: tuple[Table, Table] | None = None


def run_trial(trial: Trial) -> TrialOutcome:
    """Run and judge one trial."""
    with tempfile.TemporaryDirectory() as folder:
        model = _on_its_base(trial, Path(folder))
        settings = with_wrong_model(trial.settings, trial.wrong, trial.seed, Path(folder))
        path, true = _path(trial, settings, model)
    path.connect()
    before = path.tick
    recorded = path.run(program_for(trial))
    if path.host.state is not HostState.ACTIVE:
        return TrialOutcome(*_names(trial), tripped=path.host.cause.name.lower())
    return _judged(trial, recorded, true(before))


def program_for(trial: Trial) -> Program:
    """What the antenna is asked for in a trial."""
    return program_of(segments_for(trial))


def _path(
    trial: Trial, settings: DaemonSettings, model: AntennaModel
) -> tuple[FramePath | LawPath | PredictivePath, Callable[[int], Table]]:
    """Host and antenna with what closes their loops, and where the joints truly were from a tick on."""
    path: LawPath | PredictivePath
    if trial.law is None:
        return _through_frames(settings, model, trial.seed)
    if isinstance(trial.law, tuple):
        path = PredictivePath(settings, model, trial.seed, trial.law)
    else:
        law = with_wrong_law(trial.law, trial.settings, trial.wrong, trial.seed)
        path = LawPath(settings, model, trial.seed, law)
    return path, path.joints


def _through_frames(
    settings: DaemonSettings, model: AntennaModel, seed: int
) -> tuple[FramePath, Callable[[int], Table]]:
    """Host and antenna, and where its joints truly were from a tick on."""
    seen: list[tuple[float, float]] = []

    def look(tick: int, received: bytes, sent: bytes) -> None:
        seen.append((X[POSITION], X[POSITION + 1]))

    path = FramePath(settings, model, seed, exchange=look)
    X = path.device.X
    # what was seen after tick n is where the joints are at the next one
    return path, lambda first: np.array(seen)[first - 1 : -1]


def _names(trial: Trial) -> tuple[str, str, str, int]:
    return trial.scenario.name, trial.controller, trial.antenna, trial.seed


def _on_its_base(trial: Trial, folder: Path) -> AntennaModel:
    """The antenna on the scenario's base, its inertial navigation as old as the model says."""
    age, base = trial.model.file.base.ins_age_s, trial.scenario.base
    if not isinstance(base, AircraftMotion):
        return trial.model.with_base(base.model_dump(mode="json", exclude_defaults=True) | {"ins_age_s": age})
    file = folder / "base.csv"
    base.write(file, trial.scenario.lead_s + trial.scenario.duration_s + 1.0, trial.seed)
    return trial.model.with_base({"motion": "recorded", "file": str(file), "ins_age_s": age})


def _within_a_count(trial: Trial) -> tuple[float, float]:
    """By how much of its encoder's count (rad) the reference of each joint is moved: a joint that rests is anywhere
    within a count, which no law sees, and a reference at zero would show one place alone. Seeds spread over the count
    (Roberts' additive recurrence).
    """
    steps = [trial.model.number(axis, "encoder.step") for axis in trial.model.axes]
    return _pair([step * (trial.seed * share % 1.0) for step, share in zip(steps, _SPREAD, strict=True)])


def segments_for(trial: Trial) -> list[Segment]:
    """To the first value of both references (zero for a step), then what is judged."""
    scenario, rate_hz, moved = trial.scenario, trial.settings.rate_hz, _within_a_count(trial)
    commands = [
        _moved(axis.command(Guard(), 1.0 / rate_hz), by)
        for axis, by in zip((scenario.outer, scenario.inner), moved, strict=True)
    ]
    first = [
        0.0 if name == scenario.axis or command.mode not in _PLACES else _first_value(command)
        for name, command in zip(AXIS_NAMES, commands, strict=True)
    ]
    outer, inner = (AxisCommand(Mode.POSITION, Shape.SMOOTH, (value, 0.6 * scenario.lead_s)) for value in first)
    lead = Segment(outer, inner, round(scenario.lead_s * rate_hz), label=_LEAD)
    ticks = round(scenario.duration_s * rate_hz)
    return [lead, Segment(commands[0], commands[1], ticks, label=_JUDGED)]


def _moved(command: AxisCommand, by_rad: float) -> AxisCommand:
    """A position that is asked for, moved; tables and what counts from where the axis is stay."""
    absolute = command.mode is Mode.POSITION and command.origin is ReferenceOrigin.ABSOLUTE
    if not absolute or command.shape in (Shape.TABLE, Shape.TIMETABLE):
        return command
    return replace(command, parameters=(command.parameters[0] + by_rad, *command.parameters[1:]))


def _first_value(command: AxisCommand) -> float:
    value = command.parameters[0]
    if command.shape is Shape.SINE:
        value += command.parameters[1] * math.sin(command.parameters[3])
    return value


def _judged(trial: Trial, recorded: Recorded, true: Table) -> TrialOutcome:
    scenario, step_s = trial.scenario, recorded.step_s
    rows, signals = recorded.segment == _JUDGED, recorded.signals()
    position, time_s = true[rows], step_s * np.arange(np.count_nonzero(rows), dtype=np.float64)
    wanted = np.column_stack([signals[f"{axis}.position_ref"][rows] for axis in recorded.axes])
    if scenario.points:
        wanted = _true_joints(trial, signals["time_s"][rows], wanted)
    slope = np.column_stack([signals[f"{axis}.rate_ref"][rows] for axis in recorded.axes])
    torque = np.column_stack([signals[f"{axis}.torque"][rows] for axis in recorded.axes])
    late = time_s >= scenario.settle_s
    error, angle = position - wanted, between(boresight(position), boresight(wanted))
    found: dict[str, float | tuple[float, float]] = {}
    if scenario.score is Score.STEP:
        place = AXIS_NAMES.index(scenario.axis or "outer")
        size = float(wanted[-1, place])
        found["overshoot"], found["settling_s"] = step_figures(time_s, position[:, place] * np.sign(size), abs(size))
    elif scenario.score is Score.REVERSAL:
        found["reversal_peak"] = _pair([_peak(error[:, i], slope[:, i], late, step_s) for i in range(2)])
    trace = None
    if trial.drawn:
        thin = max(1, len(time_s) // _DRAWN)
        trace = (time_s[::thin], angle[::thin])
    return TrialOutcome(
        *_names(trial),
        los_rms=_rms(angle[late]),
        rms=_pair([_rms(error[late, i]) for i in range(2)]),
        torque_rms=_pair([_rms(torque[late, i]) for i in range(2)]),
        trace=trace,
        **found,  # type: ignore[arg-type]
    )


def _true_joints(trial: Trial, time_s: Table, asked: Table) -> Table:
    """Joint positions (n, 2) that look in the scenario's direction from the base as it truly is: the first segment's
    value in each axis, on the turn of what was asked.
    """
    scenario, base = trial.scenario, trial.scenario.base
    assert isinstance(base, AircraftMotion), "the scenario was validated"
    attitude, _ = base.rows(scenario.lead_s + scenario.duration_s + 1.0, trial.seed)
    at = np.arange(len(attitude)) / ROW_HZ
    roll, pitch, yaw = (np.interp(time_s, at, angle) for angle in attitude.T)
    values = [axis.command(Guard(), 1.0).parameters[0] for axis in (scenario.outer, scenario.inner)]
    x, y, z = boresight(np.array([values]))[0]
    x1, y1 = np.cos(yaw) * x + np.sin(yaw) * y, np.cos(yaw) * y - np.sin(yaw) * x
    x2, z2 = np.cos(pitch) * x1 - np.sin(pitch) * z, np.sin(pitch) * x1 + np.cos(pitch) * z
    y3, z3 = np.cos(roll) * y1 + np.sin(roll) * z2, np.cos(roll) * z2 - np.sin(roll) * y1
    azimuth = np.arctan2(y3, x2)
    azimuth += 2.0 * math.pi * np.round((asked[:, 0] - azimuth) / (2.0 * math.pi))
    return np.column_stack([azimuth, -np.arcsin(z3)])


def boresight(joints: Table) -> Table:
    """Direction (n, 3) in base axes in which the antenna looks at joint positions (n, 2): x of the inner body."""
    azimuth, elevation = joints[:, 0], joints[:, 1]
    level = np.cos(elevation)
    return np.column_stack([level * np.cos(azimuth), level * np.sin(azimuth), -np.sin(elevation)])


def between(one: Table, other: Table) -> Table:
    """Angles (n,) between directions; exact for small ones too."""
    chord = np.linalg.norm(one - other, axis=1)
    return np.asarray(2.0 * np.arcsin(np.minimum(1.0, 0.5 * chord)))


def _peak(error: Table, slope: Table, late: NDArray[np.bool_], step_s: float) -> float:
    """Largest error within a while after each change of the reference's direction."""
    turns = np.flatnonzero(np.diff(np.sign(slope)) != 0) + 1
    window = round(_PEAK_S / step_s)
    peaks = [float(np.abs(error[turn : turn + window]).max()) for turn in turns if late[turn]]
    return max(peaks, default=math.nan)


def _rms(values: Table) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _pair(values: list[float]) -> tuple[float, float]:
    return values[0], values[1]
