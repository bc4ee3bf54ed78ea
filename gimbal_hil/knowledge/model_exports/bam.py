"""Friction of a model as parameters of BAM (Better Actuator Models; Duclusaud, Passault et al. 2025), one JSON object
an axis.

BAM's budget of friction at joint rate w and torque T: base + stribeck exp(-(|w|/w_s)^alpha) + load |T|, and viscous
beside it: model m2, or m4 where friction grows with the torque.
"""

from __future__ import annotations

import json

from gimbal_hil.knowledge.model_exports.account import Account, ExportedModel
from sim_backend.model import AntennaModel

#: BAM's motors turn volts into torque; a model of this project states the torque itself
_ACTUATOR = "torque"


def bam_of(model: AntennaModel) -> ExportedModel:
    """A JSON object by axis, each with BAM's own keys; `armature` is the moment about the joint."""
    held: set[tuple[str, str]] = set()
    document: dict[str, dict[str, object]] = {}
    for axis in model.axes:
        level = model.number(axis, "friction.coulomb")
        load = [
            entry.value("coefficient")
            for entry in model.effects
            if entry.axis == axis and entry.effect.name == "load_dependent_friction"
        ]
        delay = [
            entry.value("delay")
            for entry in model.effects
            if entry.axis == axis and entry.effect.name == "transport_delay"
        ]
        document[axis] = {
            "model": "m4" if load else "m2",
            "actuator": _ACTUATOR,
            "kt": 1.0 + model.number(axis, "actuator.gain_error"),
            "R": 1.0,
            "armature": model.number(axis, model.own_inertia_path(axis)),
            "q_offset": 0.0,
            "command_delay": sum(delay),
            "friction_base": level,
            "friction_stribeck": model.number(axis, "friction.breakaway") - level,
            "dtheta_stribeck": model.number(axis, "friction.stribeck_velocity"),
            "alpha": model.number(axis, "friction.shape"),
            "friction_viscous": model.number(axis, "friction.viscous"),
        }
        if load:
            document[axis] |= {"load_friction_base": sum(load), "load_friction_stribeck": 0.0}
        held |= {
            (axis, f"friction.{name}") for name in ("coulomb", "breakaway", "stribeck_velocity", "shape", "viscous")
        }
        held |= {
            (axis, name)
            for name in (
                "load_dependent_friction",
                "transport_delay",
                "actuator.gain_error",
                model.own_inertia_path(axis),
            )
        }
    text = json.dumps(document, indent=2) + "\n"
    return Account(frozenset(held), {}, {}, "BAM's models have no parameter for it").settle(model, text)
