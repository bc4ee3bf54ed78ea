"""A whole configuration tuned for a model: loops, observers, prefilters, and what of the model is fed forward."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

from firmware_protocol.json_object import Json
from gimbal_hil.knowledge.tuning.aims import Aim
from gimbal_hil.knowledge.tuning.axis_cases import axis_cases
from gimbal_hil.knowledge.tuning.choosing import (
    WRONG_SHARE,
    JointMaker,
    LoopChoice,
    LoopFigures,
    TuningTask,
    cascade_laws,
    choose_cascade,
    choose_observed,
    figures,
    observed_maker,
)
from gimbal_hil.knowledge.tuning.loops import CascadeLaw, Disturbances, Law
from gimbal_hil.knowledge.tuning.rivals import linear_quadratic
from gimbal_hil.loop.settings import AxisSettings, DaemonSettings, JointObserver, delay_ticks, observed_joint
from sim_backend.model import AntennaModel, ModelKind

#: least disk margin unless another one is asked for: gain may be 1.5 times off either way, phase 23 degrees
MARGIN = 0.4
#: torque that stands in for friction's where a model has none, over the torque limit
_LEAST_WALK = 0.01
#: torque that the sensors' noise may ask for (rms), over the torque limit
_MOST_NOISE = 0.003
#: what counts of walking torque and gusts in each aim: shares of the break-away torque, in a root second and rms
_WALK_AND_GUST = {Aim.TRACKING: (1.0, 0.0), Aim.BOTH: (1.0, 0.1), Aim.POINTING: (0.25, 0.1)}
#: what of the walking torque is left where the model's friction is fed forward
_LEFT_WALK = 0.02
#: the prefilter's corner over the position loop's gain, and at most (1/s); its acceleration in torque over the limit:
#: more gains next to nothing, at the zenith either
_PREFILTER_SHARE, _QUICKEST_PREFILTER, _ACCELERATION_SHARE = 0.25, 15.0, 0.5
#: a number that may be off by more than this share of itself is not fed forward: half as much again is the break-even
_MOST_UNCERTAIN = 0.5


@dataclass(frozen=True)
class AxisTuning:
    """What became of one axis: figures of its loops before (None: not stable, or not of this kind), of the tuned
    cascade, and of the loops with the observer (None: the cascade is at least as good); and keys that change.
    """

    axis: str
    before: LoopFigures
    cascade: LoopFigures
    observed: LoopFigures | None
    changes: Mapping[str, object]

    @property
    def after(self) -> LoopFigures:
        """Figures of the loops that the changed configuration closes."""
        return self.observed or self.cascade


@dataclass(frozen=True)
class Tuning:
    """What a configuration becomes: dotted keys with their values, and what is predicted of each axis."""

    axes: tuple[AxisTuning, ...]
    changes: Mapping[str, object]
    #: parts of the model that stay off, and why
    left_off: Mapping[str, str]


class NoMarginError(Exception):
    """No loops of an axis keep the margin asked for."""

    def __init__(self, axis: str, margin: float) -> None:
        super().__init__(f"{axis}: no loops that were tried keep a disk margin of {margin:g}")


def tuned(
    settings: DaemonSettings,
    model: AntennaModel,
    reference: str,
    margin: float = MARGIN,
    aim: Aim = Aim.TRACKING,
) -> Tuning:
    """Tune `settings`, whose axes are called as the model's; `reference` is how the file is to name the model;
    `aim` is what the loops are for.

    Raises NoMarginError.
    """
    whole = model.kind is ModelKind.GIMBAL
    axes = tuple(_axis(settings, model, axis, margin, whole, aim) for axis in model.axes)
    changes = {key: value for one in axes for key, value in one.changes.items()}
    left_off = {}
    if whole:
        uncertain = {part: _uncertain(model, part) for part in ("bodies", "friction")}
        left_off = {part: why for part, why in uncertain.items() if why}
        parts = {part: part not in left_off for part in uncertain}
        changes["model_control"] = {"model": reference, **parts, "extrapolate_base": True}
    return Tuning(axes, changes, left_off)


def tuning_task(model: AntennaModel, axis: str, step_s: float, margin: float, aim: Aim = Aim.TRACKING) -> TuningTask:
    """What the loops of an axis have to do by a model."""
    walk = model.number(axis, "friction.breakaway") or _LEAST_WALK * model.number(axis, "actuator.limit")
    observer = JointObserver(bandwidth_rad_s=1.0)
    joint = observed_joint(model, axis, step_s, observer)
    walks, gusts = _WALK_AND_GUST[aim]
    noises = joint.encoder_noise_rad, joint.gyro_noise_rad_s
    disturbances = Disturbances(walks * walk, observer.offset_walk_rad_s, *noises, gusts * walk)
    limit = model.number(axis, "actuator.limit") or math.inf
    return TuningTask(step_s, axis_cases(model, axis), disturbances, margin, _MOST_NOISE * limit)


def laws_of(settings: DaemonSettings, model: AntennaModel, axis: str, task: TuningTask) -> tuple[Law, ...]:
    """The loops that a configuration closes on each case of an axis."""
    section, most = settings.axes[axis], max(case.inertia_kg_m2 for case in task.cases)
    observer, scale = section.observer, section.rate_loop.torque_per_unit_nm
    if observer is not None:
        ticks = delay_ticks(model, axis, task.step_s, observer)
        make = observed_maker(task, lambda *_: observed_joint(model, axis, task.step_s, observer), ticks)
        position = observer.position_kp_per_s or section.position_loop.kp_per_s
        rate = observer.rate_kp_s_per_rad or section.rate_loop.kp_s_per_rad
        return make((position, scale * rate / most, observer.bandwidth_rad_s, observer.gusts_above_rad_s or math.inf))
    position_loop, rate_loop = section.position_loop, section.rate_loop
    gains = position_loop.kp_per_s, position_loop.ki_per_s2, rate_loop.kp_s_per_rad, rate_loop.ki_per_rad
    law = CascadeLaw(task.step_s, *gains[:2], scale * gains[2], scale * gains[3])
    return (law,) * len(task.cases)


def _axis(settings: DaemonSettings, model: AntennaModel, axis: str, margin: float, whole: bool, aim: Aim) -> AxisTuning:
    task, section = tuning_task(model, axis, settings.step_s, margin, aim), settings.axes[axis]
    cascade = choose_cascade(task)
    if cascade is None:
        raise NoMarginError(axis, margin)
    observed = _observed(model, axis, task, not _uncertain(model, "friction")) if whole else None
    of_cascade = figures(cascade.laws, task)
    of_observed = figures(observed.laws, task) if observed is not None else None
    if of_observed is not None and of_observed.error_rad > of_cascade.error_rad:
        observed, of_observed = None, None
    before = figures(laws_of(settings, model, axis, task), task)
    feeds_bodies = whole and not _uncertain(model, "bodies")
    changes = _changes(section, model, axis, task, cascade, observed, feeds_bodies)
    return AxisTuning(axis, before, of_cascade, of_observed, changes)


def _observed(model: AntennaModel, axis: str, task: TuningTask, feeds_friction: bool) -> LoopChoice | None:
    if feeds_friction:
        left = _LEFT_WALK * task.disturbances.torque_walk_nm
        task = replace(task, disturbances=replace(task.disturbances, torque_walk_nm=left))
    return choose_observed(task, _joint_maker(model, axis, task), delay_ticks(model, axis, task.step_s))


def regulated(model: AntennaModel, axis: str, task: TuningTask) -> LoopChoice | None:
    """LQG with integral action for an axis; None where none keeps the margin."""
    ticks = delay_ticks(model, axis, task.step_s)
    return linear_quadratic(observed_maker(task, _joint_maker(model, axis, task), ticks), task)


def _joint_maker(model: AntennaModel, axis: str, task: TuningTask) -> JointMaker:
    """Observers of an axis."""
    one = observed_joint(model, axis, task.step_s, JointObserver(bandwidth_rad_s=1.0))
    return lambda bandwidth, corner: replace(one, bandwidth_rad_s=bandwidth, gusts_above_rad_s=corner)


def _changes(
    section: AxisSettings,
    model: AntennaModel,
    axis: str,
    task: TuningTask,
    cascade: LoopChoice,
    observed: LoopChoice | None,
    feeds_bodies: bool,
) -> Json:
    """Keys of one axis, rounded as people would write them."""
    inertia, scale = max(case.inertia_kg_m2 for case in task.cases), section.rate_loop.torque_per_unit_nm
    law = cascade_laws(cascade.numbers, task)[0]
    assert isinstance(law, CascadeLaw)
    position = min(law.position_kp, observed.numbers[0]) if observed else law.position_kp
    limit = min(section.limits.torque_nm, model.number(axis, "actuator.limit") or math.inf)
    corner = _rounded(min(_PREFILTER_SHARE * position, _QUICKEST_PREFILTER))
    acceleration = _ACCELERATION_SHARE * limit / inertia
    crossing = min(law.rate_kp / inertia, observed.numbers[1]) if observed else law.rate_kp / inertia
    unknown = acceleration * (WRONG_SHARE if feeds_bodies else 1.0)
    unknown += model.number(axis, "friction.breakaway") / inertia
    rate = _below(section.position_loop.rate_limit_rad_s, unknown / crossing)
    found: Json = {
        "position_loop.kp_per_s": law.position_kp,
        "position_loop.ki_per_s2": law.position_ki,
        "rate_loop.kp_s_per_rad": law.rate_kp / scale,
        "rate_loop.ki_per_rad": law.rate_ki / scale,
    }
    found = {key: _rounded(value) for key, value in found.items()}
    found["prefilter"] = {
        "num": corner,
        "den": [1.0, corner],
        "rate_rad_s": _rounded(min(rate, section.limits.rate_rad_s)),
        "acceleration_rad_s2": _rounded(acceleration),
    }
    if observed is not None:
        kp, crossing, bandwidth, corner = observed.numbers
        found["observer"] = {
            "bandwidth_rad_s": _rounded(bandwidth),
            "gusts_above_rad_s": _rounded(corner),
            "position_kp_per_s": _rounded(kp),
            "rate_kp_s_per_rad": _rounded(crossing * inertia / scale),
        }
    elif section.observer is not None:
        found["observer"] = None
    return {f"axes.{axis}.{key}": value for key, value in found.items()}


def _below(limit_rad_s: float, asked_rad_s: float) -> float:
    """Rate of a reference (rad/s) that leaves the position loop's limit what the loop asks for beyond the reference's
    slope: the acceleration that is not fed forward, over the crossing of the rate loop.
    """
    return limit_rad_s / (1.0 + asked_rad_s / limit_rad_s)


def _uncertain(model: AntennaModel, part: str) -> str:
    """Why a part of the model is too uncertain to be fed forward; empty where it is not."""
    for axis in model.axes:
        paths = (model.own_inertia_path(axis), "body.mass") if part == "bodies" else ("friction.coulomb",)
        for path in paths:
            value = model.number(axis, path)
            if value == 0.0 or model.uncertainty(axis, path) > _MOST_UNCERTAIN * abs(value):
                return f"{axis}.{path} may be off by more than {100 * _MOST_UNCERTAIN:.0f} %"
    return ""


def _rounded(value: float) -> float:
    return float(f"{value:.4g}")
