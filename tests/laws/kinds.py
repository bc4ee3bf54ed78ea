"""Laws that no catalogue has, hidden in the second antenna, and over what each may rightly be told."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.random import Generator

from tests.blind.causes import Cause, outside

#: what a law acts on and is written over, and whether by direction
Told = tuple[str, tuple[str, ...], bool]
_OVER_POSITION: Told = ("torque", ("position",), False)


#: what a law truly adds at values of its variable, by the numbers of its row and whatever its centre is called
Truth = Callable[[dict[str, float], np.ndarray], np.ndarray]


@dataclass(frozen=True)
class HiddenLaw:
    """A kind of law: which cause of the second antenna, what describes it, and the phrases of its form."""

    name: str
    right: tuple[Told, ...]
    forms: tuple[str, ...] = ()
    #: over the first of `right`; where that opposes the motion, what it takes
    truth: Truth | None = None


def _bell(x: np.ndarray, centre: float, width: float) -> np.ndarray:
    return np.asarray(np.exp(-0.5 * ((x - centre) / width) ** 2))


def _stop(row: dict[str, float], q: np.ndarray) -> np.ndarray:
    deep = np.maximum(np.abs(q - row["stop_q"]) - row["stop_w"], 0.0) / 0.1
    return np.asarray(-np.sign(q - row["stop_q"]) * 0.1 * row["stop_k"] * (deep**2 + deep**3))


def _detent(row: dict[str, float], q: np.ndarray) -> np.ndarray:
    u = (q - row["detent_q"]) / row["detent_w"]
    return np.asarray(-row["detent_a"] * u * np.exp(0.5 - 0.5 * u**2))


def _friction(*over: str) -> tuple[Told, ...]:
    """A law that opposes the motion, as friction or as torque of which the direction is known."""
    plain = (("friction", over, False), ("torque", over, True))
    return (*plain, ("torque", ("rate",), False)) if over == ("speed",) else plain


KINDS = {
    kind.name: kind
    for kind in (
        HiddenLaw("hardening_stop", (_OVER_POSITION,), ("nothing between two edges, harder and harder beyond",), _stop),
        HiddenLaw("cubic_spring", (_OVER_POSITION,), ("a cube",), lambda row, q: -row["cubic_k"] * q**3),
        HiddenLaw(
            "spring_beyond_an_edge",
            (_OVER_POSITION,),
            ("a spring beyond an edge",),
            lambda row, q: -row["edge_k"] * np.maximum(q - row["edge_q"], 0.0),
        ),
        HiddenLaw(
            "position_bump",
            (_OVER_POSITION,),
            ("a bump",),
            lambda row, q: row["bump_a"] * _bell(q, row["bump_q"], row["bump_w"]),
        ),
        HiddenLaw("detent", (_OVER_POSITION,), ("a detent",), _detent),
        # it grows from nothing with the rate, over 0.02 rad/s
        HiddenLaw(
            "cable_snag",
            (
                *_friction("position"),
                ("friction", ("position", "speed"), False),
                ("torque", ("position", "rate"), False),
            ),
            ("a bump", "a bump that grows with speed", "a bump that turns with rate"),
        ),
        # the same forward only
        HiddenLaw(
            "one_way_snag",
            (("torque", ("position",), True), ("torque", ("position", "rate"), False)),
            ("a bump", "a bump that grows with positive rate"),
        ),
        HiddenLaw(
            "saturating_drag",
            _friction("speed"),
            ("an exponential",),
            lambda row, v: row["fast_a"] * (1.0 - np.exp(-v / row["fast_v"])),
        ),
        HiddenLaw(
            "tight_at_a_speed",
            _friction("speed"),
            ("a bump",),
            lambda row, v: row["hump_a"] * _bell(v, row["hump_v"], 0.3 * row["hump_v"]),
        ),
        HiddenLaw("cubic_drag", _friction("speed"), ("a cube",), lambda row, v: row["cube"] * v**3),
        HiddenLaw(
            "torque_dead_zone",
            (("command", ("torque",), False),),
            ("a saturation",),
            lambda row, u: -np.clip(u, -row["dead"], row["dead"]),
        ),
        HiddenLaw("hysteretic_cable", (("torque", ("hangs_back",), False),), ("a straight line", "")),
        HiddenLaw("elastic_hysteresis", (("torque", ("hangs_back",), False),), ("a straight line", "")),
        # a viscous torque, beside the bristles
        HiddenLaw(
            "worked_grease",
            (("friction", ("speed", "recent_speed"), False), ("torque", ("rate", "recent_speed"), False)),
        ),
    )
}


def laws(rng: Generator, axis: str) -> list[Cause]:
    """Every kind on an axis, shapes drawn."""
    centre = 0.0 if axis == "outer" else 0.4

    def strange(name: str, scaled: str, size: float, **shape: float) -> Cause:
        return Cause(name, axis, {scaled: size} | shape, scaled=(scaled,), inside=False)

    drawn = [
        strange("cubic_spring", "cubic_k", 0.2),
        strange("spring_beyond_an_edge", "edge_k", 0.2, edge_q=centre + float(rng.uniform(-0.1, 0.2))),
        strange(
            "detent",
            "detent_a",
            0.1,
            detent_q=centre + float(rng.uniform(-0.2, 0.2)),
            detent_w=float(rng.uniform(0.03, 0.1)),
        ),
        strange(
            "one_way_snag",
            "snag_a",
            0.1,
            snag_q=centre + float(rng.uniform(-0.2, 0.2)),
            snag_w=float(rng.uniform(0.03, 0.08)),
            snag_one_way=1.0,
        ),
        strange("saturating_drag", "fast_a", 0.1, fast_v=float(np.exp(rng.uniform(np.log(0.05), np.log(0.4))))),
        strange("tight_at_a_speed", "hump_a", 0.1, hump_v=float(rng.uniform(0.15, 0.5))),
        strange("cubic_drag", "cube", 0.05),
    ]
    known = {cause.name for cause in drawn}
    return [*drawn, *(cause for cause in outside(rng, axis) if cause.name in KINDS and cause.name not in known)]
