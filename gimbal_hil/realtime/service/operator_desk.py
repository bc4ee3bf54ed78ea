"""Between the operator's door and the control process: checks requests, passes them on, brings answers and events
back.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

from firmware_protocol.errors import BadInputError
from firmware_protocol.json_object import Json
from gimbal_hil.loop.host import Program
from gimbal_hil.loop.settings import Adjustments, DaemonSettings
from gimbal_hil.realtime.operator import Client, OperatorSocket
from gimbal_hil.realtime.service.adjusting import LiveAdjustments
from gimbal_hil.realtime.service.operator_commands import (
    AdjustRequest,
    PlainRequest,
    SetPointRequest,
    StartRequest,
    parse_request,
)
from gimbal_hil.realtime.service.recorder import Recorder
from gimbal_hil.realtime.service.set_point_bounds import require_reachable
from gimbal_hil.realtime.telemetry import (
    MOTION_PATIENCE_S,
    CommandKind,
    Commands,
    LiveView,
    pack_motion_number,
    pack_program,
)

_ANSWERED_HERE = ("status", "adjustable", "learn_anew")
_OF_A_LEASE = {"renew": CommandKind.RENEW, "release": CommandKind.RELEASE}
#: in virtual time, which runs as fast as it can, only a closed connection ends a lease
_NO_TIME = 2**62
_KINDS = {
    "stop": CommandKind.STOP,
    "quick_stop": CommandKind.QUICK_STOP,
    "fault_reset": CommandKind.FAULT_RESET,
    "shut_down": CommandKind.SHUT_DOWN,
}
#: an operator waits this long at most for the control process to take a request, a little longer than a motion may
#: still begin
_PATIENCE_S = MOTION_PATIENCE_S + 0.5


@dataclass(frozen=True, slots=True)
class _Waiting:
    client: Client
    request_id: object
    command: str
    program: Program | None
    values: Adjustments | None
    deadline_s: float
    leased: bool = False


class OperatorDesk:
    """Handles requests in the service process."""

    def __init__(
        self,
        commands: Commands,
        recorder: Recorder,
        view: LiveView,
        settings: DaemonSettings,
        lockstep: bool = False,
    ) -> None:
        self._commands = commands
        self._recorder = recorder
        self._view = view
        self._step_s = settings.step_s
        self._lease_s = settings.operator.lease_s
        self._lease_ticks = _NO_TIME if lockstep else max(1, round(self._lease_s / settings.step_s))
        #: whose motion the antenna follows, and the number of its request
        self._leased: tuple[Client, int] | None = None
        self.adjusting = LiveAdjustments(settings, view)
        self._waiting: dict[int, _Waiting] = {}
        #: answered already, because the control process was silent for too long
        self._given_up: dict[int, _Waiting] = {}
        self._socket: OperatorSocket | None = None
        #: has the model beside the antenna take what it lacks from now on as usual
        self.learn_anew: Callable[[], None] = lambda: None

    def attach(self, socket: OperatorSocket) -> None:
        """Where answers that come later and events go."""
        self._socket = socket

    def handle(self, client: Client, line: Json) -> Json | None:
        """Answer a request that needs no one else, or pass it on; refusals in one line."""
        program: Program | None = None
        values: Adjustments | None = None
        try:
            request = parse_request(line, self._view.axes)
            if isinstance(request, PlainRequest):
                if request.command in _ANSWERED_HERE:
                    return self._looked_up(request.command)
                if request.command in _OF_A_LEASE:
                    return self._about_lease(client, request.command)
            elif isinstance(request, AdjustRequest):
                values = self.adjusting.asked(request.changes(self._view.axes))
            else:
                if isinstance(request, SetPointRequest):
                    require_reachable(request, self.adjusting.settings)
                program = request.program(self._step_s)
        except BadInputError as error:
            return {"ok": False, "error": str(error)}
        leased = program is not None and not isinstance(request, PlainRequest | AdjustRequest) and request.lease
        if request.command == "adjust_back":
            values = self.adjusting.asked(None)
        if values is not None:
            number = self._commands.send(CommandKind.ADJUST, self.adjusting.packed(values))
        elif program is not None:
            with_image = isinstance(request, StartRequest) and request.with_image
            kind = CommandKind.START_WITH_IMAGE if with_image else CommandKind.START
            number = self._commands.send(kind, pack_program(program, self._lease_ticks if leased else 0))
        else:
            number = self._commands.send(_KINDS[request.command])
        if number is None:
            return {
                "ok": False,
                "error": "the program is too long, or the control process is behind with earlier requests",
            }
        if values is not None:
            self.adjusting.sent(values)
        deadline = time.monotonic() + _PATIENCE_S
        self._waiting[number] = _Waiting(client, line.get("id"), request.command, program, values, deadline, leased)
        return None

    def client_gone(self, client: Client) -> None:
        """Its connection has closed: the motion that it leased ends."""
        if self._leased is not None and self._leased[0] is client:
            self._commands.send(CommandKind.CLIENT_GONE, pack_motion_number(self._leased[1]))
            self._leased = None

    def _about_lease(self, client: Client, command: str) -> Json | None:
        """A renewal is not answered: whoever renews waits for nothing."""
        mine = self._leased is not None and self._leased[0] is client
        if self._leased is not None and mine:
            self._commands.send(_OF_A_LEASE[command], pack_motion_number(self._leased[1]))
        if command == "renew":
            return None
        self._leased = None if mine else self._leased
        return {"ok": True}

    def _begin_lease(self, waiting: _Waiting, number: int) -> None:
        """The motion has begun; its client may be gone already."""
        self._leased = (waiting.client, number) if waiting.leased else None
        if waiting.leased and self._socket is not None and not self._socket.has(waiting.client):
            self.client_gone(waiting.client)

    def _looked_up(self, command: str) -> Json:
        if command == "learn_anew":
            self.learn_anew()
            return {"ok": True}
        if command == "adjustable":
            return {"ok": True, "numbers": self.adjusting.numbers}
        recorder = self._recorder
        return {
            "ok": True,
            "status": self._view.status(),
            "recording": recorder.state,
            "recording_failure": recorder.failure,
        }

    def announce(self, event: Json) -> None:
        """Pass an event on to every operator."""
        if self._socket is not None:
            self._socket.announce(
                {"event": event["kind"], **{key: value for key, value in event.items() if key != "kind"}}
            )

    def give_up(self) -> None:
        """Answer those whose request the control process has not taken."""
        now = time.monotonic()
        for number in [number for number, waiting in self._waiting.items() if waiting.deadline_s < now]:
            waiting = self._given_up[number] = self._waiting.pop(number)
            # before the first tick it is still preparing itself
            preparing = waiting.program is not None and not self._view.ticks
            told = {"ok": False, "error": "the control process has not taken the request", "not_ready": preparing}
            self._answer(waiting, told)

    def recording_failed(self, reason: str) -> None:
        """Have the control process stop: what it does could not be kept."""
        self._commands.send(CommandKind.RECORDING_FAILED, reason.encode())

    def reply(self, reply: Json) -> None:
        """What the control process said to a request."""
        late = self._given_up.pop(reply["request"], None)
        waiting = late or self._waiting.pop(reply["request"], None)
        if waiting is None:
            return
        tick, time_ns = reply["tick"], reply["time_ns"]
        if waiting.program is not None and not reply["problem"]:
            # recorded whatever its caller has been told, or the run could not be computed again
            self._recorder.command(
                tick, time_ns, "start", {"command": "start", "program": waiting.program.as_document()}
            )
            self._begin_lease(waiting, reply["request"])
        if waiting.values is not None and reply["problem"]:
            self.adjusting.refused()
        elif waiting.values is not None:
            self._recorder.command(tick, time_ns, "adjust", self.adjusting.taken(waiting.values))
        if late is not None:
            return
        if reply["problem"]:
            self._answer(waiting, {"ok": False, "error": reply["problem"], "not_ready": reply["not_ready"]})
        else:
            lease = {"lease_s": self._lease_s} if waiting.leased else {}
            self._answer(waiting, {"ok": True, "tick": tick, **lease})

    def _answer(self, waiting: _Waiting, answer: Json) -> None:
        if self._socket is not None:
            self._socket.answer(waiting.client, {"id": waiting.request_id, **answer})
