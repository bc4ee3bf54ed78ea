"""A formula as the skeleton of an effect of one's own: what `discrepancy --write-effect` writes."""

from __future__ import annotations

import re

from gimbal_hil.knowledge.discrepancy.laws.forms import NumberRole
from gimbal_hil.knowledge.discrepancy.laws.formula import Formula
from sim_backend.model import UNIT_OF, ActsOn, Over

_NAME = re.compile(r"[A-Za-z_]\w*")
_VARIABLES = {"position": "q", "rate": "v", "speed": "abs(v)", "load": "abs(torque)"}
_FUNCTIONS = {name: f"np.{name}" for name in ("sign", "sin", "cos", "exp", "tanh", "sqrt")}
#: of each place: hook, domain, arguments behind (P, o, X, s), what is returned with the law in it, and its type
_PLACES = {
    ActsOn.TORQUE: ("TORQUE", "DRIVE", "q: float, v: float, h: float", "{law}", "float"),
    ActsOn.COMMAND: ("COMMAND", "DRIVE", "K: np.ndarray, u: float, q: float, v: float", "u + {law}", "float"),
    ActsOn.FRICTION: (
        "FRICTION",
        "FRICTION",
        "q: float, v: float, torque: float, temperature: float, ts: float, tc: float, sigma2: float",
        "max(ts + more, 0.02 * ts), max(tc + more, 0.02 * tc), sigma2",
        "tuple[float, float, float]",
    ),
}
_THROUGH = {
    Over.POSITION: ("POSITION",),
    Over.TORQUE: ("TORQUE",),
    Over.LOAD: ("TORQUE", "RATE"),
    Over.TEMPERATURE: ("TEMPERATURE", "RATE"),
    Over.HANGS_BACK: ("PAST", "POSITION"),
}
_SKELETON = '''"""{phrase}, as measured by `gimbal-hil discrepancy`. Give it its name, its source and its bounds."""

import numpy as np

from firmware_protocol.compiling import compiled
from sim_backend.effects import Domain, Effect, Hook, Parameter, Variable


@compiled
def {name}_law(P: np.ndarray, o: int, X: np.ndarray, s: int, {arguments}) -> {type}:
    """{text}, {unit}."""
{body}


EFFECT = Effect(
    name="{name}",
    domain=Domain.{domain},
    hook=Hook.{hook},
    law={name}_law,
{states}    # neutral: it does nothing until a search or a model file gives it numbers
    parameters=(
{parameters}
    ),
    text="{phrase}",
    equation="{text}",
    source="measured; found by gimbal-hil discrepancy",
    excited_by="motion over {over}",
    acts_through=frozenset({{{through}}}),
)
'''


def effect_source(formula: Formula, name: str, is_linear: bool) -> str | None:
    """The Python of a plug-in that does what a formula does; None where what it is written over needs a memory that an
    effect here does not get.
    """
    shape, numbers = formula.shape, formula.numbers(is_linear)
    if Over.RECENT_SPEED in shape.over or shape.acts_on is ActsOn.ENCODER:
        return None
    hook, domain, arguments, returned, returns = _PLACES[shape.acts_on]
    law = _python(formula.text, list(numbers), "u" if shape.acts_on is ActsOn.COMMAND else "torque")
    friction = shape.acts_on is ActsOn.FRICTION
    lines = []
    if shape.over[0] is Over.HANGS_BACK:
        lines += _hanging_back(list(numbers))
    lines += [f"    more = {law}"] if friction else []
    lines.append("    return " + (returned if friction else returned.format(law=law)))
    through = _THROUGH.get(shape.over[0], ("RATE",)) + (("DIRECTION",) if shape.by_direction else ())
    return _SKELETON.format(
        phrase=formula.phrase,
        name=name,
        arguments=arguments,
        type=returns,
        text=formula.text,
        unit=UNIT_OF[shape.acts_on][is_linear],
        body="\n".join(lines),
        domain=domain,
        hook=hook,
        parameters="\n".join(_parameter(key, number, formula.roles.get(key)) for key, number in numbers.items()),
        states="    states=1,\n" if shape.over[0] is Over.HANGS_BACK else "",
        over=" and ".join(one.value.replace("_", " ") for one in shape.over),
        through=", ".join(f"Variable.{one}" for one in dict.fromkeys(through)),
    )


def _hanging_back(names: list[str]) -> list[str]:
    """Lines that keep in X[s] how far something hangs back."""
    slack, step = f"P[o + {names.index('slack')}]", "v * h"
    if "softness" in names:
        step += f" - abs(v) * h * np.sign(X[s]) * (abs(X[s]) / {slack}) ** (1.0 / P[o + {names.index('softness')}])"
    return [f"    X[s] = min(max(X[s] + {step}, -{slack}), {slack})"]


def _parameter(key: str, number: dict[str, object], role: NumberRole | None) -> str:
    """Bounds are a decade beyond what was measured; what scales is neutral at nothing, the rest where it was found."""
    value = float(str(number["value"]))
    reach = 10.0 * max(abs(value), 1e-6)
    low = -reach if role in (NumberRole.SCALE, NumberRole.PLACE) else 0.0
    neutral = 0.0 if role is NumberRole.SCALE else value
    return f'        Parameter("{key}", "{number["unit"]}", {low:.6g}, {reach:.6g}, {neutral!r}, "found: {value:.6g}"),'


def _python(text: str, names: list[str], torque: str) -> str:
    """A formula's text as Python over the law's arguments; its powers are whole, so both mean the same."""
    text = re.sub(r"hangs_back\([^)]*\)", "X[s]", text)
    text = re.sub(r"direction\(\w+\)", "np.sign(v)", text)

    def word(found: re.Match[str]) -> str:
        name = found[0]
        if name in names:
            return f"P[o + {names.index(name)}]"
        return {**_VARIABLES, **_FUNCTIONS, "torque": torque}.get(name, name)

    return "X[s]".join(_NAME.sub(word, part) for part in text.split("X[s]")).replace("np.np.", "np.").replace("^", "**")


__all__ = ["effect_source"]
