"""One joint of an arm, from a file of all joints: read by names that are stated or suggest themselves."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from gimbal_hil.data.arms import OneJoint, arm_of_urdf, one_joint
from gimbal_hil.data.containers import contents_of, guess
from gimbal_hil.data.signals import ColumnMap, guessed_words, read_signals
from gimbal_hil.data.tables import read_table


def joint_of_arm(
    log: Path,
    urdf: Path,
    joint: str,
    *,
    columns: ColumnMap | None = None,
    held: Mapping[str, float] | None = None,
    resample: bool = False,
    drop_invalid: bool = False,
    rate_hz: float | None = None,
) -> OneJoint:
    """The log of one joint, with the torque that is known from the others. Without `columns` those count whose names
    have a joint's name in them, as a bag of joint states has. BadInputError as `read_signals` and `one_joint`.
    """
    arm = arm_of_urdf(urdf)
    moving = [name for name in arm.joints if name != joint and name not in (held or {})]
    axes = (joint, *moving)
    table = read_signals(
        log,
        axes,
        resample=resample,
        drop_invalid=drop_invalid,
        rate_hz=rate_hz,
        columns=columns if columns and columns.sources else _suggested(log, axes, joint),
        passive=moving,
    )
    return one_joint(arm, table, joint, held)


def _suggested(log: Path, axes: tuple[str, ...], joint: str) -> ColumnMap:
    """Columns by the names of the joints in them; none for a file that has those of a signals table."""
    contents = contents_of(log)
    if contents is not None:
        words = guess(contents, axes)
    else:
        raw = read_table(log)
        words = () if f"{joint}.position" in raw.values else guessed_words(raw, axes)
    kept = [word for word in words if word.startswith(("time_s=", f"{joint}.")) or ".position=" in word]
    return ColumnMap.of_words(kept)
