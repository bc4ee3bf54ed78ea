"""Every effect that a real antenna can have, one file each, and the catalogue that finds them."""

from sim_backend.effects.effect import Domain, Effect, Hook, Parameter
from sim_backend.effects.registry import CATALOGUE, effect_named

__all__ = ["CATALOGUE", "Domain", "Effect", "Hook", "Parameter", "effect_named"]
