"""What the drives of each make take, and in which form.

moteus (mjbots/moteus): `motor.cogging_dq_comp`, 1024 signed bytes over one turn of the commutation encoder, linear
between them, times `motor.cogging_dq_scale` in A of q current, added in position mode; `moteus_tool --restore-config`
reads lines of key and value. ODrive (firmware 0.5): `anticogging.cogging_map`, 3600 torques in N m over one turn of the
encoder, each held over its place, added in every control mode. CiA 402 (IEC 61800-7-201): object 0x60B2, torque offset
in thousandths of the rated torque, added in cyclic synchronous position, velocity and torque mode; the host sends it.
"""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from firmware_protocol.errors import BadInputError
from gimbal_hil.knowledge.drive_tables.friction import FrictionTable
from gimbal_hil.knowledge.drive_tables.motor import DriveOfAxis

_BYTE = 127


@dataclass(frozen=True)
class Make:
    """How one make of drive stores a ripple, and in which units the host speaks to it."""

    #: places of the table in a turn of the rotor
    places: int
    #: (drive, table in N m at the joint, places as shares of a turn) -> what the drive makes of it, N m at the joint
    stored: Callable[[DriveOfAxis, np.ndarray, np.ndarray], np.ndarray]
    #: (drive, table in N m at the joint) -> ending of the file's name, and its text
    written: Callable[[DriveOfAxis, np.ndarray], tuple[str, str]]
    #: units of position and torque at the shaft, and how many of them a turn and an N m have
    position_unit: str
    torque_unit: str
    units: Callable[[DriveOfAxis], tuple[float, float]]
    #: how the table gets into the drive, for people
    how: str


def _moteus_bytes(drive: DriveOfAxis, table: np.ndarray) -> tuple[float, np.ndarray]:
    """Scale in A and signed bytes; the rotor turns more often than the shaft, with less torque."""
    constant = drive.motor.torque_constant
    if constant is None:
        raise BadInputError(
            "--torque-constant",
            f"is missing for {drive.axis}",
            f"{drive.axis}=NUMBER in N m/A; the table is in A",
        )
    amperes = table * drive.shaft_per_joint / abs(drive.motor.rotor_turns) / constant
    # as the drive reads its own number back
    scale = float(np.float32(np.max(np.abs(amperes)) / _BYTE))
    return scale, np.rint(amperes / scale).astype(int) if scale > 0.0 else np.zeros(len(table), int)


def _stored_by_moteus(drive: DriveOfAxis, table: np.ndarray, at: np.ndarray) -> np.ndarray:
    scale, values = _moteus_bytes(drive, table)
    constant = drive.motor.torque_constant or 0.0
    joint = values * scale * constant * abs(drive.motor.rotor_turns) / drive.shaft_per_joint
    return np.interp(at * len(table), np.arange(len(table) + 1), [*joint, joint[0]])


def _written_for_moteus(drive: DriveOfAxis, table: np.ndarray) -> tuple[str, str]:
    scale, values = _moteus_bytes(drive, table)
    lines = [
        f"# ripple of {drive.axis}: moteus_tool -t {drive.section.id} --restore-config {drive.axis}.moteus.cfg",
        f"motor.cogging_dq_scale {scale:.9g}",
        *(f"motor.cogging_dq_comp.{place} {value}" for place, value in enumerate(values)),
    ]
    return "moteus.cfg", "\n".join(lines) + "\n"


def _stored_by_odrive(drive: DriveOfAxis, table: np.ndarray, at: np.ndarray) -> np.ndarray:
    if (drive.motor.rotor_turns, drive.motor.rotor_zero) != (1.0, 0.0):
        raise BadInputError(
            "--rotor-turns, --rotor-zero", f"given for {drive.axis}", "none: an ODrive's map is over its own position"
        )
    return _middles(table)[np.floor(at * len(table)).astype(int) % len(table)]


def _written_for_odrive(drive: DriveOfAxis, table: np.ndarray) -> tuple[str, str]:
    values = [float(np.float32(value)) for value in _middles(table) * drive.shaft_per_joint]
    document = {"axis": drive.axis, "node_id": drive.section.id, "unit": "N m", "cogging_map": values}
    return "odrive.json", json.dumps(document) + "\n"


def _middles(table: np.ndarray) -> np.ndarray:
    """A place is held until the next: it has the torque of its middle."""
    return 0.5 * (table + np.roll(table, -1))


def _stored_by_host(drive: DriveOfAxis, table: np.ndarray, at: np.ndarray) -> np.ndarray:
    _, per_nm = _cia402_units(drive)
    between = np.interp(at * len(table), np.arange(len(table) + 1), [*table, table[0]])
    return np.rint(between * per_nm * drive.shaft_per_joint) / (per_nm * drive.shaft_per_joint)


def _written_for_cia402(drive: DriveOfAxis, table: np.ndarray) -> tuple[str, str]:
    counts, per_nm = _cia402_units(drive)
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(("position_counts", "torque_offset_thousandths"))
    motor = drive.motor
    turn = counts / abs(motor.rotor_turns)
    shafts = (np.arange(len(table)) / len(table) - motor.rotor_zero) / motor.rotor_turns
    rows = sorted(zip(shafts * counts % turn, table * drive.shaft_per_joint * per_nm, strict=True))
    writer.writerows((round(at), f"{value:.6g}") for at, value in rows)
    return "cia402.csv", text.getvalue()


def _cia402_units(drive: DriveOfAxis) -> tuple[float, float]:
    counts, rated = drive.section.counts_per_turn, drive.section.rated_torque_nm
    if counts is None or rated is None:
        missing = "counts_per_turn" if counts is None else "rated_torque_nm"
        raise BadInputError(
            f"link.drives: {missing}", f"is missing for {drive.axis}", "a number, as the adapter needs it"
        )
    return counts, 1e3 / rated


#: link.drive -> what it takes
MAKES: Mapping[str, Make] = {
    "moteus": Make(
        1024,
        _stored_by_moteus,
        _written_for_moteus,
        "turn",
        "N m",
        lambda _drive: (1.0, 1.0),
        "moteus_tool --restore-config writes it",
    ),
    "odrive": Make(
        3600,
        _stored_by_odrive,
        _written_for_odrive,
        "turn",
        "N m",
        lambda _drive: (1.0, 1.0),
        "set_anticogging_value(index, torque), which firmware needs to have",
    ),
    "cia402": Make(
        1024,
        _stored_by_host,
        _written_for_cia402,
        "counts",
        "thousandths",
        _cia402_units,
        "the host sends it as 0x60B2",
    ),
}


def friction_text(make: Make, drive: DriveOfAxis, table: FrictionTable) -> str:
    """Rows `rate, dry, viscous` in the drive's units and its own sign of rotation, rising."""
    per_turn, per_nm = make.units(drive)
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow((f"rate_{make.position_unit}_s", f"dry_{_word(make)}", f"viscous_{_word(make)}"))
    size, sign = abs(drive.shaft_per_joint) * per_nm, drive.section.sign
    rows = [
        (drive.shaft_turns_s(float(rate)) * per_turn, dry * size, sign * viscous * size)
        for rate, dry, viscous in zip(table.rates, table.dry, table.viscous, strict=True)
    ]
    writer.writerows([f"{value:.9g}" for value in row] for row in sorted(rows))
    return text.getvalue()


def share_text(make: Make, drive: DriveOfAxis, table: FrictionTable) -> str:
    """Rows `position, share of the dry torque` in the drive's units."""
    per_turn, _ = make.units(drive)
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow((f"position_{make.position_unit}", "share_of_dry"))
    rows = sorted(
        (drive.shaft_turns(float(q)) * per_turn, share)
        for q, share in zip(table.places, table.share_of_dry, strict=True)
    )
    writer.writerows([f"{value:.9g}" for value in row] for row in rows)
    return text.getvalue()


def _word(make: Make) -> str:
    return make.torque_unit.replace("N m", "nm")
