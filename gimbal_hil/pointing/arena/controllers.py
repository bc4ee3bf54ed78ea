"""The controllers that the arena knows by name: each is a whole configuration, made from the shipped one."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from importlib.util import find_spec

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.errors import BadInputError
from firmware_protocol.json_object import Json
from gimbal_hil.knowledge.tuning import (
    MARGIN,
    Aim,
    LoopChoice,
    NoMarginError,
    PredictedJoint,
    SampledLaw,
    TuningTask,
    as_array,
    axis_inertias,
    figures,
    laws_of,
    loop_shaped,
    natural_of,
    notched,
    predicted_joint,
    regulated,
    tuned,
    tuning_task,
)
from gimbal_hil.loop.settings import DaemonSettings, settings_from_document, shipped_settings
from gimbal_hil.proof.thesis import LEVEL, POSITION_GAINS, RATE_GAINS
from sim_backend.model import CONTROL_ANTENNA, AntennaModel, model_named

Document = Json


def _thesis(document: Document) -> None:
    """Cascade PI with the thesis' gains and the drive gain that its tables imply; nothing is fed forward. Wide guards:
    it is judged by its errors.
    """
    _plain(document)
    for name, axis in document["axes"].items():
        (rate_kp, rate_ki), (position_kp, position_ki) = RATE_GAINS[name], POSITION_GAINS[name]
        axis["rate_loop"] |= {
            "kp_s_per_rad": rate_kp,
            "ki_per_rad": rate_ki,
            "torque_per_unit_nm": LEVEL.drive(name).per_unit_nm,
        }
        axis["position_loop"] |= {"kp_per_s": position_kp, "ki_per_s2": position_ki, "rate_limit_rad_s": 1000.0}
        axis["prefilter"] = None
        axis["limits"] |= {"rate_rad_s": 17.0, "following_position_rad": None, "following_rate_rad_s": None}


def _thesis_detuned(document: Document) -> None:
    """The thesis' cascade with its gains lowered together until its loops keep the margin of `tune` on the antenna of
    the model, with its delay, gyro and modes.
    """
    _thesis(document)
    share = _detuned_share()
    for axis in document["axes"].values():
        axis["rate_loop"]["kp_s_per_rad"] *= share
        axis["rate_loop"]["ki_per_rad"] *= share**2
        axis["position_loop"]["kp_per_s"] *= share
        axis["position_loop"]["ki_per_s2"] *= share**2


@cache
def _detuned_share() -> float:
    """Largest share of the thesis' crossing frequencies, in steps of a tenth of itself, that keeps the margin."""
    document = shipped_settings().model_dump(mode="json", by_alias=True)
    _thesis(document)
    thesis, model = settings_from_document(document, "thesis"), model_named(MODEL)
    share = 1.0
    while least_margin_on(thesis, model, share) < MARGIN:
        share *= 0.9
    return share


def least_margin_on(settings: DaemonSettings, model: AntennaModel, share: float = 1.0) -> float:
    """Least disk margin of both axes' loops on an antenna, all crossing frequencies of the cascade times a share; 0
    where they are not stable.
    """
    found = []
    for axis in model.axes:
        section = settings.axes[axis]
        position, rate = section.position_loop, section.rate_loop
        slower = section.model_copy(
            update={
                "position_loop": position.model_copy(
                    update={"kp_per_s": share * position.kp_per_s, "ki_per_s2": share**2 * position.ki_per_s2}
                ),
                "rate_loop": rate.model_copy(
                    update={"kp_s_per_rad": share * rate.kp_s_per_rad, "ki_per_rad": share**2 * rate.ki_per_rad}
                ),
            }
        )
        tried = settings.model_copy(update={"axes": {**settings.axes, axis: slower}})
        task = tuning_task(model, axis, settings.step_s, MARGIN)
        found.append(figures(laws_of(tried, model, axis, task), task).margin)
    return min(found)


def _plain(document: Document) -> None:
    """The shipped gains, prefilter and limits; nothing is fed forward but the reference's own slope."""
    for axis in document["axes"].values():
        axis["feedforward"] |= {"base_rate": False, "moment_kg_m": [0.0, 0.0, 0.0]}


def _shipped(document: Document) -> None:
    """The shipped configuration, config/virtual_antenna.yaml, as it is."""


def _with_model(document: Document, **parts: bool) -> None:
    """The shipped configuration with parts of the model, all others off."""
    off = dict.fromkeys(PARTS, False)
    document["model_control"] = {"model": MODEL, **off, **parts}


def _bodies(document: Document) -> None:
    """Shipped, with inertia, coupling, weight and base motion fed forward by the model's bodies."""
    _with_model(document, bodies=True)


def _friction(document: Document) -> None:
    """Shipped, with the model's friction fed forward."""
    _with_model(document, friction=True)


def _position(document: Document) -> None:
    """Shipped, with the torque over position that the model names fed forward: cogging."""
    _with_model(document, position_torque=True)


def _base(document: Document) -> None:
    """Shipped, with the base's motion extrapolated by its age."""
    _with_model(document, extrapolate_base=True)


def _observer(document: Document) -> None:
    """Shipped, with both loops closed by the observer, in place of gyro and integrators."""
    _with_model(document)
    for axis in document["axes"].values():
        axis["observer"] = {"bandwidth_rad_s": OBSERVER_RAD_S}


def _all(document: Document) -> None:
    """Shipped, with every part together."""
    _observer(document)
    _with_model(document, **dict.fromkeys(PARTS, True))


def _tuned_cascade(document: Document) -> None:
    """The cascade that gimbal-hil tune finds for the model, with its prefilter; nothing is fed forward."""
    _plain(document)
    for name, axis in document["axes"].items():
        for key, value in _tuned_keys(Aim.TRACKING)[name].items():
            if key != "observer":
                axis[key] = axis[key] | value


def _model_cascade(document: Document) -> None:
    """The tuned cascade with every part of the model and no observer."""
    _with_model(document, **dict.fromkeys(PARTS, True))
    for name, axis in document["axes"].items():
        for key, value in _tuned_keys(Aim.TRACKING)[name].items():
            if key != "observer":
                axis[key] = axis[key] | value


def _tuned(document: Document) -> None:
    """What gimbal-hil tune makes of the shipped configuration for the model: gains, observer, every part."""
    _tuned_for(Aim.TRACKING, document)


def _tuned_pointing(document: Document) -> None:
    """The same with gimbal-hil tune --for pointing."""
    _tuned_for(Aim.POINTING, document)


def _tuned_both(document: Document) -> None:
    """The same with gimbal-hil tune --for both."""
    _tuned_for(Aim.BOTH, document)


def _tuned_for(aim: Aim, document: Document) -> None:
    _with_model(document, **dict.fromkeys(PARTS, True))
    for name, axis in document["axes"].items():
        for key, value in _tuned_keys(aim)[name].items():
            axis[key] = (axis[key] or {}) | value


def _lqg(document: Document) -> None:
    """LQG with integral action: a quadratic regulator on the observer's estimates, whose disturbance is taken off;
    Riccati equations give both, the margin of tune chooses their weights. Every part of the model.
    """
    _with_model(document, **dict.fromkeys(PARTS, True))
    for name, axis in document["axes"].items():
        numbers, inertia = _chosen("lqg", name)
        axis["prefilter"] = axis["prefilter"] | _tuned_keys(Aim.TRACKING)[name]["prefilter"]
        axis["observer"] = {
            "position_kp_per_s": numbers[0],
            "rate_kp_s_per_rad": numbers[1] * inertia,
            "bandwidth_rad_s": numbers[2],
        }


def _mpc(document: Document) -> None:
    """Linear predictive control at the tick's rate: the weights and the observer of lqg, and a quadratic program that
    keeps to the limits of torque and rate over a quarter of a second, in place of the prefilter's. Every part of the
    model.
    """
    _lqg(document)
    document["model_control"]["watch"] = False
    for name, axis in document["axes"].items():
        limit, loop = axis["limits"]["torque_nm"], axis["position_loop"]
        _, inertia = _chosen("lqg", name)
        axis["prefilter"] |= {
            "num": _QUICK,
            "den": [1.0, _QUICK],
            "rate_rad_s": _NEARLY * loop["rate_limit_rad_s"],
            "acceleration_rad_s2": _NEARLY * limit / inertia,
        }


def _notch(document: Document) -> None:
    """The cascade with a notch at the resonance of every mode, tuned like the others. Every part of the model."""
    _with_a_law(document)


def _h_infinity(document: Document) -> None:
    """H-infinity loop shaping (McFarlane and Glover): the cascade's PI, and what makes it robust against coprime
    factors; tuned like the others. Every part of the model.
    """
    _with_a_law(document)


def _with_a_law(document: Document) -> None:
    """The model cascade whose loops ask for nothing: a law of its own closes them. The host, which does not see the
    law's torque, must not judge the model by what it sent.
    """
    _model_cascade(document)
    document["model_control"]["watch"] = False
    for axis in document["axes"].values():
        axis["position_loop"] |= {"kp_per_s": 0.0, "ki_per_s2": 0.0}
        axis["rate_loop"] |= {"kp_s_per_rad": 0.0, "ki_per_rad": 0.0}


def law_of(name: str) -> NDArray[np.float64] | tuple[PredictedJoint, ...] | None:
    """What closes a named controller's loops: a law as `run_law` takes it, or what is predicted of each joint; None
    where the configuration does.
    """
    if name == PREDICTIVE:
        numbers = [_chosen("lqg", axis)[0] for axis in model_named(MODEL).axes]
        step_s = shipped_settings().step_s
        return tuple(predicted_joint(natural_of(position, crossing), step_s) for position, crossing, *_ in numbers)
    if name not in LAWS:
        return None
    laws = [choice.laws[0] for axis in model_named(MODEL).axes for choice in [_choice(name, axis)]]
    return as_array([law for law in laws if isinstance(law, SampledLaw)])


def available() -> list[str]:
    """Names of the controllers whose libraries are installed."""
    return [name for name in CONTROLLERS if name != PREDICTIVE or find_spec("daqp") is not None]


def _chosen(name: str, axis: str) -> tuple[tuple[float, ...], float]:
    """Numbers of a design for an axis, and the inertia that they are of."""
    return _choice(name, axis).numbers, max(axis_inertias(model_named(MODEL), axis))


@cache
def _choice(name: str, axis: str) -> LoopChoice:
    model, step_s = model_named(MODEL), shipped_settings().step_s
    task = tuning_task(model, axis, step_s, MARGIN)
    found = LAWS[name](task) if name in LAWS else regulated(model, axis, task)
    if found is None:
        raise NoMarginError(axis, MARGIN)
    return found


def _levels(document: Document) -> None:
    """Tuned, with the levels of friction followed while it works."""
    _tuned(document)
    for axis in document["axes"].values():
        axis["friction_levels"] = {}


def _learned(document: Document) -> None:
    """Tuned, with a table over position and direction that is learned while it works."""
    _tuned(document)
    for axis in document["axes"].values():
        axis["learned"] = {}


@cache
def _tuned_keys(aim: Aim) -> dict[str, Document]:
    """By axis and section, what tuning changes in the shipped configuration."""
    found: dict[str, Document] = {}
    for key, value in tuned(shipped_settings(), model_named(MODEL), MODEL, MARGIN, aim).changes.items():
        words = key.split(".")
        if words[0] == "axes":
            section = found.setdefault(words[1], {}).setdefault(words[2], {})
            section |= {words[3]: value} if len(words) > 3 else value
    return found


#: whose numbers the controllers with a model take, on whatever antenna; and the bandwidth of their observers
MODEL, OBSERVER_RAD_S = CONTROL_ANTENNA, 150.0
#: what a model gives, each by its key
PARTS = ("bodies", "friction", "position_torque", "extrapolate_base")
#: the one that solves a program at every tick; corner (1/s) of its references, which are hardly smoothed, and the share
#: of the limits within which they stay
PREDICTIVE, _QUICK, _NEARLY = "mpc", 40.0, 0.95
#: designs whose law is none of the host's
LAWS: dict[str, Callable[[TuningTask], LoopChoice | None]] = {"notch": notched, "h_infinity": loop_shaped}
CONTROLLERS: dict[str, Callable[[Document], None]] = {
    "thesis": _thesis,
    "thesis_detuned": _thesis_detuned,
    "cascade": _plain,
    "tuned_cascade": _tuned_cascade,
    "shipped": _shipped,
    "bodies": _bodies,
    "friction": _friction,
    "position": _position,
    "base": _base,
    "observer": _observer,
    "all": _all,
    "model_cascade": _model_cascade,
    "tuned": _tuned,
    "tuned_pointing": _tuned_pointing,
    "tuned_both": _tuned_both,
    "lqg": _lqg,
    PREDICTIVE: _mpc,
    "notch": _notch,
    "h_infinity": _h_infinity,
    "levels": _levels,
    "learned": _learned,
}


def controller_settings(name: str) -> DaemonSettings:
    """The configuration of a named controller; BadInputError lists the names there are."""
    if name not in CONTROLLERS:
        raise BadInputError(
            "--controller", f"no controller {name!r}", ", ".join(CONTROLLERS) + ", or a configuration file"
        )
    document = shipped_settings().model_dump(mode="json", by_alias=True)
    CONTROLLERS[name](document)
    return settings_from_document(document, f"controller {name}")


def about(name: str) -> str:
    """What a named controller is, in one sentence or two."""
    return " ".join((CONTROLLERS[name].__doc__ or "").split())
