"""One joint of an arm as a log of its own: what the other links do to it is a torque that is known.

The joint is asked for `M_jj a_j` with one inertia, its friction and whatever its model says; all else that rigid links
ask of it (gravity, coupling, an inertia that changes with the pose) goes into `torque_known`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.arms.arm import Arm, Floats
from gimbal_hil.data.signals import SignalsTable

#: rates and accelerations are those of cubics over this long, s: beyond the scored band, above the encoder's step
SMOOTHING_S = 0.04
_DEGREE = 3


@dataclass(frozen=True)
class OneJoint:
    """The joint's log, and the inertia (mass) that its model should have, SI: that of the mean pose."""

    table: SignalsTable
    inertia: float
    #: rms of what the others do to it, and of the torque that was commanded
    known_rms: float
    commanded_rms: float


def one_joint(
    arm: Arm,
    table: SignalsTable,
    joint: str,
    held: Mapping[str, float] | None = None,
    smoothing_s: float = SMOOTHING_S,
) -> OneJoint:
    """The joint's columns of a log of the whole arm, with `torque_known`. Joints of `held` stand at that position.

    Raises BadInputError for a joint that the arm does not have, and for one whose motion nobody knows.
    """
    held = held or {}
    for name in (joint, *held):
        if name not in arm.joints:
            raise BadInputError(str(arm.path), f"has no joint {name!r}", f"one of {', '.join(arm.joints)}")
    position = np.stack([_position(arm, table, name, held) for name in arm.joints], axis=1)
    rate, acceleration = (_derivative(position, table.period_s, order, smoothing_s) for order in (1, 2))
    place = arm.joints.index(joint)
    inertia = arm.inertia(position.mean(axis=0), joint)
    known = arm.torques(position, rate, acceleration)[:, place] - inertia * acceleration[:, place]
    own = {name: values for name, values in table.columns.items() if name.partition(".")[0] == joint}
    before = own.get(f"{joint}.torque_known", np.zeros(len(table)))
    columns = {**own, f"{joint}.torque_known": known + before}
    alone = SignalsTable.of((joint,), table.time_s, columns, table.repeat, table.source, table.notes)
    rms = [float(np.sqrt(np.mean(values**2))) for values in (known, alone.commanded(joint))]
    return OneJoint(alone, inertia, *rms)


def _position(arm: Arm, table: SignalsTable, name: str, held: Mapping[str, float]) -> Floats:
    found = table.columns.get(f"{name}.position")
    if found is not None:
        return found
    if name not in held:
        raise BadInputError(
            table.source or "log",
            f"has no position of {name}, a joint of {arm.path.name}",
            f"the column {name}.position, or --held {name}=POSITION for one that stands",
        )
    return np.full(len(table), held[name])


def _derivative(position: Floats, period_s: float, order: int, smoothing_s: float) -> Floats:
    """Derivative of each column by local cubics, shape kept; without delay."""
    from scipy.signal import savgol_filter

    rows = max(_DEGREE + 2, 2 * round(0.5 * smoothing_s / period_s) + 1)
    if len(position) < rows:
        raise BadInputError("log", f"has {len(position)} rows", f"at least {rows} for rates")
    return np.asarray(savgol_filter(position, rows, _DEGREE, deriv=order, delta=period_s, axis=0))
