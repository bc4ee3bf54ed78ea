"""Actuator lag: torque follows its command with a first-order delay."""

from __future__ import annotations

from sim_backend.effects.effect import Domain, Effect, Parameter

EFFECT = Effect(
    name="actuator_lag",
    domain=Domain.TIMING,
    parameters=(Parameter("time_constant", "s", 0.0, 1.0, 0.0, "of the first-order lag; 0 means none", path="actuator.time_constant"),),
    text="first-order lag of the torque",
    equation="tau T' + T = u",
    source="current loop of the drive, closed-loop bandwidth 1/tau",
    excited_by="chirp or pulses of torque beyond 1/(10 tau)",
)
