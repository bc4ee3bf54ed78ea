"""What `gimbal-hil point` is told: the target, the daemon or the virtual antenna that points, drawn flights."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from gimbal_hil.surface.cli.completion import model_names

_DURATION_S = 60.0


@dataclass(frozen=True)
class CertifyOptions:
    """Drawn flights in place of one target."""

    certify: Annotated[
        int | None,
        typer.Option(
            metavar="FLIGHTS",
            help="No target: so many drawn flights of --duration (10000 for a certificate) with errors of navigation; "
            "the share of time within 0.2 degrees, and whether mute came within 100 ms in all.",
            min=1,
        ),
    ] = None
    navigation: Annotated[
        Path | None, typer.Option(help="With --certify: file with the errors of your navigation (YAML).")
    ] = None
    workers: Annotated[int, typer.Option(help="With --certify: processes.", min=1, max=256)] = 1
    resume: Annotated[
        bool,
        typer.Option("--resume", help="With --certify: go on in --out; FLIGHTS may be more than before."),
    ] = False


@dataclass(frozen=True)
class SkyOptions:
    """What is pointed at, from where, when and for how long."""

    target: Annotated[
        str | None,
        typer.Option(
            help="azel:AZIMUTH,ELEVATION (degrees from true north, above the horizon), geo:LONGITUDE, tle:FILE, or a "
            "CSV file with time_s, azimuth_deg, elevation_deg."
        ),
    ] = None
    position: Annotated[
        str | None, typer.Option(metavar="LAT,LON,ALT", help="Where the aircraft is: degrees, m above the ellipsoid.")
    ] = None
    moving: Annotated[
        str | None, typer.Option(metavar="SPEED,TRACK", help="How it moves over ground: m/s, degrees from north.")
    ] = None
    at: Annotated[
        str | None, typer.Option(metavar="UTC", help="The sky of this time at the start, not of now; ISO 8601.")
    ] = None
    duration: Annotated[float, typer.Option(help="Seconds to hold it.", min=1.0, max=7200.0)] = _DURATION_S


@dataclass(frozen=True)
class PointingDaemonOptions:
    """The daemon that points, and how it ends."""

    stow: Annotated[bool, typer.Option("--stow", help="With --run: joints into the stow, then torque off.")] = False
    stay: Annotated[
        bool, typer.Option("--stay", help="With --run: hold the joints at the end where they are, no stow.")
    ] = False
    run: Annotated[Path | None, typer.Option(help="Run folder of a running daemon: in real time through it.")] = None


@dataclass(frozen=True)
class VirtualOptions:
    """The virtual antenna that points where no daemon does, and the motion of its base."""

    config: Annotated[
        Path | None, typer.Option(help="Without --run: configuration; without it the shipped virtual antenna.")
    ] = None
    model: Annotated[
        str | None,
        typer.Option(
            autocompletion=model_names,
            help="Without --run: model of the virtual antenna; without it that of --config, or realistic.",
        ),
    ] = None
    base: Annotated[
        str | None,
        typer.Option(
            help="Motion of the virtual antenna's base: turbulence, severe_turbulence, manoeuvre, swing, or a CSV "
            "file; with --run the one that `plant --base` serves, for the true error."
        ),
    ] = None
    seed: Annotated[int, typer.Option(help="Seed of noise and turbulence.", min=0, max=2**31 - 1)] = 1
