"""From a model file to the linear axes that loops have to be stable on: each in its inertias, sliding and stuck."""

from __future__ import annotations

import math

import numpy as np

from firmware_protocol.compiling import interpreted
from gimbal_hil.knowledge.tuning.loops import AxisDynamics
from sim_backend.model import AntennaModel, ModelKind, plant_arrays
from sim_backend.rigid_body import body_numbers

#: positions of the carried joint at which the carrying one's inertia is looked at
_POSITIONS_RAD = np.linspace(-0.5 * math.pi, 0.5 * math.pi, 37)


def axis_inertias(model: AntennaModel, axis: str) -> tuple[float, ...]:
    """Inertias (kg m^2; kg of a linear axis) that a torque of this axis moves: largest and least over the positions of
    the joint that it carries, one number where nothing depends on that.
    """
    if model.kind is not ModelKind.GIMBAL:
        return (model.number(axis, model.own_inertia_path(axis)),)
    arrays = plant_arrays(model)
    # interpreted: compiling it for one call would cost a third of a second
    turned, products, _, _ = interpreted(body_numbers)(arrays.P, arrays.K, (0.0, 1.0))
    if model.axes.index(axis) == 1:
        return (float(products[2]),)
    a, b, c = turned
    found = a + b * np.cos(2.0 * _POSITIONS_RAD) + c * np.sin(2.0 * _POSITIONS_RAD)
    most, least = float(found.max()), float(found.min())
    return (most, least) if most - least > 1e-6 * most else (most,)


def axis_cases(model: AntennaModel, axis: str) -> tuple[AxisDynamics, ...]:
    """One axis in each of its inertias, while it slides and, with bristles, while they hold it."""

    def of(effect: str) -> list[dict[str, float]]:
        entries = [one for one in model.effects if one.effect.name == effect and one.axis == axis]
        return [{p.name: one.value(p.name) for p in one.effect.parameters} for one in entries]

    delay_s = model.number(axis, "actuator.time_constant") + sum(one["delay"] for one in of("transport_delay"))
    modes = tuple(
        (2.0 * math.pi * one["antiresonance_frequency"], one["damping_ratio"], one["inertia_share"])
        for one in of("structural_resonance")
        if one["inertia_share"] > 0.0 and one["antiresonance_frequency"] > 0.0
    )
    viscous, sigma0, sigma1 = (model.number(axis, f"friction.{name}") for name in ("viscous", "sigma0", "sigma1"))
    frictions = [(viscous, 0.0)] + ([(viscous + sigma1, sigma0)] if sigma0 > 0.0 else [])
    gyro = model.number(axis, "gyro.bandwidth"), model.number(axis, "gyro.damping")
    return tuple(
        AxisDynamics(inertia, damping, stiffness, delay_s, *gyro, modes)
        for inertia in axis_inertias(model, axis)
        for damping, stiffness in frictions
    )


def told_wrong(case: AxisDynamics, share: float, tick_s: float) -> list[AxisDynamics]:
    """The same axis with inertia and gyro off by `share` either way and its modes by a third of that, the torque acting
    when told and a tick later.
    """
    found = []
    for inertia in (1.0 - share, 1.0 + share):
        for turn in (-share, share):
            for late_s in (0.0, tick_s):
                moved = case.varied(inertia, late_s)
                modes = tuple(((1.0 + turn / 3.0) * w, damping, hung) for w, damping, hung in case.modes)
                found.append(moved.with_sensing((1.0 + turn) * case.gyro_rad_s, modes))
    return found
