"""Forms that engineers write, of one variable: what stands in the formula, its numbers, and what it answers.

A form is a sum of scales times shapes; a shape has places on the variable, widths, and powers. Several forms make a
formula, each with a factor that says in which direction it holds.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import Enum

import numpy as np

from gimbal_hil.knowledge.discrepancy.laws.shape import LawShape
from gimbal_hil.knowledge.discrepancy.twin import Floats
from sim_backend.model import Over

#: variables that are never below zero
ONE_SIDED = (Over.SPEED, Over.LOAD, Over.RECENT_SPEED)
_WORD = re.compile(r"[a-z]\w*")
#: values of each variable at the same places
Points = tuple[Floats, ...]


class NumberRole(Enum):
    """What a number of a form does."""

    SCALE = "scale"
    #: a value of the variable, a length on it, or so many turns of a wave for each unit of it
    PLACE = "place"
    WIDTH = "width"
    WAVE = "wave"


@dataclass(frozen=True)
class FormNumber:
    """A number of a form; a scale is in the unit of what the law acts on, over so many units of the variable; any other
    is one of the first variable or of the second.
    """

    name: str
    role: NumberRole
    over: int = 0
    of: int = 0


@dataclass(frozen=True)
class Form:
    """One form: a phrase for it, its text over `x` (and `y`), its numbers, scales first, and what each scale
    multiplies.
    """

    phrase: str
    text: str
    numbers: tuple[FormNumber, ...]
    parts: Callable[..., tuple[Floats, ...]]
    #: None: of any variable; else only of those that are never below zero, or of those that may be
    one_sided: bool | None = None
    variables: int = 1

    @property
    def scales(self) -> int:
        """How many numbers scale it."""
        return sum(number.role is NumberRole.SCALE for number in self.numbers)

    @property
    def inner(self) -> tuple[FormNumber, ...]:
        """Numbers that do more than scale."""
        return self.numbers[self.scales :]


class Sense(Enum):
    """In which direction a form holds: the factor that stands before it, and what it is forward and backward."""

    EITHER = ("", 1.0, 1.0)
    OPPOSED = ("{direction} * ", 1.0, -1.0)
    FORWARD = ("max({direction}, 0) * ", 1.0, 0.0)
    BACKWARD = ("min({direction}, 0) * ", 0.0, -1.0)


@dataclass(frozen=True)
class FormTerm:
    """A form in a direction; `odd` is the form over the modulus of the variable, with the variable's sign."""

    form: Form
    sense: Sense = Sense.EITHER
    odd: bool = False

    def columns(self, points: Points, inner: Floats, by_direction: bool) -> Floats:
        """What each scale multiplies at points (n,) each, (n, scales); forward and then backward where that differs,
        (2 n, scales).
        """
        at = (np.abs(points[0]), *points[1:]) if self.odd else points
        parts = np.column_stack(self.form.parts(*at[: self.form.variables], *inner))
        if self.odd:
            parts = np.sign(points[0])[:, None] * parts
        _, forward, backward = self.sense.value
        return np.concatenate([forward * parts, backward * parts]) if by_direction else parts

    def text(self, variables: tuple[str, ...], direction: str, names: dict[str, str]) -> str:
        """As it stands in a formula, its numbers under other names."""
        variable = variables[0]
        said = _WORD.sub(lambda word: names.get(word[0], word[0]), self.form.text)
        factor: str = self.sense.value[0]
        before = factor.format(direction=direction)
        if self.odd:
            before, variable = f"sign({variable}) * ", "speed" if variable == "rate" else f"abs({variable})"
        grouped = f"({said})" if before and "+" in re.sub(r"\(.*?\)", "", said) else said
        said = before + re.sub(r"\bx\b", variable, grouped)
        return re.sub(r"\by\b", variables[-1], said)


def _scale(name: str, over: int = 0) -> FormNumber:
    return FormNumber(name, NumberRole.SCALE, over)


def _place(name: str) -> FormNumber:
    return FormNumber(name, NumberRole.PLACE)


_WIDTH = FormNumber("width", NumberRole.WIDTH)
_FREE = FormNumber("free", NumberRole.WIDTH)
_CENTRE = _place("centre")
LEVEL = Form("a level", "level", (_scale("level"),), lambda x: (np.ones_like(x),))
SLOPE = Form("a straight line", "slope * x", (_scale("slope", 1),), lambda x: (x,))


def _raised(deep: Floats, power: int) -> Floats:
    return np.asarray(deep**power)


def _powers(power: int) -> Iterator[Form]:
    """Whole powers, and those beyond an edge or two."""
    raised = "" if power == 1 else f"^{power}"
    name = {1: "a spring", 2: "a square", 3: "a cube"}[power]
    k = _scale("k", power)
    if power > 1:
        yield Form(name, f"k * x{raised}", (k,), lambda x: (_raised(x, power),), one_sided=True)
        yield Form(name, f"k * (x - centre){raised}", (k, _CENTRE), lambda x, c: (_raised(x - c, power),), False)
    for text, side in (("max(x - edge, 0)", 1.0), ("max(edge - x, 0)", -1.0)):
        yield Form(
            f"{name} beyond an edge",
            f"k * {text}{raised}",
            (k, _place("edge")),
            lambda x, edge, side=side: (_raised(np.maximum(side * (x - edge), 0.0), power),),
        )
    yield Form(
        f"nothing between two edges, {name} beyond",
        f"k * sign(x - centre) * max(abs(x - centre) - free, 0){raised}",
        (k, _CENTRE, _FREE),
        lambda x, c, free: (np.sign(x - c) * _raised(np.maximum(np.abs(x - c) - free, 0.0), power),),
        one_sided=False,
    )


def _hardening(x: Floats, centre: float, free: float) -> tuple[Floats, ...]:
    deep, side = np.maximum(np.abs(x - centre) - free, 0.0), np.sign(x - centre)
    return side * deep**2, side * deep**3


def _gauss(x: Floats, centre: float, width: float) -> Floats:
    return np.asarray(np.exp(-(((x - centre) / width) ** 2)))


_BELL = "exp(-((x - centre) / width)^2)"
FORMS: tuple[Form, ...] = (
    *(form for power in (1, 2, 3) for form in _powers(power)),
    Form(
        "nothing between two edges, harder and harder beyond",
        "sign(x - centre) * (k * max(abs(x - centre) - free, 0)^2 + h * max(abs(x - centre) - free, 0)^3)",
        (_scale("k", 2), _scale("h", 3), _CENTRE, _FREE),
        _hardening,
        one_sided=False,
    ),
    Form(
        "a saturation",
        "a * min(max((x - centre) / width, -1), 1)",
        (_scale("a"), _CENTRE, _WIDTH),
        lambda x, c, w: (np.clip((x - c) / w, -1.0, 1.0),),
        one_sided=False,
    ),
    Form("a saturation", "a * min(x / width, 1)", (_scale("a"), _WIDTH), lambda x, w: (np.minimum(x / w, 1.0),), True),
    Form(
        "a smooth saturation",
        "a * tanh((x - centre) / width)",
        (_scale("a"), _CENTRE, _WIDTH),
        lambda x, c, w: (np.tanh((x - c) / w),),
        one_sided=False,
    ),
    Form("a smooth saturation", "a * tanh(x / width)", (_scale("a"), _WIDTH), lambda x, w: (np.tanh(x / w),), True),
    Form("a slow saturation", "a * x / (x + width)", (_scale("a"), _WIDTH), lambda x, w: (x / (x + w),), True),
    Form("an exponential", "a * exp(-x / width)", (_scale("a"), _WIDTH), lambda x, w: (np.exp(-x / w),), True),
    Form(
        "a dip as Stribeck's",
        "a * exp(-(x / width)^2)",
        (_scale("a"), _WIDTH),
        lambda x, w: (np.exp(-((x / w) ** 2)),),
        True,
    ),
    Form("a bump", f"a * {_BELL}", (_scale("a"), _CENTRE, _WIDTH), lambda x, c, w: (_gauss(x, c, w),)),
    Form(
        "a detent",
        f"a * (x - centre) / width * {_BELL}",
        (_scale("a"), _CENTRE, _WIDTH),
        lambda x, c, w: ((x - c) / w * _gauss(x, c, w),),
        one_sided=False,
    ),
    Form(
        "a wave",
        "a * sin(order * x) + b * cos(order * x)",
        (_scale("a"), _scale("b"), FormNumber("order", NumberRole.WAVE)),
        lambda x, n: (np.sin(n * x), np.cos(n * x)),
    ),
)


Fade = tuple[str, str, Callable[[Floats, float], Floats]]
#: how what depends on one variable may fade or grow with another that is never negative, and turn with one that may be:
#: phrase, text, factor
_FADES: tuple[Fade, ...] = (
    ("grows with", "tanh(y / fade)", lambda y, w: np.tanh(y / w)),
    ("grows slowly with", "y / (y + fade)", lambda y, w: y / (y + w)),
    ("fades with", "exp(-y / fade)", lambda y, w: np.exp(-y / w)),
)
_TURNS: tuple[Fade, ...] = (
    ("turns with", "tanh(y / fade)", lambda y, w: np.tanh(y / w)),
    ("turns slowly with", "y / (abs(y) + fade)", lambda y, w: y / (np.abs(y) + w)),
    ("grows with positive", "max(tanh(y / fade), 0)", lambda y, w: np.maximum(np.tanh(y / w), 0.0)),
    ("grows with negative", "min(tanh(y / fade), 0)", lambda y, w: np.minimum(np.tanh(y / w), 0.0)),
)
_FADE = FormNumber("fade", NumberRole.WIDTH, of=1)


def _products(over: tuple[Over, ...]) -> Iterator[Form]:
    """Forms of the first variable times how they fade or grow with the second."""
    plain = [form for form in FORMS if form.one_sided in (None, over[0] in ONE_SIDED) and form.scales == 1]
    for form in (*plain, SLOPE):
        for says, text, factor in _FADES if over[1] in ONE_SIDED else _TURNS if over[1] is Over.RATE else ():
            yield Form(
                f"{form.phrase} that {says} {over[1].value.replace('_', ' ')}",
                f"{form.text} * {text}",
                (*form.numbers, _FADE),
                lambda x, y, *inner, form=form, factor=factor: tuple(
                    part * factor(y, inner[-1]) for part in form.parts(x, *inner[:-1])
                ),
                variables=2,
            )


def terms_of(shape: LawShape) -> tuple[FormTerm, ...]:
    """Every form that may stand in a formula of a shape."""
    if len(shape.over) == 2:
        return tuple(FormTerm(form) for form in _products(shape.over))
    over = shape.over[0]
    one_sided = over in ONE_SIDED
    plain = [form for form in FORMS if form.one_sided in (None, one_sided)]
    senses = tuple(Sense) if shape.by_direction else (Sense.EITHER,)
    if not shape.has_a_name_straight:
        plain.append(SLOPE)
    found = [FormTerm(form, sense) for form in plain for sense in senses]
    if over is Over.RATE:
        # the centre of what happens at a rate is standstill, or lies on both sides alike
        found = [term for term in found if not any(number.role is NumberRole.PLACE for number in term.form.inner)]
        found += [FormTerm(form, odd=True) for form in FORMS if form.one_sided is not False]
    if over is Over.TORQUE:
        found += [FormTerm(form, odd=True) for form in FORMS if form.one_sided is True]
    return tuple(found)


def beside(shape: LawShape) -> tuple[tuple[FormTerm, ...], ...]:
    """Plain parts that may stand beside a form: none, a level, a straight line."""
    senses = (Sense.EITHER, Sense.OPPOSED) if shape.by_direction else (Sense.EITHER,)
    level = tuple(FormTerm(LEVEL, sense) for sense in senses)
    if len(shape.over) == 2:
        return (), level
    if shape.over[0] is Over.RATE:
        return (), (FormTerm(SLOPE),), (FormTerm(SLOPE), *level, FormTerm(LEVEL, odd=True))
    if not shape.has_a_name_straight:
        return (), level
    return (), level, (*level, *(FormTerm(SLOPE, sense) for sense in senses))


def renamed(terms: tuple[FormTerm, ...]) -> tuple[dict[str, str], ...]:
    """Names of the numbers of each term, different from those of all others."""
    met: dict[str, int] = {}
    found = []
    for term in terms:
        names = {}
        for number in term.form.numbers:
            met[number.name] = met.get(number.name, 0) + 1
            names[number.name] = number.name if met[number.name] == 1 else f"{number.name}_{met[number.name]}"
        found.append(names)
    return tuple(found)


__all__ = [
    "FORMS",
    "LEVEL",
    "ONE_SIDED",
    "SLOPE",
    "Form",
    "FormNumber",
    "FormTerm",
    "NumberRole",
    "Sense",
    "beside",
    "renamed",
]
