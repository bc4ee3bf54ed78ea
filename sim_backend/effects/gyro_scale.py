"""Gyro scale error: the gyro reads a rate in proportion too large or too small."""

from __future__ import annotations

from sim_backend.effects.axis_scale import AxisScale, Need
from sim_backend.effects.effect import Domain, Effect, Variable
from sim_backend.effects.parameter import Parameter
from sim_backend.effects.search_profile import SearchProfile, one_knob
from sim_backend.effects.separating_runs import PLATEAUS, TWO_SPEEDS


def _search(scale: AxisScale) -> SearchProfile:
    """Half a per cent is a usual scale error; nobody mounts a gyro that reads half or double."""
    return one_knob("scale_error", 5e-3, -90.0, 90.0)


EFFECT = Effect(
    name="gyro_scale",
    domain=Domain.SENSOR,
    parameters=(Parameter("scale_error", "1", -0.5, 0.5, 0.0, "s in (1 + s) rate", path="gyro.scale_error"),),
    text="scale factor error",
    equation="(1 + s) rate",
    source="IEEE Std 952",
    excited_by="constant speeds in both directions with encoder and gyro",
    search=_search,
    acts_through=frozenset({Variable.RATE, Variable.BASE_MOTION}),
    needs=Need.GYRO,
    separated_by=(PLATEAUS, TWO_SPEEDS),
)
