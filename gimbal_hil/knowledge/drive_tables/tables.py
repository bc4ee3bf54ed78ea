"""All tables of a model for the drives of a configuration."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from firmware_protocol.errors import BadInputError
from firmware_protocol.links import AdapterLinkConfig
from gimbal_hil.knowledge.drive_tables.friction import FrictionTable, acts_in_table, friction_table
from gimbal_hil.knowledge.drive_tables.makes import MAKES, friction_text, share_text
from gimbal_hil.knowledge.drive_tables.motor import DriveOfAxis, Motor
from gimbal_hil.knowledge.drive_tables.ripple import RippleTable, is_over_position, ripple_table
from gimbal_hil.knowledge.model_exports import Item, Remark, items_of
from sim_backend.model import AntennaModel

_FRICTION = tuple(
    f"friction.{name}" for name in ("breakaway", "coulomb", "stribeck_velocity", "shape", "sigma0", "sigma1", "viscous")
)
_NO_TABLE = "no table over position or rate holds it"


@dataclass(frozen=True)
class AxisTables:
    """Tables of one axis, the files that hold them (name -> text), and what became of its friction and effects."""

    drive: DriveOfAxis
    make: str
    ripple: RippleTable
    friction: FrictionTable
    files: Mapping[str, str]
    held: tuple[Item, ...]
    approximated: tuple[Remark, ...]
    left_out: tuple[Remark, ...]

    @property
    def document(self) -> dict[str, object]:
        """What the tables do not say: units, the travel of a reversal, what is held."""
        make = MAKES[self.make]
        per_turn, _ = make.units(self.drive)
        travel = abs(self.drive.shaft_turns_s(self.friction.reversal_travel)) * per_turn
        return {
            "axis": self.drive.axis,
            "drive": self.make,
            "id": self.drive.section.id,
            "position_unit": make.position_unit,
            "torque_unit": make.torque_unit,
            "reversal_travel": travel,
            "reversal_damping_s": self.friction.reversal_damping_s,
            "files": sorted(self.files),
            "held": [vars(item) for item in self.held],
            "approximated": [{**vars(one.item), "how": one.reason} for one in self.approximated],
            "left_out": [{**vars(one.item), "reason": one.reason} for one in self.left_out],
        }


def drive_tables(model: AntennaModel, link: AdapterLinkConfig, motors: Mapping[str, Motor]) -> tuple[AxisTables, ...]:
    """Tables for each axis of a model behind the drives of a link; BadInputError where the make takes none."""
    if link.drive not in MAKES:
        raise BadInputError("link.drive", f"no table format is known for {link.drive}", " or ".join(MAKES))
    if model.is_linear:
        raise BadInputError(f"{model.where}: kind", "is linear", "axes that turn: a table is over a turn of the rotor")
    if len(model.axes) > len(link.drives):
        raise BadInputError(f"{model.where}: axes", f"{len(model.axes)} axes", f"{len(link.drives)}, one a drive")
    return tuple(
        _of_axis(model, link.drive, DriveOfAxis(axis, section, motors.get(axis, Motor())))
        for axis, section in zip(model.axes, link.drives, strict=False)
    )


def _of_axis(model: AntennaModel, name: str, drive: DriveOfAxis) -> AxisTables:
    make = MAKES[name]
    ripple = ripple_table(model, drive, make.places, lambda table, at: make.stored(drive, table, at))
    friction = friction_table(model, drive.axis)
    files = {f"{drive.axis}.friction.csv": friction_text(make, drive, friction)}
    if len(friction.places):
        files[f"{drive.axis}.share_of_dry.csv"] = share_text(make, drive, friction)
    if ripple.holds_something:
        ending, text = make.written(drive, ripple.torque_nm)
        files[f"{drive.axis}.{ending}"] = text
    held, left = [], list(ripple.left_out)
    effects = {entry.effect.name: entry for entry in model.effects if entry.axis == drive.axis}
    for item in (item for item in items_of(model) if item.axis == drive.axis):
        entry = effects.get(item.name)
        if item.name in _FRICTION or (entry is not None and acts_in_table(entry)):
            held.append(item)
        elif entry is not None and not is_over_position(entry):
            left.append(Remark(item, _NO_TABLE))
    return AxisTables(drive, name, ripple, friction, files, tuple(held), ripple.approximated, tuple(left))
