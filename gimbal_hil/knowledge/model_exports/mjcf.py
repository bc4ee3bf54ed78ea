"""A model as MJCF, MuJoCo's own format, with MuJoCo's own laws.

LuGre friction and ripples are passive `dcmotor` actuators, which MuJoCo has since 3.7; for an older one dry friction is
`frictionloss`. Source: MuJoCo's XML reference, elements joint, general and dcmotor.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from gimbal_hil.knowledge.model_exports.account import Account, ExportedModel
from gimbal_hil.knowledge.model_exports.bodies import body_of, direction_of, gravity_of
from gimbal_hil.knowledge.model_exports.stribeck import nearest_velocity
from sim_backend.model import ENDLESS, AntennaModel, EffectEntry, ModelKind

_BODY = ("mass", "cog.x", "cog.y", "cog.z", *(f"inertia.{k}" for k in ("xx", "yy", "zz", "xy", "xz", "yz")))
_NO_LAW = "MuJoCo has no law for it"
_SENSOR = "sensors of MuJoCo are exact; add it to what you read"
_REASONS = {
    "encoder.step": _SENSOR,
    "encoder.noise": _SENSOR,
    "encoder_eccentricity": _SENSOR,
    "gyro.step": _SENSOR,
    "gyro.noise": _SENSOR,
    "gyro.bias": _SENSOR,
    "gyro.scale_error": _SENSOR,
    "gyro.bandwidth": _SENSOR,
    "gyro.damping": _SENSOR,
    "gyro_misalignment": _SENSOR,
    "actuator.measurement_noise": _SENSOR,
    "actuator.torque_constant": "the control is a torque, not a current",
    "travel.low": "the model has no stop there, the drive keeps to it",
    "travel.high": "the model has no stop there, the drive keeps to it",
    "backlash": "a gap needs a contact between two bodies of your own",
    "structural_resonance": "too large a share hangs on the spring: the rest would be no possible body",
}


@dataclass
class _Axis:
    """XML of one axis while it is put together."""

    joint: dict[str, str] = field(default_factory=dict)
    drive: dict[str, str] = field(default_factory=dict)
    passive: list[dict[str, str]] = field(default_factory=list)
    #: a part of the body on a spring of its own: moments (3,) in kg m2, stiffness, damping
    hung: tuple[NDArray[np.float64], float, float] | None = None
    held: set[str] = field(default_factory=set)
    nearly: dict[str, str] = field(default_factory=dict)


def mjcf_of(model: AntennaModel, dcmotor: bool = True) -> ExportedModel:
    """A whole MJCF file: bodies, joints named like the axes, a torque control for each; `dcmotor` false for a MuJoCo
    that lacks that element.
    """
    held: set[tuple[str, str]] = set()
    nearly: dict[tuple[str, str], str] = {}
    parts: dict[str, _Axis] = {}
    for axis in model.axes:
        one = parts[axis] = _axis(model, axis, dcmotor)
        held |= {(axis, name) for name in one.held}
        nearly |= {(axis, name): how for name, how in one.nearly.items()}
    chain = ""
    for axis in reversed(model.axes):
        chain = _body(model, axis, parts[axis], chain)
    actuators = "".join(
        _element("general", one.drive) + "".join(_element("dcmotor", more) for more in one.passive)
        for one in parts.values()
    )
    sensors = "".join(
        _element("jointpos", {"name": f"{axis}.position", "joint": axis})
        + _element(
            "gyro" if model.kind is not ModelKind.LINEAR else "velocimeter", {"name": f"{axis}.gyro", "site": axis}
        )
        for axis in model.axes
    )
    text = (
        f"<mujoco model={quoteattr(model.name)}>\n"
        '  <compiler angle="radian" balanceinertia="false" boundmass="0" boundinertia="0"/>\n'
        f'  <option timestep="{model.file.plant_step_s:.17g}" gravity="{gravity_of(model)}"/>\n'
        f"  <worldbody>\n{chain}  </worldbody>\n  <actuator>\n{actuators}  </actuator>\n"
        f"  <sensor>\n{sensors}  </sensor>\n</mujoco>\n"
    )
    return Account(frozenset(held), nearly, _REASONS, _NO_LAW).settle(model, text)


def _axis(model: AntennaModel, axis: str, dcmotor: bool) -> _Axis:
    one = _Axis()
    one.held |= {f"body.{name}" for name in _BODY}
    one.joint = {
        "name": axis,
        "type": "slide" if model.kind is ModelKind.LINEAR else "hinge",
        "axis": direction_of(model, axis),
    }
    _travel(model, axis, one)
    _drive(model, axis, one)
    _friction(model, axis, one, dcmotor)
    for entry in (entry for entry in model.effects if entry.axis == axis):
        _effect(model, entry, one, dcmotor)
    return one


def _travel(model: AntennaModel, axis: str, one: _Axis) -> None:
    low, high = model.number(axis, "travel.low"), model.number(axis, "travel.high")
    if low > -ENDLESS and high < ENDLESS and model.number(axis, "travel.stiffness") > 0.0:
        one.joint["range"] = f"{low:.17g} {high:.17g}"
        stiffness, damping = model.number(axis, "travel.stiffness"), model.number(axis, "travel.damping")
        # negative numbers of solref are stiffness and damping themselves
        one.joint["solreflimit"] = f"{-stiffness:.17g} {-max(damping, 1e-9):.17g}"
        one.held |= {"travel.low", "travel.high"}
        one.nearly |= dict.fromkeys(("travel.stiffness", "travel.damping"), "a soft constraint of the same stiffness")


def _drive(model: AntennaModel, axis: str, one: _Axis) -> None:
    gain = 1.0 + model.number(axis, "actuator.gain_error")
    offset, lag, limit = (model.number(axis, f"actuator.{k}") for k in ("offset", "time_constant", "limit"))
    one.drive = {"name": axis, "joint": axis, "gaintype": "fixed", "gainprm": f"{gain:.17g}"}
    if offset:
        one.drive |= {"biastype": "affine", "biasprm": f"{offset:.17g} 0 0"}
    if lag:
        one.drive |= {"dyntype": "filterexact", "dynprm": f"{lag:.17g}"}
    if limit:
        one.drive |= {"forcerange": f"{-limit:.17g} {limit:.17g}"}
    one.held |= {f"actuator.{k}" for k in ("gain_error", "offset", "time_constant", "limit")}


def _friction(model: AntennaModel, axis: str, one: _Axis, dcmotor: bool) -> None:
    number = {
        k: model.number(axis, f"friction.{k}")
        for k in ("coulomb", "breakaway", "stribeck_velocity", "shape", "sigma0", "sigma1", "viscous")
    }
    one.joint["damping"] = f"{number['viscous']:.17g}"
    one.held |= {"friction.viscous", "friction.coulomb"}
    if dcmotor and number["sigma0"] > 0.0 and number["coulomb"] > 0.0:
        speed = nearest_velocity(number["stribeck_velocity"], number["shape"])
        five = (number["sigma0"], number["sigma1"], number["coulomb"], number["breakaway"], speed)
        one.passive.append(_passive(axis, f"{axis}.friction", lugre=" ".join(f"{x:.17g}" for x in five)))
        one.held |= {"friction.sigma0", "friction.sigma1", "friction.breakaway"}
        if number["shape"] == 2.0:
            one.held |= {"friction.stribeck_velocity", "friction.shape"}
        else:
            how = f"the nearest bump of shape 2, at {speed:.4g} in place of {number['stribeck_velocity']:.4g}"
            one.nearly |= dict.fromkeys(("friction.stribeck_velocity", "friction.shape"), how)
        return
    one.joint["frictionloss"] = f"{number['coulomb']:.17g}"
    # the default of MuJoCo lets a joint creep for tens of milliseconds
    one.joint["solreffriction"] = f"{max(2.0 * model.file.plant_step_s, 1e-4):.17g} 1"


def _effect(model: AntennaModel, entry: EffectEntry, one: _Axis, dcmotor: bool) -> None:
    name, step_s = entry.effect.name, model.file.plant_step_s
    if name == "cogging" and dcmotor:
        three = f"{entry.value('amplitude'):.17g} {entry.value('order'):.17g} {entry.value('phase'):.17g}"
        one.passive.append(_passive(entry.axis, f"{entry.axis}.cogging{len(one.passive)}", cogging=three))
    elif name == "cable_spring":
        one.joint |= {
            "stiffness": f"{entry.value('stiffness'):.17g}",
            "springref": f"{entry.value('rest_position'):.17g}",
        }
        if entry.value("hysteresis"):
            one.nearly[name] = "the spring without its hysteresis"
    elif name == "quadratic_drag":
        one.joint["damping"] += f" {entry.value('coefficient'):.17g}"
    elif name == "back_emf":
        bias = one.drive.get("biasprm", "0 0 0").split()
        one.drive |= {"biastype": "affine", "biasprm": f"{bias[0]} 0 {-entry.value('coefficient'):.17g}"}
        if "dyntype" in one.drive:
            one.nearly[name] = "behind the lag, not before it"
    elif name == "structural_resonance":
        one.hung = _hung(model, entry)
        if one.hung is None:
            return
        one.nearly[name] = "a body on a spring, with the inertia of the zero position"
    elif name == "transport_delay":
        steps = max(1, round(entry.value("delay") / step_s))
        one.drive |= {"delay": f"{steps * step_s:.17g}", "nsample": str(steps)}
        if not math.isclose(steps * step_s, entry.value("delay"), rel_tol=1e-9):
            one.nearly[name] = f"{steps} steps of {step_s:g} s"
    else:
        return
    if name not in one.nearly:
        one.held.add(name)


def _hung(model: AntennaModel, entry: EffectEntry) -> tuple[NDArray[np.float64], float, float] | None:
    """Moments, stiffness and damping of the part that hangs on a spring; None where no body would be left."""
    carried = model.axes[model.axes.index(entry.axis) + 1 :]
    whole = model.number(entry.axis, model.own_inertia_path(entry.axis)) + sum(
        model.number(axis, "body.inertia.zz") for axis in carried
    )
    part = entry.value("inertia_share") * whole
    turning = 2.0 * math.pi * entry.value("antiresonance_frequency")
    along = np.array([float(x) for x in direction_of(model, entry.axis).split()])
    # flat, like a disc: the least that a body with this moment has about the two other axes
    moments = part * (0.5 + 0.5 * along)
    left = np.linalg.eigvalsh(body_of(model, entry.axis).tensor_kg_m2 - np.diag(moments))
    if model.kind is ModelKind.LINEAR or left[0] <= 0.0 or left[0] + left[1] < left[2]:
        return None
    return moments, part * turning**2, 2.0 * entry.value("damping_ratio") * part * turning


def _passive(axis: str, name: str, **law: str) -> dict[str, str]:
    return {"name": name, "joint": axis, "input": "none", "motorconst": "0 0", "resistance": "1", **law}


def _body(model: AntennaModel, axis: str, one: _Axis, inner: str) -> str:
    body = body_of(model, axis)
    hung = ""
    if one.hung is not None:
        moments, stiffness, damping = one.hung
        body = replace(body, tensor_kg_m2=body.tensor_kg_m2 - np.diag(moments))
        spring = {"name": f"{axis}.twist", "type": "hinge", "axis": direction_of(model, axis)}
        spring |= {"stiffness": f"{stiffness:.17g}", "damping": f"{damping:.17g}"}
        part = {"pos": "0 0 0", "mass": "1e-9", "diaginertia": " ".join(f"{x:.17g}" for x in moments)}
        name = quoteattr(f"{axis}.hung")
        hung = f"    <body name={name}>\n{_element('joint', spring)}{_element('inertial', part)}    </body>\n"
    inertial = {
        "pos": " ".join(f"{x:.17g}" for x in body.cog_m),
        "mass": f"{body.mass_kg:.17g}",
        "fullinertia": " ".join(f"{x:.17g}" for x in body.six),
    }
    return (
        f"    <body name={quoteattr(axis)}>\n{_element('joint', one.joint)}{_element('inertial', inertial)}"
        f"{_element('site', {'name': axis})}{hung}{inner}    </body>\n"
    )


def _element(name: str, attributes: dict[str, str]) -> str:
    return f"    <{name} " + " ".join(f"{key}={quoteattr(value)}" for key, value in attributes.items()) + "/>\n"
