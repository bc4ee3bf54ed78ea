"""What runs in the service process: recorder, operator's door, live page. Nothing that it does can delay a tick."""

from __future__ import annotations

import contextlib
import json
import select
import signal
import sys
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING

from firmware_protocol.errors import EXIT_SAFETY_STOP, BadInputError, shown
from firmware_protocol.json_object import Json
from firmware_protocol.links import CanLinkConfig, SerialLinkConfig
from gimbal_hil.data.runs import Retention, RunHeader, RunWriter
from gimbal_hil.loop.host import FIRST_TEST, EventCode, LinkStatus, word_of
from gimbal_hil.loop.settings import DaemonSettings, settings_from_document
from gimbal_hil.loop.timing import RingReader, RingRecord, RingWriter
from gimbal_hil.realtime.dashboard import ScopeScreen
from gimbal_hil.realtime.observing import CONFIRMED_BY, AxisWatch, LiveObserver, Suspected, WatchState
from gimbal_hil.realtime.operator import Door, OperatorSocket
from gimbal_hil.realtime.service.excerpts import Excerpts
from gimbal_hil.realtime.service.notice import Notice
from gimbal_hil.realtime.service.operator_desk import OperatorDesk
from gimbal_hil.realtime.service.process import Orders, ServiceSettings
from gimbal_hil.realtime.service.recorder import Recorder
from gimbal_hil.realtime.telemetry import (
    MISS_RECORD,
    Commands,
    Exchange,
    LiveView,
    Scope,
    TelemetryKind,
    Wire,
    exchange_from,
)
from sim_backend.boresight import Boresight

if TYPE_CHECKING:
    from gimbal_hil.realtime.dashboard import PageServer
#: how long the service sleeps when there is nothing to do: it sets how old an event is when an operator sees it
_IDLE_S = 0.005
_STOPPED_WITHOUT_A_WORD = "the control process ended without giving a reason"
#: kinds of events that are also printed
_NOTICED = ("state", "fault", "link", "note")


class Service:
    """All that the service process holds."""

    def __init__(self, orders: Orders) -> None:
        header = RunHeader(**{**orders.header, **{key: tuple(orders.header[key]) for key in ("command_line", "axes")}})
        self._telemetry = RingReader(orders.telemetry)
        settings = ServiceSettings(**orders.settings)
        configuration = settings_from_document(dict(header.configuration), "configuration")
        looks = configuration.pointing.boresight or Boresight.AHEAD
        self._view = LiveView(header.period_ns, header.axes, wire_of(configuration), boresight=looks)
        self._screen = ScopeScreen(Scope(header.period_ns, header.axes))
        self._excerpts = Excerpts(Path(orders.run), header)
        self._page: PageServer | None = None
        if settings.page_port is not None:
            from gimbal_hil.realtime.dashboard import PageServer

            door = Door(Path(orders.socket), orders.token) if settings.operator else None
            self._page = PageServer(self._view, settings.page_port, door, self._screen)
        recording = configuration.recording
        retention = Retention(recording.segment_mb, recording.keep_mb, recording.warn_below_mb, recording.stop_below_mb)
        writer = RunWriter(Path(orders.run), header, force=settings.force, retention=retention)
        self._recorder = Recorder(writer, header.period_ns, settings.frames, settings.every_ticks)
        self._view.recording = lambda: self._recorder.state
        commands = Commands(RingWriter(orders.commands))
        self._desk = OperatorDesk(commands, self._recorder, self._view, configuration, header.lockstep)
        self._observer = LiveObserver(configuration)
        self._view.observed = self._observer.status
        self._desk.learn_anew = self._observer.learn_anew
        self._view.adjustable = lambda: self._desk.adjusting.numbers
        self._view.limits = lambda: limits_in_force(self._desk.adjusting.settings)
        self._door, self._run = Door(Path(orders.socket), orders.token), Path(orders.run)
        self._socket = OperatorSocket(self._door, self._desk.handle, gone=self._desk.client_gone)
        self._desk.attach(self._socket)
        if settings.operator:
            self._door.write(self._run)
        self._end: tuple[int, str] | None = None
        self._told_failure = False
        self._quiet = settings.quiet
        self._notice_systemd = Notice()

    @property
    def page_url(self) -> str | None:
        """Where the live page is, None without one."""
        return self._page.url if self._page else None

    def serve(self) -> None:
        """Work until the control process says that it is done, or is gone."""
        while self._end is None and not _at_end(sys.stdin.fileno()):
            self._socket.serve(_IDLE_S)
            self._take()
        self._take()

    def close(self, reason: str = _STOPPED_WITHOUT_A_WORD) -> bool:
        """Write the end of the run and close the door; whether all that came is in the run folder."""
        self._take()
        self._recorder.close(*(self._end or (EXIT_SAFETY_STOP, reason)))
        self._socket.close()
        self._door.remove(self._run)
        if self._page is not None:
            self._page.close()
        if self._recorder.failure:
            with contextlib.suppress(OSError):
                print(f"recording failed: {self._recorder.failure}", file=sys.stderr, flush=True)
        return self._recorder.failure is None

    def _take(self) -> None:
        exchanges: list[Exchange] = []
        for record in self._telemetry.take():
            if record.kind == TelemetryKind.TICK:
                exchanges.append(exchange_from(record.payload))
            else:
                self._take_rare(record)
        self._view.take(exchanges, self._observer.take(exchanges))
        for axis, watch in self._observer.changes():
            self._tell_change(axis, watch)
        for axis, suspected in self._observer.suspects():
            self._tell_suspicion(axis, suspected)
        for capture in self._screen.scope.take(exchanges):
            folder = self._excerpts.write(capture)
            self._screen.show(capture, None if folder is None else str(folder), self._excerpts.failure)
        if exchanges:
            self._notice_systemd.ticks_came()
        self._recorder.take_exchanges(exchanges)
        self._recorder.note_lost(self._telemetry)
        self._recorder.write()
        self._desk.give_up()
        trouble = self._recorder.failure or self._recorder.running_out
        if trouble and not self._told_failure:
            self._told_failure = True
            self._desk.recording_failed(trouble)

    def _take_rare(self, record: RingRecord) -> None:
        if record.kind == TelemetryKind.MISS:
            tick, periods, code = MISS_RECORD.unpack(record.payload)
            self._view.miss(periods, code)
            self._recorder.miss(tick, code)
        elif record.kind == TelemetryKind.END:
            end = json.loads(record.payload)
            self._end = (end["exit_code"], end["reason"])
        elif record.kind == TelemetryKind.REPLY:
            self._desk.reply(json.loads(record.payload))
        elif record.kind == TelemetryKind.EVENT:
            event = json.loads(record.payload)
            self._recorder.event(event)
            if event["data"].get("code") == word_of(EventCode.STATE):
                self._view.state_changed(event["data"]["to"], event["data"]["cause"])
            if event["data"].get("code") == word_of(EventCode.TRIPPED):
                self._view.tripped(event["data"]["cause"], event["data"]["axis"])
            if event["data"].get("code") == "drive_complaint":
                self._view.complaint = event["data"]["complaint"]
            if event["data"].get("code") == FIRST_TEST:
                self._view.first_test = event["data"]["state"]
            if event["data"].get("code") == word_of(EventCode.POINTING):
                self._view.pointing_changed(event["data"])
            self._notice(event)
            if not _is_chatter(event):
                self._desk.announce(event)

    def _tell_change(self, axis: str, watch: AxisWatch) -> None:
        """What the model lacks has changed: an event, in the log and for every operator."""
        assert watch.rms_nm is not None and watch.usual_nm is not None
        now, usual = f"{watch.rms_nm:.3g} N m", f"{watch.usual_nm:.3g} N m"
        changed = watch.state is WatchState.CHANGED
        text = f"{axis}: the model lacks {now}, " + (f"usual is {usual}" if changed else f"as usual ({usual}) again")
        state = watch.state.value
        self._tell(text, {"axis": axis, "rms_nm": watch.rms_nm, "usual_nm": watch.usual_nm, "state": state})

    def _tell_suspicion(self, axis: str, suspected: Suspected) -> None:
        """What seems to grow, with the command that confirms it."""
        confirm = f"gimbal-hil experiment {CONFIRMED_BY[suspected.cause]} --run {self._run}"
        data = {"axis": axis, "suspected": suspected.cause.value, "probability": suspected.probability}
        data |= {"size": suspected.size, "order": suspected.order}
        self._tell(f"{axis}: suspected: {suspected.text}; {confirm} shows it", data)

    def _tell(self, text: str, data: Json) -> None:
        """A note of the model beside the antenna, in the log and for every operator."""
        row = self._view.row
        assert row is not None
        event = {
            "tick": int(row["tick"]),
            "time_ns": int(row["time_ns"]),
            "kind": "note",
            "text": text,
            "data": data,
        }
        self._recorder.event(event)
        self._notice(event)
        self._desk.announce(event)

    def _notice(self, event: Json) -> None:
        """Tell whoever started the daemon what it waits for; the control process itself must never wait for a
        terminal.
        """
        noticed = event["kind"] in _NOTICED or event["data"].get("code") == "drive_complaint"
        if noticed and not self._quiet and not _is_chatter(event):
            # a terminal that was closed takes no word, and is no reason to stop recording
            with contextlib.suppress(OSError):
                print(
                    f"{event['time_ns'] / 1e9:9.3f} s  {event['kind']}: {shown(event['text'])}",
                    file=sys.stderr,
                    flush=True,
                )


def wire_of(settings: DaemonSettings) -> Wire:
    """What carries the frames of this configuration; drives of another make have frames of their own, not counted."""
    link, window = settings.link, settings.supervisor.deadman.window_ticks
    if isinstance(link, CanLinkConfig):
        return Wire(link.bitrate, False, window)
    if isinstance(link, SerialLinkConfig):
        return Wire(link.baudrate, True, window)
    return Wire(None, False, window)


def limits_in_force(settings: DaemonSettings) -> Json:
    """What `LiveView.limits` tells."""
    shown = {"position_low_rad", "position_high_rad", "cable_wrap_turns", "torque_nm"}
    return {name: axis.limits.model_dump(include=shown) for name, axis in settings.axes.items()}


def main() -> int:
    """Entry point of the service process."""
    orders = Orders(**json.loads(sys.stdin.readline()))
    try:
        service = Service(orders)
    except BadInputError as error:
        _say({"ready": False, "where": error.where, "problem": error.problem, "expected": error.expected})
        return error.exit_code
    signal.signal(signal.SIGTERM, _leave)
    _say({"ready": True, "page": service.page_url})
    try:
        service.serve()
    except _AskedToLeave:
        service.close("the service process was terminated")
        return 1
    return 0 if service.close() else 1


def _is_chatter(event: Json) -> bool:
    """Feedback that is late by a tick and comes back, where the host stands: in the log, but nothing to interrupt a
    person with.
    """
    data = event["data"]
    if "image" in data:
        return True
    lost = word_of(LinkStatus.LOST)
    return data.get("code") == word_of(EventCode.LINK) and lost not in (data.get("from"), data.get("to"))


class _AskedToLeave(BaseException):
    pass


def _leave(_signal: int, _frame: FrameType | None) -> None:
    raise _AskedToLeave


def _at_end(descriptor: int) -> bool:
    """Whether the other end of the pipe has been closed; nothing is ever written to it after the orders."""
    return bool(select.select([descriptor], [], [], 0)[0])


def _say(line: Json) -> None:
    sys.stdout.write(json.dumps(line) + "\n")
    sys.stdout.flush()
