"""A search profile from nothing but an effect's parameters: so that an effect is searched before anyone has written
one.

Strengths are the parameters that carry a torque, a mass or a share and are neutral at zero; they are probed from there.
All others only shape what a strength does, and at a strength of zero they do nothing: they are tried on a grid over
what the axis does in the data. Sizes come from the units. An effect whose law says more about where to look is better
off with a profile of its own.
"""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Sequence

import numpy as np

from sim_backend.effects.axis_scale import AxisScale
from sim_backend.effects.parameter import Parameter
from sim_backend.effects.search_profile import Knob, Move, Reading, SearchProfile, Start, Vector

#: most starts of a grid, and most along one parameter; a width takes few, since a place is found with a wrong one
_MOST_STARTS, _MOST_ALONG, _MOST_WIDTHS = 48, 12, 4
#: a strength moves by this share of what its unit amounts to on the axis
_SHARE = 0.05
#: a shape whose bounds are this far apart (both positive) moves by factors
_DECADE = 10.0
#: and spans this much of the travel or the speed at least
_LEAST_SPAN = 0.02
#: seconds, hertz and kelvin to count in where nothing in the data has that unit
_SECONDS, _HERTZ, _KELVIN = 1e-3, 1.0, 1.0


def default_profile(parameters: Sequence[Parameter], scale: AxisScale) -> SearchProfile | None:
    """Knobs and starts for an effect of these parameters on an axis; None where nothing of it can be off neutral."""
    first = strengths(parameters)
    if not first:
        return None
    shapes = sorted((p for p in parameters if p not in first), key=lambda p: p.periodic)
    knobs = (*(_strength_knob(p, scale) for p in first), *(_shape_knob(p) for p in shapes))
    grids = _grids(shapes, scale)
    angle = len(first) == 1 and len(shapes) > 0 and shapes[-1].periodic
    starts = tuple(_start(len(first), at, angle) for at in itertools.product(*grids))
    return SearchProfile(knobs, starts)


def strengths(parameters: Sequence[Parameter]) -> list[Parameter]:
    """The parameters of an effect that carry what it does: with all of them where they are neutral nothing is left."""
    if all(p.path is not None for p in parameters):
        # numbers that the model has anyway: each moves from where it stands
        return sorted(parameters, key=lambda p: p.periodic)
    neutral_at_zero = [p for p in parameters if p.neutral == 0.0 and not p.periodic]
    return [p for p in neutral_at_zero if _is_strength(p)] or neutral_at_zero[:1]


def unit_scale(unit: str, scale: AxisScale) -> float:
    """What one of a unit (e.g. "N m s2/rad2") amounts to on an axis: torque, place, rate and inertia as they are in the
    data.
    """
    place = max(0.5 * max(abs(scale.position_low), abs(scale.position_high)), 1e-9)
    second = place / scale.speed
    if unit == "s":
        return _SECONDS
    if re.match(r"kg\b", unit):
        # a moment is the joint's own; a mass beside a moment is the body's
        return scale.own_inertia if scale.is_linear or unit != "kg" else max(scale.numbers["body.mass"], 1e-9)
    length = place if scale.is_linear else 1.0
    known = {"N": scale.torque_rms, "m": length, "rad": place, "s": second, "K": _KELVIN, "Hz": _HERTZ}
    over, _, under = unit.partition("/")
    return _product(over, known) / _product(under, known)


def _product(units: str, known: dict[str, float]) -> float:
    found = 1.0
    for name, power in re.findall(r"([A-Za-z]+)(\d*)", units):
        found *= known.get(name, 1.0) ** int(power or 1)
    return found


def _is_strength(p: Parameter) -> bool:
    """Whether what is neutral at zero carries what the effect does: a torque, a mass or a share."""
    return p.unit == "1" or re.match(r"(N|kg)\b", p.unit) is not None


def _unit(p: Parameter, scale: AxisScale) -> str:
    return p.linear_unit if scale.is_linear and p.linear_unit else p.unit


def _strength_knob(p: Parameter, scale: AxisScale) -> Knob:
    base = scale.numbers[p.path] if p.path is not None else 0.0
    return Knob((p.name,), size=_SHARE * (abs(base) or unit_scale(_unit(p, scale), scale)))


def _shape_knob(p: Parameter) -> Knob:
    if p.periodic:
        return Knob((p.name,))
    if _by_factors(p):
        return Knob((p.name,), Move.FACTOR)
    return Knob(
        (p.name,),
        size=max(_SHARE * (p.high - p.low), 1e-12) if p.neutral == 0.0 else max(_SHARE * abs(p.neutral), 1e-12),
    )


def _by_factors(p: Parameter) -> bool:
    return p.low > 0.0 and p.neutral > 0.0 and p.high >= _DECADE * p.low


def _grids(shapes: Sequence[Parameter], scale: AxisScale) -> list[Vector]:
    """Coordinates along every shape at which starts stand."""
    widths = [p for p in shapes if not p.periodic and _by_factors(p)]
    places = [p for p in shapes if not p.periodic and not _by_factors(p)]
    wide = _each(_MOST_STARTS, len(widths) + len(places), _MOST_WIDTHS if places else _MOST_ALONG)
    many = _each(_MOST_STARTS / wide ** len(widths), len(places), _MOST_ALONG)
    return [(0.0,) if p.periodic else _along(p, wide if p in widths else many, scale) for p in shapes]


def _each(total: float, parameters: int, most: int) -> int:
    """Points along each of so many parameters whose grid has `total` points at most."""
    return min(most, max(2, int(total ** (1.0 / parameters) + 1e-9))) if parameters else 1


def _along(p: Parameter, many: int, scale: AxisScale) -> Vector:
    """Coordinates of values spread over what the axis does, within the parameter's bounds; none at an end, where
    nothing is known.
    """
    low, high = _span(p, scale)
    share = (np.arange(many) + 0.5) / many
    if _by_factors(p):
        return tuple(float(math.log(low / p.neutral) + s * math.log(high / low)) for s in share)
    return tuple(float((low + s * (high - low) - p.neutral) / _shape_knob(p).size) for s in share)


def _span(p: Parameter, scale: AxisScale) -> Vector:
    low, high = p.low, p.high
    unit = _unit(p, scale)
    reach = max(abs(scale.position_low), abs(scale.position_high))
    if unit == ("m" if scale.is_linear else "rad"):
        wide = (_LEAST_SPAN * scale.travel, scale.travel) if p.low > 0.0 else (0.0, reach)
        low, high = (
            (max(low, scale.position_low), min(high, scale.position_high))
            if p.low < 0.0
            else (max(low, wide[0]), min(high, wide[1]))
        )
    elif unit == ("m/s" if scale.is_linear else "rad/s"):
        low, high = max(low, -scale.speed if p.low < 0.0 else _LEAST_SPAN * scale.speed), min(high, scale.speed)
    return (low, high) if low < high else (p.low, p.high)


def _start(strengths: int, shape: Vector, angle: bool) -> Start:
    """From a strength of zero along every strength, shaped as given; an only strength with an angle is read in both its
    quarters.
    """
    base = ((0.0,) * strengths) + shape
    if angle:
        return Start(((1.0, *shape), (1.0, *shape[:-1], 0.5 * math.pi)), base, Reading.POLAR)
    ones = (tuple(1.0 if i == j else 0.0 for j in range(strengths)) for i in range(strengths))
    return Start(tuple((*one, *shape) for one in ones), base)
