"""Stribeck bump: how high it is, at what speed it fades, and how sharply."""

from __future__ import annotations

from sim_backend.effects.effect import Domain, Effect, Parameter

EFFECT = Effect(
    name="stribeck",
    domain=Domain.FRICTION,
    parameters=(
        Parameter("breakaway", "N m", 0.0, 1e6, 0.0, "Ts, torque at break-away", linear_unit="N", path="friction.breakaway"),
        Parameter(
            "stribeck_velocity",
            "rad/s",
            1e-6,
            100.0,
            0.01,
            "v_s, where the bump has fallen to 37 %",
            linear_unit="m/s",
            path="friction.stribeck_velocity",
        ),
        Parameter("shape", "1", 0.2, 10.0, 1.0, "delta, exponent of the curve", path="friction.shape"),
    ),
    text="bump of the friction curve at low speed",
    equation="(Ts - Tc) exp(-(abs(v)/v_s)^delta)",
    source="thesis eq. 4.2 as corrected; Armstrong-Helouvry et al., Automatica 30 (1994)",
    excited_by="constant speeds below, at and above v_s, both directions",
)
