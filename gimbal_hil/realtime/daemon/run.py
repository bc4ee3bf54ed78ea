"""One run of the daemon: service, witness, link, host and tick engine put together, and taken apart again whatever
happens.
"""

from __future__ import annotations

import contextlib
import json
import math
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from firmware_protocol import receiver
from firmware_protocol.adapters import Gives, gives_of
from firmware_protocol.errors import EXIT_SAFETY_STOP, BadInputError, GimbalHilError
from firmware_protocol.json_object import Json
from firmware_protocol.links import PATIENCE_S, AdapterLinkConfig, Link
from gimbal_hil.data.runs import RunHeader, newest_events_file, read_header
from gimbal_hil.loop.host import FirstTest, Host
from gimbal_hil.loop.settings import DaemonSettings, EmbeddedAntenna, FirstTestChoice, host_configuration
from gimbal_hil.loop.timing import (
    Clock,
    Duration,
    Granted,
    LockstepClock,
    MonotonicClock,
    ThreadUsage,
    TickEngine,
    TickStatistics,
    WitnessProcess,
    control_and_witness_cores,
    real_time,
)
from gimbal_hil.realtime.daemon.antenna_link import EmbeddedLink, embedded_antenna, embedded_model
from gimbal_hil.realtime.daemon.control_loop import ControlLoop, LoopEnd, LoopTime
from gimbal_hil.realtime.daemon.first_opening import opener_of
from gimbal_hil.realtime.daemon.heartbeat import Heartbeat
from gimbal_hil.realtime.daemon.link_keeper import LinkKeeper
from gimbal_hil.realtime.daemon.lockstep_link import LockstepLink, open_in_lockstep
from gimbal_hil.realtime.daemon.service_end import ServiceEnd
from gimbal_hil.realtime.observing import observed_model
from gimbal_hil.realtime.service import ServiceProcess, ServiceSettings
from gimbal_hil.realtime.telemetry import Telemetry
from sim_backend.device import Device
from sim_backend.firmware import run_firmware
from sim_backend.model import AntennaModel
from sim_backend.observer import INPUTS, ModelObserver

#: sleeping costs the kernel's way of waking up and cold caches; waiting the last part awake costs a twentieth of a core
#: at 1 kHz
DEFAULT_SPIN_US = 50.0
_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


@dataclass(frozen=True, slots=True)
class DaemonOptions:
    """What a caller chooses besides the configuration. `duration_s` None runs until stopped; `page_port` 0 takes any
    free port.
    """

    run: Path
    force: bool = False
    duration_s: float | None = None
    lockstep: bool = False
    #: in lockstep over a link: how long an answer of the antenna is waited for; 0 waits for ever
    patience_s: float = PATIENCE_S
    spin_us: float = DEFAULT_SPIN_US
    page_port: int | None = None
    quiet: bool = False
    #: wait for the link whatever is wrong with it
    wait: bool = False
    #: a virtual antenna in this process follows this model from so many seconds on
    then: tuple[AntennaModel, float] | None = None


@dataclass(frozen=True, slots=True)
class DaemonReport:
    """How a run of the daemon went."""

    run: Path
    ending: LoopEnd
    statistics: TickStatistics
    granted: Granted | None
    frames: Json
    link_losses: int
    recorded: bool

    def as_dict(self) -> Json:
        """For JSON."""
        return {
            "run": str(self.run),
            "exit_code": self.ending.exit_code,
            "reason": self.ending.reason,
            "recorded": self.recorded,
            "ticks": self.statistics.as_dict(),
            "frames": self.frames,
            "link_losses": self.link_losses,
            "real_time": self.granted.as_dict() if self.granted else None,
        }


@dataclass(slots=True)
class _Parts:
    """What stands before the first tick."""

    clock: Clock
    loop: ControlLoop
    engine: TickEngine
    host: Host
    link: LinkKeeper
    telemetry: Telemetry
    ending: LoopEnd = field(default_factory=lambda: LoopEnd(EXIT_SAFETY_STOP, "the control process failed"))


def run_daemon(settings: DaemonSettings, options: DaemonOptions) -> DaemonReport:
    """Run until the duration is over, an operator or a signal ends it, or something that keeps it safe is gone.

    Raises BadInputError before anything moves when the run folder or a model cannot be used.
    """
    opener, embedded, remote = _link_opener(settings, options)
    if embedded is not None:
        settings = settings.for_axes(embedded.device.model.axes, embedded.device.model.where)
    elif options.then is not None:
        raise BadInputError("--then", "needs a virtual antenna in this process", "a configuration with one")
    settings = settings.with_model()
    observed = observed_model(settings)
    later = _later_antenna(settings, options)
    period = Duration.of_seconds(settings.step_s)
    service = ServiceProcess(options.run, _header(settings, period, options), _service_settings(settings, options))
    with contextlib.ExitStack() as stack:
        stack.callback(service.close)
        control_core, witness_core = control_and_witness_cores()
        witness = None if options.lockstep else stack.enter_context(WitnessProcess(witness_core))
        _compile(settings, embedded, observed)
        service.wait_ready()
        clock: Clock = LockstepClock() if options.lockstep else MonotonicClock(Duration(round(options.spin_us * 1000)))
        usage = ThreadUsage()
        stack.callback(usage.close)
        telemetry = Telemetry(service.telemetry, options.lockstep)
        host = Host(host_configuration(settings), settings.axis_names)

        def tell_link(opened: bool, text: str) -> None:
            loop.tell_link(opened, text)
            if remote is not None and not opened:
                loop.give_up(text)

        link = LinkKeeper(clock, opener, tell_link, usage.add_bus_wait)
        stack.callback(link.close)
        ticks = None if options.duration_s is None else max(1, Duration.of_seconds(options.duration_s) // period)
        # in lockstep the ticks wait for the service instead
        timeout = Duration.of_seconds(settings.supervisor.service_timeout_s)
        heartbeat = None if options.lockstep else Heartbeat(service.progress, timeout)
        pass_over = embedded.pass_over if embedded else None
        is_tried = _is_tried_first(settings, options.lockstep)
        tried = FirstTest(host, settings.step_s, _has_gyro(settings), _known_within(settings)) if is_tried else None
        service_end = ServiceEnd(telemetry, service.commands, service.alive, heartbeat)
        loop = ControlLoop(host, link, service_end, LoopTime(clock, period, ticks), pass_over, tried)
        if later is not None and embedded is not None:
            embedded.becomes(*later, loop.tell_note)
        engine = TickEngine(
            clock,
            period,
            loop.step,
            None if options.lockstep else usage,
            witness.page if witness else None,
            loop.tell_miss,
        )
        parts = _Parts(clock, loop, engine, host, link, telemetry)
        if witness is not None:
            witness.wait_awake()
        if not options.quiet:
            _say_where(options.run, service.page_url, settings, options.lockstep)
        granted = _run(parts, None if options.lockstep else control_core, options.lockstep, remote)
        # it ends at the last word, maybe before this process comes to ask for it
        recorded = service.close()
        if not recorded:
            _note_in_log(options.run, engine.statistics.ticks, parts.ending)
            if parts.ending.exit_code != EXIT_SAFETY_STOP:
                parts.ending = LoopEnd(EXIT_SAFETY_STOP, f"recording failed; {parts.ending.reason}".removesuffix("; "))
    return DaemonReport(
        options.run, parts.ending, engine.statistics, granted, _frame_counts(host), link.losses, recorded
    )


def _run(parts: _Parts, core: int | None, lockstep: bool, remote: LockstepLink | None) -> Granted | None:
    """The ticks, with signals turned into a stop and the last word always said."""
    granted: Granted | None = None
    try:
        with _signals_to(parts.loop, remote), contextlib.ExitStack() as stack:
            if not lockstep:
                granted = stack.enter_context(real_time(core=core))
                for refused in granted.refused:
                    parts.loop.tell_note(f"not granted, ticks may be late: {refused}")
            parts.engine.run()
        parts.ending = parts.loop.ending or parts.ending
    except BaseException as error:
        parts.ending = LoopEnd(EXIT_SAFETY_STOP, f"the control process failed: {error!r}")
        parts.loop.last_words()
        raise
    finally:
        parts.telemetry.end(parts.ending.exit_code, parts.ending.reason)
    return granted


@contextlib.contextmanager
def _signals_to(loop: ControlLoop, remote: LockstepLink | None) -> Iterator[None]:
    """Signals stop the loop; outside the main thread there are none to take."""

    def interrupt(number: int, _frame: object) -> None:
        loop.interrupt(signal.Signals(number).name)
        if remote is not None:
            remote.hurry()

    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = {number: signal.signal(number, interrupt) for number in _SIGNALS}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _link_opener(
    settings: DaemonSettings, options: DaemonOptions
) -> tuple[Callable[[], Link], EmbeddedLink | None, LockstepLink | None]:
    """A function that opens the configured link; the virtual antenna is built, one in lockstep begun with, once and
    now.
    """
    link = settings.link
    if isinstance(link, EmbeddedAntenna):
        embedded = embedded_antenna(settings, link)
        return lambda: embedded, embedded, None
    if options.lockstep:
        remote = open_in_lockstep(link, options.patience_s)
        return lambda: remote, None, remote
    return opener_of(link, options.wait), None, None


def _later_antenna(settings: DaemonSettings, options: DaemonOptions) -> tuple[Device, int] | None:
    """The antenna that the embedded one becomes, made before time counts, and from which tick on."""
    if options.then is None or not isinstance(settings.link, EmbeddedAntenna):
        return None
    model, after_s = options.then
    embedded = settings.link.embedded
    device = run_firmware(embedded.firmware, model, settings.rate_hz, embedded.seed)
    return device, round(after_s * settings.rate_hz)


def _compile(settings: DaemonSettings, embedded: EmbeddedLink | None, observed: AntennaModel | None) -> None:
    """Load what is compiled (meanwhile the service starts) before time counts; throwaway copies, so that nothing has
    happened yet.
    """
    if embedded is not None:
        Device(embedded.device.model, rate_hz=settings.rate_hz).tick()
    if observed is not None:
        # for the service, which would do it while ticks run
        ModelObserver(observed, settings.rate_hz, 1.0).observe(np.zeros((1, INPUTS)))
    host = Host(host_configuration(settings), settings.axis_names)
    for tick in range(2):
        host.tick(tick, 0, b"")
    host.events()


def _is_tried_first(settings: DaemonSettings, lockstep: bool) -> bool:
    choice = settings.supervisor.first_test
    # an antenna whose time waits has no mass
    real = choice is FirstTestChoice.REAL_LINK and not isinstance(settings.link, EmbeddedAntenna) and not lockstep
    return real or choice is FirstTestChoice.ALWAYS


def _has_gyro(settings: DaemonSettings) -> bool:
    link = settings.link
    return not isinstance(link, AdapterLinkConfig) or all(
        Gives.GYRO in gives_of(link.drive, drive) for drive in link.drives
    )


def _known_within(settings: DaemonSettings) -> list[float]:
    """The factors within which the inertias are known; an axis of which nothing is expected is not tested."""
    expected = [axis.expectation for axis in settings.axes.values()]
    return [math.inf if one is None else one.inertia_within for one in expected]


def _service_settings(settings: DaemonSettings, options: DaemonOptions) -> ServiceSettings:
    recording = settings.recording
    return ServiceSettings(
        options.force,
        recording.frames,
        recording.every_ticks,
        settings.operator.enabled,
        options.page_port,
        options.quiet,
    )


def _header(settings: DaemonSettings, period: Duration, options: DaemonOptions) -> RunHeader:
    link = settings.link
    return RunHeader(
        configuration=settings.model_dump(mode="json", by_alias=True),
        # of a real antenna no model and no seed are known
        model=embedded_model(link).document if isinstance(link, EmbeddedAntenna) else {},
        seed=link.embedded.seed if isinstance(link, EmbeddedAntenna) else 0,
        period_ns=period.ns,
        lockstep=options.lockstep,
        title="daemon",
        axes=settings.axis_names,
    )


def _say_where(run: Path, page: str | None, settings: DaemonSettings, lockstep: bool) -> None:
    pace = "in lockstep" if lockstep else "in real time"
    lines = [f"gimbal-hil daemon: {settings.rate_hz:g} Hz {pace}, recording into {run}"]
    lines += [f"live page and metrics: {page}"] if page else []
    with contextlib.suppress(OSError):
        print("\n".join(lines), file=sys.stderr, flush=True)


def _frame_counts(host: Host) -> Json:
    """What the host's receivers counted, all messages together."""
    rows = host.memory.receivers
    names = {"good": receiver.GOOD, "crc_errors": receiver.CRC_ERRORS, "out_of_range": receiver.OUT_OF_RANGE}
    names |= {"duplicates": receiver.DUPLICATES, "lost": receiver.LOST_FRAMES}
    counts: Json = {name: int(rows[:-1, column].sum()) for name, column in names.items()}
    counts["foreign"] = int(rows[-1].sum())
    return counts


def _note_in_log(run: Path, tick: int, ending: LoopEnd) -> None:
    """When the service could not finish the log, say in it why the run ended: nobody else writes to the file any
    more.
    """
    line = {
        "tick": tick,
        "time_ns": -1,
        "kind": "note",
        "text": f"stopping: {ending.reason}",
        "data": {"exit_code": ending.exit_code},
    }
    with contextlib.suppress(GimbalHilError):
        if read_header(run).end is not None:
            return  # the service has finished the log, and sealed it
    events = newest_events_file(run)
    with contextlib.suppress(OSError), events.open("ab") as file:
        file.write(b"\n" if _ends_within_a_line(events) else b"")
        file.write(json.dumps(line).encode() + b"\n")


def _ends_within_a_line(path: Path) -> bool:
    with path.open("rb") as file:
        if not file.seek(0, os.SEEK_END):
            return False
        file.seek(-1, os.SEEK_END)
        return file.read(1) != b"\n"
