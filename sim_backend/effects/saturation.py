"""Saturation: the drive delivers no more than a limit."""

from __future__ import annotations

import math

from sim_backend.effects.axis_scale import AxisScale
from sim_backend.effects.effect import Domain, Effect, Variable
from sim_backend.effects.parameter import Parameter
from sim_backend.effects.search_profile import Knob, Move, SearchProfile, point

#: how far a limit stands above the largest command where it does nothing
_OUT_OF_REACH = 1.2
#: limits tried, as shares of the largest command: a loop that its motor cannot follow winds up to many times what it
#: gets, and from half or twice the limit a fit still finds it
_SHARES_OF_PEAK = (0.06, 0.1, 0.16, 0.25, 0.35, 0.5, 0.65, 0.8, 0.95)


def _search(scale: AxisScale) -> SearchProfile | None:
    """From above the largest command down: by shares of the samples and, for short peaks, by shares of the peak.

    Of a log that hardly ever asks for much, quantiles see the ordinary torque only.
    """
    peak, limit = scale.torque_peak, scale.numbers["actuator.limit"]
    if peak <= 0.0:
        return None
    reference = limit if 0.0 < limit < _OUT_OF_REACH * peak else _OUT_OF_REACH * peak
    # a level at the reference limits nothing
    levels = {min(max(level, 1e-9) / reference, 1.0) for level in scale.torque_levels}
    levels |= {share * peak / reference for share in _SHARES_OF_PEAK}
    starts = tuple(point(math.log(level)) for level in sorted(levels - {1.0}))
    return SearchProfile((Knob(("limit",), Move.LEVEL, reference, -4.0, 0.0),), starts)


EFFECT = Effect(
    name="saturation",
    domain=Domain.DRIVE,
    parameters=(
        Parameter(
            "limit", "N m", 0.0, 1e9, 0.0, "largest torque; 0 means none", linear_unit="N", path="actuator.limit"
        ),
    ),
    text="torque limited below what is commanded",
    equation="T = min(max(u, -limit), limit)",
    source="docs/explanation/reading-the-thesis.md: what the controller tables imply",
    excited_by="commands beyond the limit: large steps",
    search=_search,
    acts_through=frozenset({Variable.TORQUE}),
    unseen="the command stays below any limit that the data could show",
)
