"""`gimbal-hil drive-tables`: a model's ripple and friction as tables that drives of other makes take."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from firmware_protocol.places import require_new

if TYPE_CHECKING:
    from gimbal_hil.knowledge.drive_tables import AxisTables, Motor, Rehearsed
    from sim_backend.model import AntennaModel

_EACH = "AXIS=NUMBER"


@dataclass(frozen=True)
class MotorOptions:
    """What a drive's motor and its commutation encoder are, by axis."""

    torque_constant: Annotated[
        list[str] | None, typer.Option(metavar=_EACH, help="moteus: N m at the rotor for one A of q current.")
    ] = None
    rotor_turns: Annotated[
        list[str] | None,
        typer.Option(
            metavar=_EACH,
            help="Turns of the commutation encoder for one of the drive's shaft; negative: backwards. 1 without it.",
        ),
    ] = None
    rotor_zero: Annotated[
        list[str] | None,
        typer.Option(metavar=_EACH, help="What that encoder reads (turns) where the drive's position is zero."),
    ] = None


def command(
    model: Annotated[Path, typer.Argument(help="Model file, e.g. the model.yaml of `discrepancy`.")],
    config: Annotated[Path, typer.Option(help="Configuration whose link names the drives (moteus, odrive, cia402).")],
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for the tables.")],
    motors: MotorOptions,
    rehearse: Annotated[
        bool, typer.Option("--rehearse", help="Try them on simulated drives: ripple and reversal with and without.")
    ] = False,
    force: Annotated[bool, typer.Option("--force", help="Overwrite what is in the folder.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as JSON.")] = False,
) -> int:
    """Write anticogging tables and friction feed-forward for the drives of a configuration, from a corrected model.

    What a drive's table cannot hold is listed with the reason.
    """
    from firmware_protocol.errors import EXIT_DONE, BadInputError
    from firmware_protocol.links import AdapterLinkConfig
    from gimbal_hil.knowledge.drive_tables import drive_tables
    from gimbal_hil.loop.settings import load_settings
    from gimbal_hil.surface.cli.following import after_drive_tables
    from gimbal_hil.surface.cli.next_line import print_next
    from sim_backend.model import load_model

    link = load_settings(config).link
    if not isinstance(link, AdapterLinkConfig):
        raise BadInputError(f"{config}: link.kind", "is no adapter", "adapter: drives of another make")
    about = load_model(model)
    tables = drive_tables(about, link, _motors(about.axes, motors))
    files = {name: text for one in tables for name, text in one.files.items()}
    for name in (*files, "drive_tables.json"):
        require_new(out, force, name, instead="another --out")
    tried = _rehearsed(about, link, tables) if rehearse else []
    document = {
        "model": str(model),
        "axes": [one.document for one in tables],
        "rehearsal": [vars(one) for one in tried],
    }
    out.mkdir(parents=True, exist_ok=True)
    for name, text in files.items():
        (out / name).write_text(text, encoding="utf-8")
    (out / "drive_tables.json").write_text(json.dumps(document, indent=2) + "\n", encoding="utf-8")
    if as_json:
        print(json.dumps({"out": str(out), **document}))
    else:
        for one in tables:
            print("\n".join(_lines(one)))
        for rehearsed in tried:
            print(_tried(rehearsed))
        print(f"written: {out}/drive_tables.json and {len(files)} tables")
        print_next(after_drive_tables(model, config, out, rehearse))
    return EXIT_DONE


def _motors(axes: tuple[str, ...], options: MotorOptions) -> dict[str, Motor]:
    from gimbal_hil.knowledge.drive_tables import Motor

    constants = _numbers("--torque-constant", options.torque_constant or [], axes)
    turns = _numbers("--rotor-turns", options.rotor_turns or [], axes)
    zeros = _numbers("--rotor-zero", options.rotor_zero or [], axes)
    return {axis: Motor(constants.get(axis), turns.get(axis, 1.0), zeros.get(axis, 0.0)) for axis in axes}


def _numbers(option: str, words: list[str], axes: tuple[str, ...]) -> dict[str, float]:
    """AXIS=NUMBER by axis; a table is divided by all of them but the zero."""
    import math

    from firmware_protocol.errors import BadInputError

    found = {}
    for word in words:
        axis, _, text = word.partition("=")
        try:
            number = float(text)
        except ValueError:
            number = math.nan
        if axis not in axes or not math.isfinite(number):
            raise BadInputError(option, f"is {word!r}", f"AXIS=NUMBER with an axis of the model: {', '.join(axes)}")
        if (option == "--torque-constant" and number <= 0.0) or (option == "--rotor-turns" and number == 0.0):
            expected = "above 0" if option == "--torque-constant" else "anything but 0"
            raise BadInputError(option, f"is {word!r}", expected)
        found[axis] = number
    return found


def _rehearsed(model: AntennaModel, link: object, tables: tuple[AxisTables, ...]) -> list[Rehearsed]:
    from firmware_protocol.links import AdapterLinkConfig
    from gimbal_hil.knowledge.drive_tables import rehearse
    from gimbal_hil.surface.cli.progress import ProgressBar

    assert isinstance(link, AdapterLinkConfig)
    tried = []
    with ProgressBar() as progress:
        progress.begin("trying the tables on simulated drives", len(tables), 0.0)
        for place, one in enumerate(tables):
            tried.append(rehearse(model, link, tables, place))
            progress.at(one.drive.axis, 1.0)
    return tried


def _lines(tables: AxisTables) -> list[str]:
    drive = tables.drive
    lines = [f"{drive.axis} ({tables.make} {drive.section.id}): {', '.join(sorted(tables.files))}"]
    lines += [f"  {one.item.name} ({one.item.value}): {one.reason}" for one in tables.approximated]
    lines += [f"  {one.item.name} ({one.item.value}) left out: {one.reason}" for one in tables.left_out]
    return lines


def _tried(one: Rehearsed) -> str:
    before, after = one.reversal_rad
    told = (
        f"{one.axis}: error about a reversal {1e6 * before:.3g} to {1e6 * after:.3g} urad ({before / after:.1f} to 1)"
    )
    if one.ripple_rad_s is not None and one.speed_rad_s is not None:
        before, after = one.ripple_rad_s
        told += (
            f", ripple at {one.speed_rad_s:.3g} rad/s {1e6 * before:.3g} to {1e6 * after:.3g} urad/s rms "
            f"({before / after:.1f} to 1)"
        )
    return told
