"""The base under a virtual antenna by name: turbulence and manoeuvres of the arena, or a recorded motion."""

from __future__ import annotations

import csv
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from firmware_protocol.errors import BadInputError
from gimbal_hil.pointing.arena import MOTION_ROW_HZ, AircraftMotion, Manoeuvre, Swing, Turbulence, write_motion
from gimbal_hil.pointing.following.geodesy import Table
from sim_backend.boresight import Boresight
from sim_backend.model import AntennaModel, BaseMotionKind

#: motions by name; the last one is 5 deg/s at 1 Hz about every axis
MOTIONS: Mapping[str, AircraftMotion] = {
    "turbulence": Turbulence(motion="turbulence", sigma_m_s=3.05),
    "severe_turbulence": Turbulence(motion="turbulence", sigma_m_s=6.1),
    "manoeuvre": Manoeuvre(motion="manoeuvre"),
    "swing": Swing(motion="swing", rate_rad_s=0.08727, frequency_hz=1.0),
}
#: a base by name moves for so long (s) under a virtual antenna in real time: turbulence is drawn for all of it at once
BASE_S = 1800.0
_ANGLES = ("roll", "pitch", "yaw")


@dataclass(frozen=True)
class BaseTruth:
    """What a base truly does: seconds since the virtual antenna began, roll, pitch and yaw (n, 3), rad."""

    time_s: Table
    attitude: Table

    def at(self, time_s: Table) -> Table:
        """Attitude (n, 3) at times, the last one held."""
        return np.column_stack([np.interp(time_s, self.time_s, angle) for angle in self.attitude.T])


#: level, its x to the north
STANDING = BaseTruth(np.zeros(1), np.zeros((1, 3)))


def in_base(x: Table, attitude: Table) -> Table:
    """Earth vectors (n, 3) in axes of a base with these attitudes (n, 3)."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(attitude.T), np.sin(attitude.T)
    x1, y1 = cy * x[:, 0] + sy * x[:, 1], cy * x[:, 1] - sy * x[:, 0]
    x2, z2 = cp * x1 - sp * x[:, 2], sp * x1 + cp * x[:, 2]
    return np.column_stack([x2, cr * y1 + sr * z2, cr * z2 - sr * y1])


def moved(model: AntennaModel, base: str, duration_s: float, seed: int, folder: Path) -> AntennaModel:
    """The model on a base motion by name (written into `folder`) or from a CSV file; its navigation stays as old as the
    model says.
    """
    path = Path(base)
    if base in MOTIONS:
        path = folder / "base.csv"
        write_motion(path, *_named(base, duration_s, seed, model.file.boresight))
    _require_motion(base, path)
    section: dict[str, object] = {"motion": "recorded", "file": str(path.resolve())}
    return model.with_base(section | {"ins_age_s": model.file.base.ins_age_s})


def truth_of(base: str, duration_s: float, seed: int, boresight: Boresight = Boresight.AHEAD) -> BaseTruth:
    """What `moved` gives the virtual antenna."""
    if base in MOTIONS:
        attitude, _ = _named(base, duration_s, seed, boresight)
        return BaseTruth(np.arange(len(attitude)) / MOTION_ROW_HZ, attitude)
    _require_motion(base, Path(base))
    with Path(base).open(newline="", encoding="utf-8") as handle:
        try:
            rows = np.array([[float(row[name]) for name in ("time_s", *_ANGLES)] for row in csv.DictReader(handle)])
        except (KeyError, TypeError, ValueError) as error:
            raise BadInputError(base, f"is no base motion ({error})", "columns time_s, roll, pitch, yaw") from None
    return BaseTruth(rows[:, 0], np.unwrap(rows[:, 1:], axis=0))


def truth_of_model(model: AntennaModel) -> BaseTruth | None:
    """What the base of a virtual antenna does where its model says that it stands; None where it moves."""
    base = model.file.base
    if base.motion is not BaseMotionKind.FIXED:
        return None
    angles = base.attitude_rad
    return BaseTruth(np.zeros(1), np.array([[angles.roll, angles.pitch, angles.yaw]]))


def as_base(attitude: Table, pivot: Table, boresight: Boresight) -> tuple[Table, Table]:
    """Attitude and acceleration of the pivot (n, 3) of an aircraft, in the axes of its antenna's base: one that looks
    along -x looks ahead with the base's x turned aft.
    """
    if boresight is Boresight.ASTERN:
        return attitude * (-1.0, -1.0, 1.0) + (0.0, 0.0, math.pi), pivot * (-1.0, -1.0, 1.0)
    return attitude, pivot


def _named(base: str, duration_s: float, seed: int, boresight: Boresight) -> tuple[Table, Table]:
    """Attitude and acceleration of the pivot (n, 3) of a motion by name, in the axes of the base."""
    return as_base(*MOTIONS[base].rows(duration_s, seed), boresight)


def _require_motion(base: str, path: Path) -> None:
    if not path.is_file():
        raise BadInputError(f"--base {base}", "is no motion and no file", f"{', '.join(MOTIONS)} or a CSV file")
