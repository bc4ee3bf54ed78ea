"""Friction of an axis as tables over the reference's rate and the travel since it turned round.

At a steady rate v a joint takes dry(v) in the direction of motion and viscous(v). After a reversal the bristles of the
contact bend over first: the dry torque F goes from what it was towards dry(v) as dry + (F0 - dry) exp(-travel /
reversal_travel), and F + reversal_damping dF/dt is what the joint takes: LuGre with sigma0 z for F (Canudas de Wit et
al. 1995), its damping sigma1 / sigma0. Everything is taken from the reference: nothing is fed back, no margin changes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from sim_backend.effects import Hook, Variable
from sim_backend.friction import stribeck_level
from sim_backend.model import AntennaModel, EffectEntry

#: degC at which friction is taken: that of a model's own numbers
TEMPERATURE_DEGC = 20.0
_SPEEDS = 40
_FASTEST_RAD_S = 10.0
_PLACES = 361
_NOT_OF_IT = {Variable.TORQUE, Variable.TEMPERATURE, Variable.PAST, Variable.BASE_MOTION}


@dataclass(frozen=True)
class FrictionTable:
    """Joint units: rates (n,) rad/s, rising, negative first; torques (n,) N m that a motion at that rate takes: `dry`
    against the direction of motion, never negative, `viscous` in the sign of the rate.

    `reversal_travel` (rad) is how far the joint moves until the dry torque has turned round to 1 - 2/e of itself, 0
    where it does so at once; `reversal_damping_s` as above. `share_of_dry` (m,) multiplies the dry torque at `places`
    (m,) rad; empty where it is the same everywhere.
    """

    rates: np.ndarray
    dry: np.ndarray
    viscous: np.ndarray
    reversal_travel: float
    reversal_damping_s: float
    places: np.ndarray
    share_of_dry: np.ndarray


def acts_in_table(entry: EffectEntry) -> bool:
    """Whether an effect of friction, or a drag over the rate, is in the table."""
    effect = entry.effect
    if effect.states or effect.acts_through & _NOT_OF_IT:
        return False
    return effect.hook is Hook.FRICTION or (effect.hook is Hook.TORQUE and effect.acts_through == {Variable.RATE})


def friction_table(model: AntennaModel, axis: str) -> FrictionTable:
    """The tables of an axis, from the model's numbers and the laws of its effects at 20 degC."""
    number = {
        name: model.number(axis, f"friction.{name}")
        for name in ("breakaway", "coulomb", "stribeck_velocity", "shape", "sigma0", "sigma1", "viscous")
    }
    entries = [entry for entry in model.effects if entry.axis == axis and acts_in_table(entry)]
    up = np.geomspace(min(1e-2 * (number["stribeck_velocity"] or 1e-3), 1e-3), _FASTEST_RAD_S, _SPEEDS)
    rates = np.concatenate([-up[::-1], up])
    low, high = _travel(model, axis)
    places = np.linspace(low, high, _PLACES)
    over_place = any(Variable.POSITION in entry.effect.acts_through for entry in entries)
    share = np.array([_levels(entries, number, q, up[-1])[1] for q in places]) if over_place else np.zeros(0)
    mean = float(np.mean(share)) if over_place else _levels(entries, number, 0.0, up[-1])[1]
    dry, viscous = [], []
    for rate in rates:
        ts, tc, sigma2 = _levels(entries, number, 0.0, float(rate))
        # the table over the rate holds what is left beside the course over the travel
        here = tc / mean if over_place and mean > 0.0 else 1.0
        level = stribeck_level(abs(float(rate)), ts, tc, number["stribeck_velocity"], number["shape"])
        dry.append(level / here if here > 0.0 else level)
        viscous.append(sigma2 * rate - sum(_drag(entry, float(rate)) for entry in entries))
    sigma0 = number["sigma0"]
    return FrictionTable(
        rates,
        np.array(dry),
        np.array(viscous),
        mean / sigma0 if sigma0 > 0.0 else 0.0,
        number["sigma1"] / sigma0 if sigma0 > 0.0 else 0.0,
        places if over_place else np.zeros(0),
        share / mean if over_place and mean > 0.0 else np.zeros(0),
    )


def _levels(entries: list[EffectEntry], number: dict[str, float], q: float, rate: float) -> tuple[float, float, float]:
    """Ts, Tc (N m) and sigma2 (N m s/rad) in force at a place and rate."""
    levels = number["breakaway"], number["coulomb"], number["viscous"]
    for entry in entries:
        if entry.effect.hook is Hook.FRICTION:
            assert entry.effect.law is not None
            numbers, none = np.array(entry.parameters), np.zeros(1)
            levels = entry.effect.law(numbers, 0, none, 0, q, rate, 0.0, TEMPERATURE_DEGC, *levels)
    return levels


def _drag(entry: EffectEntry, rate: float) -> float:
    """What a torque over the rate adds at the joint, N m; none for an effect of friction."""
    if entry.effect.hook is not Hook.TORQUE:
        return 0.0
    assert entry.effect.law is not None
    return float(entry.effect.law(np.array(entry.parameters), 0, np.zeros(1), 0, 0.0, rate, 0.0))


def _travel(model: AntennaModel, axis: str) -> tuple[float, float]:
    low, high = model.number(axis, "travel.low"), model.number(axis, "travel.high")
    return max(low, -math.pi), min(high, math.pi)


class FrictionFeed:
    """The torque to send with each set-point, from the tables: one for each axis, stepped with its reference once every
    `period_s`.
    """

    def __init__(self, table: FrictionTable, period_s: float) -> None:
        self._table, self._period_s = table, period_s
        self._dry, self._direction = 0.0, 1.0
        self._place: float | None = None

    def torque_nm(self, position: float, rate: float) -> float:
        """For the reference's next position (rad) and rate (rad/s), at the joint."""
        table = self._table
        moved = 0.0 if self._place is None else position - self._place
        self._place, before = position, self._dry
        if moved != 0.0:
            self._direction = math.copysign(1.0, moved)
            slowest = float(table.rates[len(table.rates) // 2])
            settled = self._direction * float(
                np.interp(self._direction * max(abs(rate), slowest), table.rates, table.dry)
            )
            if len(table.places):
                settled *= float(np.interp(position, table.places, table.share_of_dry))
            left = math.exp(-abs(moved) / table.reversal_travel) if table.reversal_travel > 0.0 else 0.0
            self._dry = settled + (self._dry - settled) * left
        damping = table.reversal_damping_s * (self._dry - before) / self._period_s
        return self._dry + damping + float(np.interp(rate, table.rates, table.viscous))
