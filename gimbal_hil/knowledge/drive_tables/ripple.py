"""Torque over the position of a joint that is the same in every turn of its rotor: what an anticogging table holds.

Which effects those are is asked of the effects: torques that act through the position alone. What differs from one turn
of the rotor to the next, or swings faster than the table has places for, is left out with the reason.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from gimbal_hil.knowledge.drive_tables.motor import DriveOfAxis
from gimbal_hil.knowledge.model_exports import Item, Remark
from sim_backend.effects import Hook, Variable
from sim_backend.model import AntennaModel, EffectEntry

#: what a table may leave of an effect before it is no use
MOST_LEFT = 0.2
#: turns of the rotor that one table has to do for
_TURNS = (0, 1, 2, 3, 5)
_FINE = 16


@dataclass(frozen=True)
class RippleTable:
    """Torque (N m, at the joint) that makes up for the ripple, at the middle or the start of each place of a rotor's
    turn (places,), and what became of each effect.
    """

    torque_nm: np.ndarray
    approximated: tuple[Remark, ...]
    left_out: tuple[Remark, ...]

    @property
    def holds_something(self) -> bool:
        return bool(self.approximated)


def is_over_position(entry: EffectEntry) -> bool:
    """Whether an effect is a torque that depends on the position and on nothing else."""
    return entry.effect.hook is Hook.TORQUE and entry.effect.acts_through == {Variable.POSITION}


def ripple_table(
    model: AntennaModel, drive: DriveOfAxis, places: int, stored: Callable[[np.ndarray, np.ndarray], np.ndarray]
) -> RippleTable:
    """The table of an axis in `places` places. `stored` tells what a drive makes of a table (N m at the joint) at
    places given as shares of a turn: its steps, and how it goes from one place to the next.
    """
    turns = np.arange(places) / places
    fine = (np.arange(places * _FINE) + 0.5) / (places * _FINE)
    total = np.zeros(places)
    nearly, left = [], []
    for entry in (entry for entry in model.effects if entry.axis == drive.axis and is_over_position(entry)):
        item = _item(entry)
        ripple = np.array([-_torque(entry, drive.joint_at_rotor(fine + turn)) for turn in _TURNS])
        size = float(np.sqrt(np.mean(ripple[0] ** 2)))
        if size == 0.0:
            left.append(Remark(item, "it is zero"))
            continue
        table = -_torque(entry, drive.joint_at_rotor(turns))
        # of a ripple whose order is all but whole the next turns are a little further off than the first
        first, *further = np.sqrt(np.mean((stored(table, fine) - ripple) ** 2, axis=1)) / size
        most = max(further)
        if first > MOST_LEFT:
            left.append(Remark(item, f"{places} places a turn are too few: they would leave {100 * first:.0f} % of it"))
        elif most > MOST_LEFT:
            said = f"one turn's table would leave {100 * most:.0f} % of it {_TURNS[-1]} turns further"
            left.append(Remark(item, f"it is not the same in every turn of the rotor: {said}"))
        else:
            total += table
            nearly.append(Remark(item, f"{places} places a turn leave {100 * max(first, most):.1f} % of it"))
    return RippleTable(total, tuple(nearly), tuple(left))


def _torque(entry: EffectEntry, positions: np.ndarray) -> np.ndarray:
    """Its torque at joint positions, N m, by its own law."""
    assert entry.effect.law is not None
    numbers, states = np.array(entry.parameters), np.zeros(max(1, entry.effect.states))
    return np.array([entry.effect.law(numbers, 0, states, 0, float(q), 0.0, 0.0) for q in positions])


def _item(entry: EffectEntry) -> Item:
    values = zip(entry.effect.parameters, entry.parameters, strict=True)
    return Item(entry.axis, entry.effect.name, ", ".join(f"{one.name} {value:.6g}" for one, value in values))
