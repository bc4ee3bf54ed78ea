"""What has to be evaluated anew when numbers of a twin change: a joint's torque, a gyro's rate, or everything.

Along a measured motion the joints do not act on each other, so a number of one joint's friction or drive changes the
torque of that joint alone. Bodies change what both joints need, and encoders that read wrong everything.
"""

from __future__ import annotations

import numpy as np

from gimbal_hil.knowledge.discrepancy.twin.kernel import EVERY_JOINT, EVERY_PART, Part
from gimbal_hil.knowledge.discrepancy.twin.smoothing import Floats
from sim_backend import layout
from sim_backend.effects import WITH_LAWS, Hook

#: (name of an effect, index of its axis), in the order of their parameters
Instances = tuple[tuple[str, int], ...]

_JOINT, _GYRO = (Part.JOINT_0, Part.JOINT_1), (Part.GYRO_0, Part.GYRO_1)


def _parts_of_slots() -> np.ndarray:
    """Parts that each slot of P before those of the effects acts on."""
    found = np.full(layout.EFFECT_PARAMETERS, int(EVERY_PART))
    found[layout.INERTIA_OUTER : layout.MASS_INNER + 1] = int(EVERY_JOINT)
    for axis in range(layout.MAX_AXES):
        block, knots = layout.axis_block(axis), layout.MAX_KNOTS * layout.KNOT_SIZE
        found[block + layout.TS : block + layout.LAG_MEAN + 1] = int(_JOINT[axis])
        found[block + layout.BUMP_DELTA] = int(_JOINT[axis])
        found[layout.KNOTS + axis * knots : layout.KNOTS + (axis + 1) * knots] = int(_JOINT[axis])
        found[block + layout.GYRO_BIAS : block + layout.GYRO_B2 + 1] = int(_GYRO[axis])
    return found


_OF_SLOT = _parts_of_slots()


def changed_parts(instances: tuple[Instances, Instances], numbers: tuple[Floats, Floats]) -> Part:
    """Parts that may differ between two evaluations with these effects and numbers (P), at the same step."""
    before, after = numbers
    found = Part(0)
    for slot in np.flatnonzero(before[: layout.EFFECT_PARAMETERS] != after[: layout.EFFECT_PARAMETERS]):
        found |= Part(int(_OF_SLOT[slot]))
    for axis, joint in enumerate(_JOINT):
        table = slice(
            layout.BUMP_TABLE + axis * layout.BUMP_TABLE_SIZE, layout.BUMP_TABLE + (axis + 1) * layout.BUMP_TABLE_SIZE
        )
        if not joint & found and np.any(before[table] != after[table]):
            found |= joint
    for i in range(max(len(each) for each in instances)):
        there = [each[i] if i < len(each) else None for each in instances]
        own = slice(
            layout.EFFECT_PARAMETERS + i * layout.PARAMETERS_PER_INSTANCE,
            layout.EFFECT_PARAMETERS + (i + 1) * layout.PARAMETERS_PER_INSTANCE,
        )
        if there[0] != there[1] or np.any(before[own] != after[own]):
            for label in there:
                found |= Part(0) if label is None else parts_of(*label)
    return found


def parts_of(effect: str, axis: int) -> Part:
    """Parts that an effect which adds physics acts on."""
    hook = WITH_LAWS[effect].hook
    if hook in (Hook.COMMAND, Hook.FRICTION, Hook.TORQUE, Hook.STRUCTURE):
        return _JOINT[axis]
    return _GYRO[axis] if hook is Hook.GYRO else EVERY_PART
