"""The catalogue: every module of this folder that defines `EFFECT`, and every entry point of the group
`gimbal_hil.effects`.
"""

from __future__ import annotations

import importlib
import inspect
import pkgutil
import warnings
from importlib.metadata import entry_points
from pathlib import Path

from firmware_protocol.errors import BadInputError
from firmware_protocol.kernel_cache import include_source
from sim_backend.effects.effect import Effect, Hook
from sim_backend.effects.law import LAWS

ENTRY_POINT_GROUP = "gimbal_hil.effects"
#: modules of this folder that define no effect
_NO_EFFECT = (
    "axis_scale",
    "default_search",
    "dispatch",
    "effect",
    "law",
    "law_program",
    "parameter",
    "registry",
    "search_profile",
    "separating_runs",
)


def _own_effects() -> list[Effect]:
    found = []
    for module in sorted(info.name for info in pkgutil.iter_modules([str(Path(__file__).parent)])):
        if module in _NO_EFFECT:
            continue
        include_source(__name__, (Path(__file__).parent / f"{module}.py").read_bytes())
        found.append(importlib.import_module(f"sim_backend.effects.{module}").EFFECT)
    return found


def _plugged_in() -> list[Effect]:
    found = []
    for point in sorted(entry_points(group=ENTRY_POINT_GROUP), key=lambda point: point.name):
        try:
            effect = point.load()
        except Exception as error:  # a plug-in may fail in any way, and is no reason to do nothing at all
            warnings.warn(f"effect {point.name} of {point.value} cannot be loaded: {error}", stacklevel=2)
            continue
        if not isinstance(effect, Effect):
            raise BadInputError(
                f"entry point {ENTRY_POINT_GROUP}:{point.name}", f"is {type(effect).__name__}", "an Effect"
            )
        include_source(__name__, inspect.getsource(importlib.import_module(point.module)).encode())
        found.append(effect)
    return found


def _catalogue() -> dict[str, Effect]:
    named: dict[str, Effect] = {}
    for effect in _own_effects() + _plugged_in():
        if effect.name in named:
            raise BadInputError(f"effect {effect.name!r}", "is defined twice", "one definition of each effect")
        named[effect.name] = effect
    return named


#: name -> effect
CATALOGUE: dict[str, Effect] = _catalogue()
#: the same with what a model file's own laws are at each place
WITH_LAWS: dict[str, Effect] = CATALOGUE | {law.name: law for law in LAWS.values()}


def effect_named(name: str, where: str = "effects") -> Effect:
    """The effect of that name, or BadInputError that lists the nearest names."""
    if name not in CATALOGUE:
        raise BadInputError(where, f"no effect {name!r}", "one of " + ", ".join(sorted(CATALOGUE)))
    return CATALOGUE[name]


def confused_with(name: str) -> tuple[str, ...]:
    """Effects that look like this one in some data: those that a run which separates it separates too, and its twin by
    command.
    """
    effect = CATALOGUE[name]
    alike = (other for other in CATALOGUE.values() if set(other.separated_by) & set(effect.separated_by))
    twins = (
        other for other in CATALOGUE.values() if effect.same_by_command == other.name or other.same_by_command == name
    )
    return tuple(sorted({other.name for other in (*alike, *twins)} - {name}))


def effects_at(hook: Hook) -> tuple[Effect, ...]:
    """All effects that enter at a hook, laws of model files last; an effect's place in this tuple is its code in
    compiled code.
    """
    named = sorted((e for e in CATALOGUE.values() if e.hook == hook), key=lambda e: e.name)
    return (*named, *(law for law in LAWS.values() if law.hook == hook))
