"""`gimbal-hil init`: files of a user's own antenna from a few numbers, asked for or given as options."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from firmware_protocol.json_object import Json

if TYPE_CHECKING:
    from gimbal_hil.surface.starting import AntennaDescription, AxisDescription
    from sim_backend.model import ModelKind

_EACH = "AXIS=NUMBER"
#: option -> field of an axis, what is asked, whether a linear axis has it
_NUMBERS = {
    "mass": ("mass_kg", "mass, kg"),
    "inertia": ("inertia_kg_m2", "inertia of this body about the axis, kg m2"),
    "cog": ("offset_m", "centre of gravity off the axis, m"),
    "coulomb": ("coulomb_nm", "Coulomb friction, N m"),
    "breakaway": ("breakaway_nm", "break-away torque, N m"),
    "viscous": ("viscous_nm_s", "viscous friction, N m s/rad"),
    "torque": ("torque_nm", "largest torque, N m"),
    "torque_constant": ("torque_constant_nm_a", "torque of one ampere, N m/A"),
    "rate_limit": ("rate_rad_s", "largest rate, rad/s"),
    "encoder": ("encoder_counts", "encoder counts a turn (a millimetre on a linear axis)"),
}
#: what is asked for when nobody said --yes; the rest has options only
_ASKED = ("mass", "inertia", "breakaway", "torque", "rate_limit", "encoder")
#: what turns, and a carriage on a linear axis has not
_OF_TURNING = ("inertia", "cog")
#: what an air bearing, or a balanced body, has none of
_MAY_BE_ZERO = ("cog", "coulomb", "breakaway", "viscous")


@dataclass(frozen=True)
class AntennaOptions:
    """What somebody says of an antenna; a number of an axis is a word AXIS=NUMBER."""

    kind: Annotated[str | None, typer.Option(help="gimbal (two axes), rotary or linear (one).")] = None
    axes: Annotated[str | None, typer.Option(metavar="NAME,NAME", help="Names, the carrying axis first.")] = None
    link: Annotated[
        str | None,
        typer.Option(
            help="virtual, unix:PATH, serial:PORT, socketcan:CHANNEL, slcan:PORT; moteus:, odrive: or cia402:CHANNEL "
            "(can0, or a path for simulated drives)."
        ),
    ] = None
    rate: Annotated[float | None, typer.Option(metavar="HZ", help="Control rate.", min=10.0, max=20000.0)] = None
    mass: Annotated[list[str] | None, typer.Option(metavar=_EACH, help="kg.")] = None
    inertia: Annotated[list[str] | None, typer.Option(metavar=_EACH, help="kg m2, of that body alone.")] = None
    cog: Annotated[list[str] | None, typer.Option(metavar=_EACH, help="Centre of gravity off the axis, m.")] = None
    coulomb: Annotated[list[str] | None, typer.Option(metavar=_EACH, help="Sliding friction, N m (N).")] = None
    breakaway: Annotated[list[str] | None, typer.Option(metavar=_EACH, help="Break-away torque, N m (N).")] = None
    viscous: Annotated[list[str] | None, typer.Option(metavar=_EACH, help="N m s/rad (N s/m).")] = None
    torque: Annotated[list[str] | None, typer.Option(metavar=_EACH, help="Largest torque, N m (N).")] = None
    torque_constant: Annotated[
        list[str] | None,
        typer.Option(metavar=_EACH, help="Torque of one ampere, N m/A (N/A), for logs of currents: 8.27 / KV."),
    ] = None
    rate_limit: Annotated[list[str] | None, typer.Option(metavar=_EACH, help="Largest rate, rad/s.")] = None
    travel: Annotated[list[str] | None, typer.Option(metavar="AXIS=LOW..HIGH", help="Soft limits, rad.")] = None
    up: Annotated[
        str | None,
        typer.Option(
            metavar="SIGN",
            help="positive or negative: which inner angles look up; without it those of which --travel has more, "
            "negative where both are the same.",
        ),
    ] = None
    tilt: Annotated[
        float | None,
        typer.Option(
            metavar="DEG",
            help="How one axis alone lies: a rotary one from the vertical (90: level, which is assumed), a linear one "
            "from the horizontal (0).",
            min=-90.0,
            max=90.0,
        ),
    ] = None
    encoder: Annotated[list[str] | None, typer.Option(metavar=_EACH, help="Counts a turn (a mm).")] = None
    gyro: Annotated[bool, typer.Option("--gyro/--no-gyro", help="Whether the antenna has rate gyros.")] = True


def command(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Folder for the files.")],
    told: AntennaOptions,
    yes: Annotated[bool, typer.Option("--yes", help="Ask nothing: what is not given is assumed.")] = False,
    force: Annotated[bool, typer.Option("--force", help="Overwrite what is in the folder.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print what was written as one JSON object.")] = False,
) -> int:
    """Write configuration, model, a first plan and a page of next commands for an antenna of your own.

    Options give the numbers (`--torque azimuth=15 --torque elevation=6`); in a terminal the rest is asked for.
    """
    import json

    from firmware_protocol.errors import EXIT_DONE
    from gimbal_hil.surface.cli.next_line import print_next
    from gimbal_hil.surface.starting import first_command, write_antenna

    antenna = _described(folder, told, _asker(yes))
    written = write_antenna(antenna, folder, force)
    following = first_command(antenna, folder)
    if as_json:
        print(json.dumps({"files": [str(path) for path in written], "next": following}))
    else:
        shown = ", ".join(path.name for path in written if path.parent == folder)
        print(f"{folder}: {shown}")
        print_next(following)
    return EXIT_DONE


Asker = Callable[[str, str], str]


def _asker(yes: bool) -> Asker:
    """Asks a question with the answer that stands when nothing is said; nobody is asked with --yes."""
    from firmware_protocol.errors import BadInputError

    if yes:
        return lambda _question, usual: usual
    if not sys.stdin.isatty():
        raise BadInputError("init", "has nobody to ask: this is no terminal", "--yes, and options for what is known")
    return lambda question, usual: str(typer.prompt(question, default=usual, err=True))


def _described(folder: Path, told: AntennaOptions, ask: Asker) -> AntennaDescription:
    from firmware_protocol.errors import BadInputError
    from gimbal_hil.surface.starting import (
        AntennaDescription,
        parse_link,
        usual_boresight,
        usual_names,
        usual_tilt_deg,
    )
    from sim_backend.boresight import Boresight
    from sim_backend.model import ModelKind

    word = told.kind or ask("kind (gimbal, rotary, linear)", ModelKind.GIMBAL.value)
    what = next((one for one in ModelKind if one.value == word), None)
    if what is None:
        raise BadInputError("--kind", f"no kind {word!r}", ", ".join(ModelKind))
    names = _names(told.axes or ask("axes, the carrying one first", ",".join(usual_names(what))), what)
    chosen = parse_link(told.link or (ask("link", "virtual") if what is ModelKind.GIMBAL else "virtual"))
    numbers = {option: _by_axis(getattr(told, option), names, option) for option in _NUMBERS}
    limits = {axis: _range(text) for axis, text in _pairs(told.travel, names, "--travel").items()}
    sections = tuple(_axis(name, place, what, numbers, limits, ask) for place, name in enumerate(names))
    # drives of other makes tell no inertial rate
    has_gyro = told.gyro and not chosen.is_drives
    looks = (
        usual_boresight(sections)
        if told.up is None
        else next((one for one in Boresight if one.raises == told.up), None)
    )
    if looks is None:
        raise BadInputError("--up", f"is {told.up!r}", "positive or negative")
    name, rate_hz = folder.absolute().name, told.rate or chosen.rate_hz
    tilt_deg = _tilt(what, told.tilt, ask)
    tilt_told = told.tilt is not None or tilt_deg != usual_tilt_deg(what)
    return AntennaDescription(name, what, sections, chosen, rate_hz, has_gyro, looks, tilt_deg, tilt_told)


def _tilt(kind: ModelKind, told: float | None, ask: Asker) -> float:
    from firmware_protocol.errors import BadInputError
    from gimbal_hil.surface.starting import usual_tilt_deg
    from sim_backend.model import ModelKind

    if kind is ModelKind.GIMBAL:
        if told is not None:
            raise BadInputError("--tilt", "is nothing that a gimbal has", "base: of its model file")
        return 0.0
    usual = usual_tilt_deg(kind)
    if told is not None:
        return told
    text = (
        "slope of the axis, deg" if kind is ModelKind.LINEAR else "tilt of the axis from the vertical, deg (90: level)"
    )
    answer = ask(text, f"{usual:g}")
    try:
        tilt = float(answer)
    except ValueError:
        tilt = math.nan
    if not -90.0 <= tilt <= 90.0:
        raise BadInputError(text, f"{answer!r} is no such angle", "-90 to 90")
    return tilt


def _names(text: str, kind: ModelKind) -> tuple[str, ...]:
    from firmware_protocol.errors import BadInputError
    from gimbal_hil.pages.report import counted
    from gimbal_hil.surface.starting import usual_names

    names = tuple(name.strip() for name in text.split(","))
    usual = usual_names(kind)
    if len(names) != len(usual) or len(set(names)) != len(names):
        raise BadInputError(
            "--axes", f"{text!r}", f"{counted(len(usual), 'name')} for a {kind}, such as {','.join(usual)}"
        )
    return names


def _axis(
    name: str, place: int, kind: ModelKind, numbers: dict[str, dict[str, float]], travel: Json, ask: Asker
) -> AxisDescription:
    from firmware_protocol.errors import BadInputError
    from gimbal_hil.surface.starting import AxisDescription, usual_axis
    from sim_backend.model import ModelKind

    told: Json = {_NUMBERS[option][0]: by_axis.get(name) for option, by_axis in numbers.items()}
    without = _OF_TURNING if kind is ModelKind.LINEAR else ()
    for option in without:
        if told[_NUMBERS[option][0]] is not None:
            raise BadInputError(f"--{option}", "is nothing that a linear axis has", f"--mass {name}=KG")
    for option in (one for one in _ASKED if one not in without):
        key, text = _NUMBERS[option]
        if told[key] is None:
            standing = usual_axis(AxisDescription(name, **told), kind, place)
            usual = f"{getattr(standing, key):.4g}"
            answer = ask(f"{name}: {text}", usual)
            if answer != usual:
                told[key] = _number(answer, f"{name}: {text}", option in _MAY_BE_ZERO)
    return usual_axis(AxisDescription(name, **told, travel_rad=travel.get(name)), kind, place)


def _pairs(words: list[str] | None, names: tuple[str, ...], option: str) -> dict[str, str]:
    from firmware_protocol.errors import BadInputError

    found = {}
    for word in words or ():
        axis, _, text = word.partition("=")
        if axis not in names:
            raise BadInputError(option, f"no axis {axis!r}", " or ".join(f"{name}=..." for name in names))
        found[axis] = text
    return found


def _by_axis(words: list[str] | None, names: tuple[str, ...], option: str) -> dict[str, float]:
    spelled, zero = f"--{option.replace('_', '-')}", option in _MAY_BE_ZERO
    return {axis: _number(text, f"{spelled} {axis}", zero) for axis, text in _pairs(words, names, spelled).items()}


def _number(text: str, where: str, may_be_zero: bool) -> float:
    from firmware_protocol.errors import BadInputError

    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not (math.isfinite(value) and (value > 0.0 or (may_be_zero and value == 0.0))):
        raise BadInputError(
            where, f"{text!r} is not a number that fits", "zero or more" if may_be_zero else "a positive number"
        )
    return value


def _range(text: str) -> tuple[float, float]:
    from firmware_protocol.errors import BadInputError

    low, _, high = text.partition("..")
    try:
        found = float(low), float(high)
    except ValueError:
        raise BadInputError("--travel", f"{text!r} is no range", "LOW..HIGH in rad, as in -0.3..1.6") from None
    if not found[0] <= 0.0 <= found[1] or found[0] == found[1]:
        expected = "LOW..HIGH in rad with LOW <= 0 <= HIGH, as in -0.3..1.6 or 0..1.57"
        raise BadInputError("--travel", f"{text!r} does not hold zero", expected)
    return found
