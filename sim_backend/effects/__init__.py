"""Every effect that a real antenna can have, one file each, and the catalogue that finds them."""

from sim_backend.effects.dispatch import command_law, encoder_law, friction_law, gyro_law, structure_advance, structure_law, torque_law
from sim_backend.effects.effect import Domain, Effect, Hook, Parameter
from sim_backend.effects.registry import CATALOGUE, effect_named, effects_at

__all__ = [
    "CATALOGUE",
    "Domain",
    "Effect",
    "Hook",
    "Parameter",
    "command_law",
    "effect_named",
    "effects_at",
    "encoder_law",
    "friction_law",
    "gyro_law",
    "structure_advance",
    "structure_law",
    "torque_law",
]
