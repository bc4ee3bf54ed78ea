"""Laws that no catalogue has, hidden in the second antenna, and over what each may rightly be told."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.random import Generator

from tests.blind.causes import Cause, outside

#: what a law acts on and is written over, and whether by direction
Told = tuple[str, tuple[str, ...], bool]
_OVER_POSITION: Told = ("torque", ("position",), False)


@dataclass(frozen=True)
class HiddenLaw:
    """A kind of law: which cause of the second antenna, and what describes it."""

    name: str
    right: tuple[Told, ...]


def _friction(*over: str) -> tuple[Told, ...]:
    """A law that opposes the motion, as friction or as torque of which the direction is known."""
    plain = (("friction", over, False), ("torque", over, True))
    return (*plain, ("torque", ("rate",), False)) if over == ("speed",) else plain


KINDS = {
    kind.name: kind
    for kind in (
        HiddenLaw("hardening_stop", (_OVER_POSITION,)),
        HiddenLaw("cubic_spring", (_OVER_POSITION,)),
        HiddenLaw("spring_beyond_an_edge", (_OVER_POSITION,)),
        HiddenLaw("position_bump", (_OVER_POSITION,)),
        HiddenLaw("detent", (_OVER_POSITION,)),
        HiddenLaw("cable_snag", _friction("position")),
        HiddenLaw("one_way_snag", (("torque", ("position",), True),)),
        HiddenLaw("saturating_drag", _friction("speed")),
        HiddenLaw("tight_at_a_speed", _friction("speed")),
        HiddenLaw("cubic_drag", _friction("speed")),
        HiddenLaw("torque_dead_zone", (("command", ("torque",), False),)),
        HiddenLaw("hysteretic_cable", (("torque", ("hangs_back",), False),)),
        HiddenLaw("elastic_hysteresis", (("torque", ("hangs_back",), False),)),
        HiddenLaw("worked_grease", (("friction", ("speed", "recent_speed"), False),)),
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
