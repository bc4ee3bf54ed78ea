"""`gimbal-hil plant`: the virtual antenna on a serial, slcan or Unix-socket link, in real time, for a daemon in another
process.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gimbal_hil.surface.cli.completion import model_names

if TYPE_CHECKING:
    from firmware_protocol.links import CanLinkConfig
    from gimbal_hil.loop.settings import DaemonSettings
    from sim_backend.firmware_run import FirmwareRun
    from sim_backend.model import AntennaModel
    from sim_backend.server import DeviceServer, LockstepServer, Outlet, OutletKind

    Server = DeviceServer | LockstepServer


@dataclass(frozen=True)
class ServedOptions:
    """Which antenna is served, and where."""

    config: Annotated[
        Path | None, typer.Option(help="The daemon's configuration file: its rate, model, seed and link are used.")
    ] = None
    model: Annotated[
        str | None,
        typer.Option(
            autocompletion=model_names, help="Model file or name of a shipped model; goes before the configuration's."
        ),
    ] = None
    link: Annotated[
        str | None,
        typer.Option(
            help="serial, slcan (a pseudo-terminal), serial:PATH, slcan:PATH (the same under a lasting name), or "
            "unix:PATH."
        ),
    ] = None


@dataclass(frozen=True)
class PaceOptions:
    """What its time follows, and how long."""

    lockstep: Annotated[
        bool,
        typer.Option("--lockstep", help="Time goes on when a host in lockstep says so, and stands still otherwise."),
    ] = False
    duration: Annotated[float | None, typer.Option(help="Seconds to serve; without it until stopped.", min=0.0)] = None


def command(
    *,
    served: ServedOptions,
    pace: PaceOptions,
    base: Annotated[
        str | None,
        typer.Option(help="Motion of its base: turbulence, severe_turbulence, manoeuvre, swing, or a CSV file."),
    ] = None,
    seed: Annotated[int | None, typer.Option(help="Seed of the sensor noise.", min=0, max=2**31 - 1)] = None,
    ready_file: Annotated[
        Path | None, typer.Option(help="Write the path to connect to into this file once it can be connected to.")
    ] = None,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print two JSON objects, one a line: when ready, and the statistics.")
    ] = False,
) -> int:
    """Serve the virtual antenna's frames in real time. The host's set-point is the clock edge; without one the antenna
    goes on by itself. With --lockstep it waits for a daemon (or conformance) that is in lockstep too.

    Ctrl-C or SIGTERM ends it with 130, --duration with 0. Hosts may come, go and come back.
    """
    import sys

    from firmware_protocol.errors import EXIT_DONE, EXIT_INTERRUPTED, BadInputError
    from firmware_protocol.links import AdapterLinkConfig
    from gimbal_hil.loop.settings import load_settings, shipped_settings
    from gimbal_hil.surface.cli.following import after_plant
    from gimbal_hil.surface.cli.next_line import print_next
    from sim_backend.device import Device
    from sim_backend.firmware import close_firmware, run_firmware
    from sim_backend.server import DeviceServer, LockstepServer, join_bus, open_outlet

    settings = load_settings(served.config) if served.config else shipped_settings()
    antenna, noise_seed, firmware = _antenna_of(settings, served.model, base, seed)
    if served.link is None and isinstance(settings.link, AdapterLinkConfig):
        from gimbal_hil.surface.cli.plant_drives import serve_drives

        if pace.lockstep:
            raise BadInputError("--lockstep", "drives of another make have clocks of their own", "no --lockstep")
        return serve_drives(settings.link, antenna, noise_seed, pace.duration, as_json)
    place = _place_of(settings, served.link, str(served.config or "--link"))
    print("preparing the compiled antenna", file=sys.stderr, flush=True)
    Device(antenna, rate_hz=settings.rate_hz).tick()
    device: Device | None = None
    outlet = open_outlet(*place) if isinstance(place, tuple) else join_bus(place)
    try:
        serving = LockstepServer if pace.lockstep else DeviceServer
        device = run_firmware(firmware, antenna, settings.rate_hz, noise_seed)
        server = serving(device, outlet.link)
        with _signals_stop(server) as signals:
            _announce(outlet, antenna.name, settings.rate_hz, ready_file, as_json, pace.lockstep)
            if not as_json:
                print_next(after_plant(served.config, outlet.kind.value, outlet.path))
            _serve(server, pace.duration, pace.lockstep)
    finally:
        outlet.link.close()
        if device is not None:
            close_firmware(device)
        if ready_file is not None:
            ready_file.unlink(missing_ok=True)
    _tell_end(server, bool(signals), as_json)
    return EXIT_INTERRUPTED if signals else EXIT_DONE


def _tell_end(server: Server, interrupted: bool, as_json: bool) -> None:
    import json

    if as_json:
        print(json.dumps({"event": "done", "interrupted": interrupted, **server.statistics.as_dict()}))
    else:
        print("\n".join(_lines(server)))


@contextmanager
def _signals_stop(server: Server) -> Iterator[list[int]]:
    """SIGINT and SIGTERM end the serving; gives the list in which they are kept. The handlers before are put back."""
    import signal

    signals: list[int] = []

    def stop(number: int, _frame: object) -> None:
        signals.append(number)
        server.stop()

    before = {number: signal.signal(number, stop) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield signals
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _serve(server: Server, duration_s: float | None, lockstep: bool) -> None:
    from gimbal_hil.loop.timing import control_and_witness_cores, real_time

    if lockstep:
        server.serve(None if duration_s is None else round(duration_s * 1e9))
        return
    # on the core that a daemon of this machine leaves free, and behind it in priority
    with real_time(priority=55, core=control_and_witness_cores()[1]):
        server.serve(None if duration_s is None else round(duration_s * 1e9))


def _antenna_of(
    settings: DaemonSettings, model: str | None, base: str | None, seed: int | None
) -> tuple[AntennaModel, int, FirmwareRun]:
    """Model, on a base that moves as it is said, seed and firmware: the command line's, else the configuration's, else
    the shipped ones.
    """
    from gimbal_hil.loop.settings import EmbeddedAntenna
    from sim_backend.model import model_named

    embedded = settings.link.embedded if isinstance(settings.link, EmbeddedAntenna) else EmbeddedAntenna().embedded
    antenna, noise_seed = model_named(model or embedded.model), embedded.seed if seed is None else seed
    return antenna if base is None else _moved(antenna, base, noise_seed), noise_seed, embedded.firmware


def _moved(antenna: AntennaModel, base: str, seed: int) -> AntennaModel:
    """The antenna on a base that moves; a motion by name is a file that goes with this process."""
    import atexit
    import tempfile

    from gimbal_hil.pointing.following import BASE_S, moved

    folder = tempfile.TemporaryDirectory()
    atexit.register(folder.cleanup)
    return moved(antenna, base, BASE_S, seed, Path(folder.name))


def _place_of(settings: DaemonSettings, link: str | None, where: str) -> tuple[OutletKind, Path | None] | CanLinkConfig:
    """What to serve on: the command line's, else the other end of the link that the configuration gives its daemon,
    else serial.
    """
    from firmware_protocol.errors import BadInputError
    from firmware_protocol.links import CanLinkConfig, SerialLinkConfig, UnixLinkConfig
    from sim_backend.server import OutletKind, parse_outlet

    if link is not None:
        return parse_outlet(link)
    given = settings.link
    if isinstance(given, SerialLinkConfig) and "://" not in given.port:
        return OutletKind.SERIAL, Path(given.port)
    if isinstance(given, UnixLinkConfig) and not given.listen:
        return OutletKind.UNIX, given.path
    if isinstance(given, CanLinkConfig):
        return (OutletKind.SLCAN, Path(str(given.channel))) if given.interface == "slcan" else given
    if isinstance(given, SerialLinkConfig | UnixLinkConfig):
        raise BadInputError(
            f"{where}: link", "has no other end that could be served here", "--link serial, slcan or unix:PATH"
        )
    return OutletKind.SERIAL, None


def _announce(
    outlet: Outlet, model: str, rate_hz: float, ready_file: Path | None, as_json: bool, lockstep: bool
) -> None:
    import json
    import os

    from firmware_protocol.errors import BadInputError

    if ready_file is not None:
        fresh = ready_file.with_name(f".{ready_file.name}.{os.getpid()}")
        try:
            fresh.write_text(f"{outlet.path}\n")
            fresh.replace(ready_file)
        except OSError as error:
            raise BadInputError(
                f"--ready-file {ready_file}",
                f"cannot be written ({error.strerror})",
                "a file in a folder that there is",
            ) from None
    if as_json:
        ready = {
            "event": "ready",
            "link": outlet.kind.value,
            "path": outlet.path,
            "model": model,
            "rate_hz": rate_hz,
            "lockstep": lockstep,
            "pid": os.getpid(),
        }
        print(json.dumps(ready), flush=True)
    else:
        pace = " in lockstep" if lockstep else ""
        print(f"{model} at {rate_hz:g} Hz{pace} on {outlet.kind.value} {outlet.path}; Ctrl-C ends it", flush=True)


def _lines(server: Server) -> list[str]:
    s = server.statistics
    return [
        f"ticks: {s.ticks_by_set_point} by set-points, {s.ticks_by_own_clock} by own clock; skipped {s.skipped} "
        f"({s.passed_over} of them made up for), merged {s.merged}",
        f"frames: {s.frames_received} received, {s.frames_sent} sent, {s.frames_dropped} dropped, "
        f"{s.malformed + s.bad_frames} bad",
        f"drive: {s.state.replace('_', ' ')}, fault {s.fault}; refused set-points {s.refused_set_points}; link lost "
        f"{s.losses} times",
    ]
