"""Friction, limits and delay of a model as actuator configurations of Isaac Lab; bodies go as URDF.

Source: Isaac Lab's documentation of `isaaclab.actuators` (ImplicitActuatorCfg, DelayedPDActuatorCfg), version 2.3:
`friction` is the static level, `dynamic_friction` the Coulomb level, `viscous_friction` the damping of the joint.
"""

from __future__ import annotations

import re

from gimbal_hil.knowledge.model_exports.account import Account, ExportedModel
from sim_backend.model import AntennaModel

_BODY = ("mass", "cog.x", "cog.y", "cog.z", *(f"inertia.{k}" for k in ("xx", "yy", "zz", "xy", "xz", "yz")))
_REASONS = dict.fromkeys(
    (*(f"body.{name}" for name in _BODY), "travel.low", "travel.high"),
    "it goes with the bodies: export them as urdf",
)


def isaac_of(model: AntennaModel) -> ExportedModel:
    """A Python file with a dictionary `ACTUATORS` for `ArticulationCfg(actuators=...)`."""
    held: set[tuple[str, str]] = set()
    nearly: dict[tuple[str, str], str] = {}
    entries = []
    for axis in model.axes:
        delays = [
            entry.value("delay")
            for entry in model.effects
            if entry.axis == axis and entry.effect.name == "transport_delay"
        ]
        steps = round(sum(delays) / model.file.plant_step_s)
        limit = model.number(axis, "actuator.limit")
        numbers = {
            "effort_limit": repr(limit) if limit else "None",
            # torque control: the loops that close position and rate are yours
            "stiffness": "0.0",
            "damping": "0.0",
            "armature": "0.0",
            "friction": repr(model.number(axis, "friction.breakaway")),
            "dynamic_friction": repr(model.number(axis, "friction.coulomb")),
            "viscous_friction": repr(model.number(axis, "friction.viscous")),
        }
        if delays:
            numbers |= {"min_delay": str(steps), "max_delay": str(steps)}
            nearly[axis, "transport_delay"] = f"{steps} physics steps of {model.file.plant_step_s:g} s"
        kind = "DelayedPDActuatorCfg" if delays else "IdealPDActuatorCfg"
        lines = "".join(f"        {key}={value},\n" for key, value in numbers.items())
        entries.append(f'    "{axis}": {kind}(\n        joint_names_expr=["{re.escape(axis)}"],\n{lines}    ),\n')
        held |= {
            (axis, name) for name in ("friction.coulomb", "friction.breakaway", "friction.viscous", "actuator.limit")
        }
    text = (
        f'"""Actuators of {model.name} for Isaac Lab; SI units."""\n\n'
        "from isaaclab.actuators import DelayedPDActuatorCfg, IdealPDActuatorCfg\n\n"
        f"ACTUATORS = {{\n{''.join(entries)}}}\n"
    )
    return Account(frozenset(held), nearly, _REASONS, "Isaac Lab's actuators have no law for it").settle(model, text)
