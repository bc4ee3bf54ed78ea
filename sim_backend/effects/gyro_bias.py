"""Gyro bias: the gyro reads a rate at rest."""

from __future__ import annotations

from sim_backend.effects.axis_scale import AxisScale, Need
from sim_backend.effects.effect import Domain, Effect, Variable
from sim_backend.effects.parameter import Parameter
from sim_backend.effects.search_profile import SearchProfile, one_knob
from sim_backend.effects.separating_runs import PLATEAUS


def _search(scale: AxisScale) -> SearchProfile:
    """A thousandth of a radian per second: 200 degrees per hour, an uncalibrated tactical gyro."""
    return one_knob("bias", 1e-3)


EFFECT = Effect(
    name="gyro_bias",
    domain=Domain.SENSOR,
    parameters=(
        Parameter("bias", "rad/s", -10.0, 10.0, 0.0, "added to the rate", linear_unit="m/s", path="gyro.bias"),
    ),
    text="rate read at rest",
    equation="rate + b",
    source="IEEE Std 952",
    excited_by="any run with encoder and gyro, standing still included",
    search=_search,
    acts_through=frozenset({Variable.TIME}),
    needs=Need.GYRO,
    separated_by=(PLATEAUS,),
)
