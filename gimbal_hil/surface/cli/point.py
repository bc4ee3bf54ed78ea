"""`gimbal-hil point`: a direction in space, a satellite or a list of directions, held from a moving base."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import UTC
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from firmware_protocol.places import require_new
from gimbal_hil.surface.cli.point_options import CertifyOptions, PointingDaemonOptions, SkyOptions, VirtualOptions

if TYPE_CHECKING:
    from datetime import datetime

    from gimbal_hil.data.runs import RecordedRun
    from gimbal_hil.loop.settings import DaemonSettings
    from gimbal_hil.loop.timing import ClockSync
    from gimbal_hil.pointing.following import BaseTruth, Flight, MuteChange, Target, Way
    from sim_backend.boresight import Boresight

#: no longer does a machine that is busy make a target wait
_LONGEST_LEAD_S = 60.0


@dataclass(frozen=True)
class _Asked:
    """A target that is to be held, from where and when, over which motion of the base."""

    target: str
    flight: Flight | None
    #: the sky of this time; None: of now
    at: str | None
    duration_s: float
    base: str | None
    seed: int


@dataclass(frozen=True)
class _Judged:
    """What is looked at afterwards."""

    log: RecordedRun
    target: Target
    first_row_tick: int
    span: tuple[int, int]
    changes: list[MuteChange]
    truth: BaseTruth | None
    where: str
    about: str
    looks: Boresight
    #: a target that moves in time: how well this machine knows the time
    sync: ClockSync | None = None
    #: what would point better
    advice: str = ""


def command(
    *,
    sky: SkyOptions,
    through: PointingDaemonOptions,
    antenna: VirtualOptions,
    flights: CertifyOptions,
    out: Annotated[Path | None, typer.Option(help="Folder of the page; without it a new one below ./runs.")] = None,
    force: Annotated[bool, typer.Option("--force", help="Overwrite what is in the folder.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as one JSON object.")] = False,
) -> int:
    """Hold a target in the sky and say how well: pointing error, mute signal, a page.

    Without --run the virtual antenna follows in lockstep. Azimuth is clockwise from true north, elevation above the
    horizon; the outer joint turns counter-clockwise seen from above, and `boresight` of the model file says which inner
    positions look up: negative ones with x, positive ones with -x. A target that the joints cannot reach is refused.
    """
    from firmware_protocol.errors import BadInputError
    from gimbal_hil.loop.timing import wall_clock_utc
    from gimbal_hil.pointing.following import flight_of

    run = through.run
    if through.stow:
        if run is None or sky.target is not None:
            raise BadInputError("--stow", "is for a running daemon and takes no target", "--stow --run RUN")
        return _stow(run, as_json)
    if flights.certify is not None:
        if run is not None or sky.target is not None or antenna.base is not None:
            raise BadInputError("--certify", "draws targets and bases", "no --run, no --target and no --base")
        return _certify(flights, sky.duration, antenna, out, force, as_json)
    if flights.resume:
        raise BadInputError("--resume", "is for drawn flights", "--certify FLIGHTS")
    if sky.target is None:
        raise BadInputError("--target", "is missing", "azel:120,35, geo:13.0E, tle:FILE or a CSV file; or --stow")
    if run is not None and (antenna.config is not None or antenna.model is not None):
        raise BadInputError("--run", "has a configuration and an antenna already", "no --config and no --model")
    folder = out or Path("runs") / f"point-{wall_clock_utc()[:19].replace(':', '').replace('-', '')}"
    require_new(folder, force, "pointing.json", "report.html")
    flight = None if sky.position is None else flight_of(sky.position, sky.moving)
    asked = _Asked(sky.target, flight, sky.at, sky.duration, antenna.base, antenna.seed)
    if run is None:
        judged, beyond = _in_lockstep(asked, antenna, folder, force)
    else:
        judged, beyond = _through_daemon(asked, run, through.stay)
    return _tell(judged, beyond, folder, run, as_json)


def _certify(
    flights: CertifyOptions, duration_s: float, antenna: VirtualOptions, out: Path | None, force: bool, as_json: bool
) -> int:
    from firmware_protocol.errors import BadInputError
    from gimbal_hil.loop.timing import wall_clock_utc
    from gimbal_hil.pointing.certifying import FLOWN_FILE
    from gimbal_hil.surface.cli.certify import CERTIFICATE_FILE, PAGE_FILE, CertifyChoice, certify

    if flights.resume and out is None:
        raise BadInputError("--resume", "does not say which flights", "--out with their folder")
    if flights.resume and force:
        raise BadInputError("--resume", "keeps what is there, --force does not", "one of the two")
    folder = out or Path("runs") / f"certificate-{wall_clock_utc()[:19].replace(':', '').replace('-', '')}"
    written = (CERTIFICATE_FILE, PAGE_FILE, FLOWN_FILE)
    require_new(folder, force or flights.resume, *written, instead="a new folder, --resume to go on")
    count = flights.certify or 1
    choice = CertifyChoice(
        count,
        duration_s,
        antenna.config,
        antenna.model,
        flights.navigation,
        antenna.seed,
        flights.workers,
        folder,
        flights.resume,
        as_json,
    )
    return certify(choice)


def _time_of(text: str | None) -> datetime:
    from datetime import datetime

    from firmware_protocol.errors import BadInputError

    if text is None:
        return datetime.now(UTC)
    try:
        found = datetime.fromisoformat(text)
    except ValueError:
        raise BadInputError("--at", f"is {text!r}", "a time as in 2026-11-22T12:00:00Z") from None
    return found.replace(tzinfo=UTC) if found.tzinfo is None else found.astimezone(UTC)


def _target(asked: _Asked, start: datetime, looks: Boresight) -> tuple[Target, Way, str]:
    """The target, its way, and what a reader of the page should know of both."""
    from gimbal_hil.pointing.following import next_pass, target_of, way_of

    text, flight, duration_s = asked.target, asked.flight, asked.duration_s
    target = target_of(text, flight, start)
    advice = next_pass(target, start, duration_s) if text.startswith("tle:") else ""
    target.require_visible(duration_s, advice)
    way = way_of(target, duration_s, looks)
    about = (
        f"Target {text}, sky of {start:%Y-%m-%d %H:%M:%S} UTC. Directions are geometric: no refraction, no light time. "
        f"Boresight {looks}: {looks.raises} inner positions look up."
    )
    if way.off_rad > 0.0:
        about += f" Rows every {way.row_s:g} s, joined by curves that are right to {1e6 * way.off_rad:.2g} urad."
    if flight is not None:
        about += (
            f" From latitude {flight.latitude_deg:g}, longitude {flight.longitude_deg:g} degrees, "
            f"{flight.altitude_m:g} m, at {flight.speed_m_s:g} m/s on a track of {flight.track_deg:g} degrees."
        )
    return target, way, about


def _in_lockstep(asked: _Asked, virtual: VirtualOptions, folder: Path, force: bool) -> tuple[_Judged, float]:
    import tempfile

    from gimbal_hil.data.runs import open_run
    from gimbal_hil.pointing.following import (
        STANDING,
        follow_in_lockstep,
        moved,
        mute_changes,
        require_reach,
        truth_of,
        truth_of_model,
    )
    from gimbal_hil.surface.cli.antenna_choice import settings_and_antenna
    from gimbal_hil.surface.cli.progress import ProgressBar

    settings, antenna = settings_and_antenna(virtual.config, virtual.model)
    duration, base, seed = asked.duration_s, asked.base, asked.seed
    looks = antenna.file.boresight
    target, way, about = _target(asked, _time_of(asked.at), looks)
    truth, moving_s = truth_of_model(antenna), duration + 30.0
    with tempfile.TemporaryDirectory() as place:
        if base is not None:
            antenna, truth = moved(antenna, base, moving_s, seed, Path(place)), truth_of(base, moving_s, seed, looks)
        require_reach(way, duration, settings, truth or STANDING, asked.target)
        with ProgressBar() as bar:
            follow_in_lockstep(way, duration, settings, antenna, seed, folder, force, bar)
    log = open_run(folder)
    told = [(event.tick, dict(event.data)) for event in log.events]
    first = next(e.tick for e in log.events if e.data.get("step") == "minute 1")
    span = (first, first + round(duration * settings.rate_hz) - 1)
    where = f"{antenna.name}, seed {seed}, in lockstep" + ("" if base is None else f", base {base}")
    changes = [one for one in mute_changes(told) if first <= one.tick <= span[1]]
    judged = _Judged(
        log, target, first, span, changes, truth, where, about, looks, advice=_advice(settings, base is not None)
    )
    return judged, settings.pointing.mute_beyond_rad


def _through_daemon(asked: _Asked, run: Path, stay: bool) -> tuple[_Judged, float]:
    import time

    from gimbal_hil.loop.timing import clock_sync
    from gimbal_hil.pointing.following import BASE_S, LEAD_S, PointingDaemon, mute_changes, require_reach, truth_of
    from gimbal_hil.surface.cli.progress import ProgressBar

    daemon = PointingDaemon(run)
    looks = daemon.looks
    at, duration = asked.at, asked.duration_s
    truth = None if asked.base is None else truth_of(asked.base, BASE_S, asked.seed, looks)
    # the sky of now moves with the clock; one that was asked for begins whenever it is asked
    sync = clock_sync() if at is None and asked.target.startswith("tle:") else None
    if sync is not None and not sync.synchronised:
        _say(f"caution: {sync.in_words()}: a low satellite is 2 degrees further on in a second")

    try:
        # a target that cannot be held is refused before anything moves; ticks tell the sky's time only afterwards
        _, way, _ = _target(asked, _time_of(at), looks)
        require_reach(way, duration, daemon.settings, daemon.base_now(), asked.target)
        clock = daemon.clock()
        lead_s, first = LEAD_S, 0
        while True:
            begun, first = time.monotonic(), clock.tick_after(lead_s)
            target, way, about = _target(asked, clock.time_of(first) if at is None else _time_of(at), looks)
            took_s = time.monotonic() - begun
            if at is not None:
                # the sky was asked for: it begins when its way is made
                first = clock.tick_after(LEAD_S)
            if at is not None or took_s < lead_s or lead_s > _LONGEST_LEAD_S:
                break
            # a machine that is busy needs longer for the way than was left: begin later, so that none of it is lost
            lead_s = LEAD_S + 2.0 * took_s
        stepped = clock.stepped_s if sync is not None else lambda: 0.0
        try:
            with ProgressBar() as bar:
                bar.begin("point", duration, 0.0)
                found = daemon.follow(way, first, duration, _say, lambda seconds: bar.at(target.name, seconds), stepped)
        except KeyboardInterrupt:
            daemon.stop()
            raise
        if stay:
            daemon.stay()
        else:
            daemon.stow(_say)
        log = daemon.log(found.first_tick, found.last_tick)
    finally:
        daemon.close()
    about += (
        f" The daemon's ticks were placed in time by looking at them, a quarter of the looks within "
        f"{1e3 * clock.spread_s:.1f} ms."
    )
    if sync is not None:
        about += f" When it began, {sync.in_words()}."
    changes = [one for one in mute_changes(found.events) if found.first_tick <= one.tick <= found.last_tick]
    judged = _Judged(
        log,
        target,
        first,
        (found.first_tick, found.last_tick),
        changes,
        truth,
        f"through the daemon of {run}",
        about,
        looks,
        sync,
        _advice(daemon.settings, asked.base is not None),
    )
    return judged, daemon.settings.pointing.mute_beyond_rad


def _advice(settings: DaemonSettings, moves: bool) -> str:
    """That loops follow a base where it was, where they do."""
    control = settings.model_control
    if not moves or (control is not None and control.extrapolate_base):
        return ""
    return (
        "These loops take the base's attitude as old as it arrives; loops that gimbal-hil tune --for pointing writes "
        "extrapolate it (model_control.extrapolate_base)."
    )


def _say(line: str) -> None:
    import sys

    print(line, file=sys.stderr, flush=True)


def _tell(judged: _Judged, beyond_rad: float, folder: Path, run: Path | None, as_json: bool) -> int:
    import json

    from firmware_protocol.errors import EXIT_DONE, EXIT_NO
    from gimbal_hil.pointing.following import HeldTarget, held_trace, pointing_figures, summary, write_page
    from gimbal_hil.surface.cli.following import after_point
    from gimbal_hil.surface.cli.next_line import print_next

    trace = held_trace(
        judged.log, judged.target, judged.first_row_tick, judged.span, judged.changes, judged.truth, judged.looks
    )
    figures = pointing_figures(trace, judged.changes, beyond_rad)
    about = f"{judged.about} {judged.advice}".strip()
    held = HeldTarget(judged.target.name, judged.where, about, judged.log.record.header.axes)
    page = write_page(folder / "report.html", held, trace, figures, judged.changes, beyond_rad)
    document: dict[str, object] = {"target": judged.target.name, "run": str(run or folder), **figures.as_dict()}
    document["boresight"] = judged.looks.value
    if judged.sync is not None:
        document["clock"] = {
            "synchronised": judged.sync.synchronised,
            "error_bound_s": judged.sync.error_bound_s,
            "age_s": judged.sync.age_s,
        }
    (folder / "pointing.json").write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")
    acquired = document["acquired_after_s"] is not None
    if as_json:
        print(json.dumps(document, allow_nan=False))
    else:
        print(summary(judged.target.name, figures))
        if judged.advice:
            print(f"  {judged.advice}")
        print(f"  report  {page}")
        print_next(after_point(folder, run))
    return EXIT_DONE if acquired and figures.followed_the_target else EXIT_NO


def _stow(run: Path, as_json: bool) -> int:
    import json

    from firmware_protocol.errors import EXIT_DONE
    from gimbal_hil.pointing.following import PointingDaemon
    from gimbal_hil.surface.cli.following import after_stow
    from gimbal_hil.surface.cli.next_line import print_next

    daemon = PointingDaemon(run)
    try:
        daemon.stow(_say)
    finally:
        daemon.close()
    if as_json:
        print(json.dumps({"stowed": True, "run": str(run)}))
    else:
        print("stowed, torque off")
        print_next(after_stow(run))
    return EXIT_DONE
