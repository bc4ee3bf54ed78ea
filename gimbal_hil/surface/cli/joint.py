"""`gimbal-hil joint`: one joint of an arm as a log of its own, what the other links do to it subtracted."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from firmware_protocol.places import require_new
from gimbal_hil.surface.cli.log_options import COLUMN_HELP, COLUMN_PAIR

#: options that take several values after one another
MANY_VALUED = ("--column", "--held")


@dataclass(frozen=True)
class ArmLogOptions:
    """How the log of an arm is read."""

    column: Annotated[list[str] | None, typer.Option(metavar=COLUMN_PAIR, help=COLUMN_HELP)] = None
    held: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME=POSITION", help="A joint that is not in the log and stands, rad or m."),
    ] = None
    resample: Annotated[bool, typer.Option("--resample", help="Accept a log of uneven time.")] = False
    rate: Annotated[
        float | None, typer.Option(metavar="HZ", help="Rate of the grid, or of rows that have no times.")
    ] = None
    drop_invalid: Annotated[
        bool, typer.Option("--drop-invalid", help="Accept a log with invalid rows and drop those.")
    ] = False


def command(
    log: Annotated[Path, typer.Argument(metavar="LOG", help="Positions of all joints and the torque of one.")],
    urdf: Annotated[Path, typer.Option(metavar="FILE", help="The arm: links with masses and inertias.")],
    joint: Annotated[str, typer.Option(metavar="NAME", help="The joint, by its name in the URDF.")],
    out: Annotated[Path, typer.Option(metavar="FILE", help="The joint's own log: .csv, .parquet or .npz.")],
    reading: ArmLogOptions,
    as_json: Annotated[bool, typer.Option("--json", help="Print the answer as JSON.")] = False,
    force: Annotated[bool, typer.Option("--force", help="Overwrite the file.")] = False,
) -> int:
    """Take one joint out of a log of a whole arm: gravity and coupling of the other links become `torque_known`.

    What is written is a log for `identify`, `discrepancy` and `changed` with a model of one axis of that name.
    """
    import json

    from firmware_protocol.errors import EXIT_DONE
    from gimbal_hil.data.signals import ColumnMap, write_signals
    from gimbal_hil.surface.cli.following import after_joint
    from gimbal_hil.surface.cli.next_line import print_next
    from gimbal_hil.surface.library import joint_of_arm

    require_new(out.parent, force, out.name)
    found = joint_of_arm(
        log,
        urdf,
        joint,
        columns=ColumnMap.of_words(reading.column),
        held=_positions(reading.held),
        resample=reading.resample,
        drop_invalid=reading.drop_invalid,
        rate_hz=reading.rate,
    )
    write_signals(found.table, out, force=force)
    answer = {
        "joint": joint,
        "rows": len(found.table),
        "inertia": found.inertia,
        "torque_known_rms": found.known_rms,
        "torque_rms": found.commanded_rms,
        "notes": list(found.table.notes),
        "file": str(out),
    }
    if as_json:
        print(json.dumps(answer))
        return EXIT_DONE
    print(
        f"{out}: {len(found.table)} rows of {joint}; {found.known_rms:.4g} of {found.commanded_rms:.4g} N m rms are "
        f"what other links ask for\nits model: inertia {found.inertia:.4g} kg m2 (mean pose), no weight"
    )
    print("\n".join(f"note: {note}" for note in found.table.notes))
    print_next(after_joint(joint, found.inertia, out))
    return EXIT_DONE


def _positions(words: list[str] | None) -> dict[str, float]:
    from firmware_protocol.errors import BadInputError

    found: dict[str, float] = {}
    for word in words or ():
        name, _, value = word.partition("=")
        try:
            found[name.strip()] = float(value)
        except ValueError:
            raise BadInputError(f"--held {word}", "is no position", "NAME=POSITION, rad or m") from None
    return found
