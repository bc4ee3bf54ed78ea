"""Drives by name: those that ship, and those of other packages by entry points.

A package offers a drive with an entry point in the group `gimbal_hil.drives` that names a class with the methods of
`ForeignDrive`:

    [project.entry-points."gimbal_hil.drives"]
    acme = "acme_gimbal:AcmeDrive"
"""

from __future__ import annotations

from collections.abc import Sequence
from importlib.metadata import entry_points
from typing import cast

from firmware_protocol.adapters.cia402 import Cia402Drive
from firmware_protocol.adapters.dbc_map import identifiers, require_torque
from firmware_protocol.adapters.drive import DriveTiming, ForeignDrive, Gives
from firmware_protocol.adapters.mapped import MappedDrive
from firmware_protocol.adapters.moteus import MoteusDrive
from firmware_protocol.adapters.odrive import OdriveDrive
from firmware_protocol.errors import BadInputError, refused_below
from firmware_protocol.links import DriveSection

GROUP = "gimbal_hil.drives"
DRIVES: dict[str, type[ForeignDrive]] = {
    "moteus": MoteusDrive,
    "odrive": OdriveDrive,
    "cia402": Cia402Drive,
    "dbc": MappedDrive,
}


def drive_named(name: str) -> type[ForeignDrive]:
    """The class of a drive; BadInputError lists the names, or says why a plug-in cannot be loaded."""
    if name in DRIVES:
        return DRIVES[name]
    found = {one.name: one for one in entry_points(group=GROUP)}
    if name not in found:
        raise BadInputError("link.drive", f"no drive {name!r}", ", ".join([*DRIVES, *found]))
    try:
        return cast(type[ForeignDrive], found[name].load())
    except Exception as error:  # a plug-in may fail in any way
        raise BadInputError(
            "link.drive", f"{name} cannot be loaded: {error}", f"the package of {found[name].value}"
        ) from None


def require_drives(name: str, sections: Sequence[DriveSection]) -> None:
    """BadInputError where two drives would answer to the same frames, or one cannot be asked for its torque."""
    drives = [drive_named(name)(section, DriveTiming(1e-3, 0.02)) for section in sections]
    mapped = [section for section, one in zip(sections, drives, strict=True) if isinstance(one, MappedDrive)]
    for place, section in enumerate(mapped):
        if section.map is not None:
            with refused_below(f"link.drives.{place}.map"):
                require_torque(section.map, section.torque_nm / section.gear)
    if len(mapped) == len(sections):
        used = [identifiers(section.map, section.id) for section in mapped if section.map is not None]
        both = sorted(frozenset.intersection(*used))
        if both:
            raise BadInputError(
                "link.drives.1.id",
                f"both drives use the identifier 0x{both[0]:X}",
                "another id and an id_step in the map, or a map of its own for each drive",
            )
    elif len({section.id for section in sections}) < len(sections):
        raise BadInputError(
            "link.drives.1.id", f"both drives have the id {sections[0].id}", "another one for each drive"
        )


def gives_of(name: str, section: DriveSection) -> frozenset[Gives]:
    """What a drive of this name gives, as configured."""
    return drive_named(name)(section, DriveTiming(1e-3, 0.02)).gives
