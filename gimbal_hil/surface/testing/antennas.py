"""The antenna of a test: moved through the host, in virtual time or by a daemon in a process of its own, recorded into
a run folder in both cases.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from abc import ABC, abstractmethod
from collections.abc import Mapping
from pathlib import Path

from firmware_protocol.documents import yaml_text
from firmware_protocol.errors import BadInputError, LinkError, SafetyStopError
from firmware_protocol.interpreter import apart_from_the_users_folder
from firmware_protocol.links import AntennaInStep, require_can_wait
from firmware_protocol.opening import open_link
from gimbal_hil.data.runs import EventKind, RunHeader, RunWriter
from gimbal_hil.loop.host import AxisCommand, FirstTestState, HostState, Mode, Segment, Shape, program_of, word_of
from gimbal_hil.loop.settings import DaemonSettings, EmbeddedAntenna
from gimbal_hil.realtime.lockstep import FramePath, Recorded
from gimbal_hil.realtime.operator import OperatorClient
from gimbal_hil.surface.testing.assertions import Band, Judgement, MadeStep, Signal
from gimbal_hil.surface.testing.recorded import RecordedSignals
from sim_backend.firmware import close_firmware, run_firmware
from sim_backend.model import model_named

#: between two looks at a signal that is waited for
_LOOK_S = 0.1
#: what a daemon may take to start and to connect, and to brake to rest at the end
_CONNECT_S, _END_S = 60.0, 20.0
_IDLE, _ACTIVE = word_of(HostState.IDLE), word_of(HostState.ACTIVE)


class AntennaOfTest(ABC):
    """An antenna that is ready to be moved. Axes are called as in its configuration; positions in rad."""

    def __init__(self, settings: DaemonSettings, folder: Path) -> None:
        self.settings, self.folder = settings, folder
        self.steps: list[str] = []
        self._recorded: RecordedSignals | None = None
        self._targets: dict[str, float] = {}

    @property
    def axes(self) -> tuple[str, str]:
        """Names of the axes, the carrying one first."""
        return self.settings.axis_names

    def go_to(self, **positions_rad: float) -> None:
        """Have axes go to positions and hold them; one that is not named stays where it is."""
        self._require(*positions_rad)
        self._targets = self._standing() | self._targets | positions_rad
        self._note("go to " + ", ".join(f"{axis} {value:g} rad" for axis, value in positions_rad.items()))
        outer, inner = (AxisCommand(Mode.POSITION, Shape.HOLD, (self._targets[axis],)) for axis in self.axes)
        self._follow(Segment(outer, inner))

    def step(self, axis: str, target_rad: float, for_s: float = 3.0) -> MadeStep:
        """A step of one axis' position reference, after both have held where they are for a moment; then wait."""
        self._require(axis)
        if axis not in self._targets:
            self.go_to(**self._standing())
            self.wait(0.2)
        made = MadeStep(axis, self.now_s, self._targets[axis], target_rad)
        self.go_to(**{axis: target_rad})
        self.wait(for_s)
        return made

    def _require(self, *axes: str) -> None:
        for axis in axes:
            if axis not in self.axes:
                raise BadInputError(axis, "no such axis", " or ".join(self.axes))

    def signal(self, name: str) -> Signal:
        """What is recorded of a signal by now, as in `outer.position`."""
        self._flush()
        if self._recorded is None:
            self._recorded = RecordedSignals(self.folder)
        return self._recorded.signal(name)

    def wait_until(self, name: str, target: float, band: Band, at_most_s: float = 10.0) -> Judgement:
        """Wait until a signal has been in a band for its time, looking while it is recorded."""
        began = self.now_s
        band = band.after(max(began, band.from_s), within_s=at_most_s)
        self._note(f"wait until {name} is within {band.tolerance:g} of {target:g} for {band.duration_s:g} s")
        while True:
            found = self.signal(name).settles_at(target, band)
            if found or self.now_s - began > at_most_s + band.duration_s:
                return found
            self.wait(_LOOK_S, quietly=True)

    def wait(self, duration_s: float, quietly: bool = False) -> None:
        """Let time pass on the antenna; SafetyStopError where a guard ends the motion meanwhile."""
        if not quietly:
            self._note(f"wait {duration_s:g} s")
        self._pass(duration_s)

    def _note(self, text: str) -> None:
        self.steps.append(f"{self.now_s:8.3f} s  {text}")

    @property
    @abstractmethod
    def now_s(self) -> float:
        """Time of the signals now."""

    @abstractmethod
    def close(self) -> None:
        """Brake to rest, torque off, log closed."""

    @abstractmethod
    def _standing(self) -> dict[str, float]:
        """Where the joints stand."""

    @abstractmethod
    def _follow(self, segment: Segment) -> None:
        """Have the host follow a segment from now on."""

    @abstractmethod
    def _pass(self, duration_s: float) -> None:
        """Let time pass."""

    @abstractmethod
    def _flush(self) -> None:
        """Have all that was recorded in the files."""


class LockstepAntennaOfTest(AntennaOfTest):
    """An antenna in virtual time: the virtual one of the configuration, or one that waits behind its link."""

    def __init__(self, settings: DaemonSettings, folder: Path) -> None:
        link = settings.link
        embedded = link.embedded if isinstance(link, EmbeddedAntenna) else EmbeddedAntenna().embedded
        model = model_named(embedded.model, "link.embedded.model")
        settings = settings.for_axes(model.axes, model.where).with_model()
        super().__init__(settings, folder)
        period_ns = round(1e9 / settings.rate_hz)
        document = settings.model_dump(mode="json", by_alias=True)
        header = RunHeader(document, model.document, embedded.seed, period_ns, True, "test", settings.axis_names)
        self._writer = RunWriter(folder, header)
        self._device = run_firmware(embedded.firmware, model, settings.rate_hz, embedded.seed)
        self._remote = None if isinstance(link, EmbeddedAntenna) else AntennaInStep(open_link(link))
        self._path = FramePath(
            settings,
            model,
            embedded.seed,
            device=self._device,
            keep_frames=True,
        )
        if self._remote is not None:
            self._path.with_remote(self._remote)
        self._keep(self._path.connect())

    @property
    def now_s(self) -> float:
        """Virtual time."""
        return self._path.tick / self.settings.rate_hz

    def close(self) -> None:
        """Brake to rest, torque off, log closed."""
        if self._host_state() is HostState.ACTIVE:
            self._command("stop", {})
            self._path.host.stop()
            for _ in range(int(_END_S / _LOOK_S)):
                self._keep(self._path.advance(round(_LOOK_S * self.settings.rate_hz)))
                if self._host_state() in (HostState.IDLE, HostState.FAULT):
                    break
        self._writer.close()
        close_firmware(self._device)
        if self._remote is not None:
            self._remote.close()

    def _host_state(self) -> HostState:
        return self._path.host.state

    def _standing(self) -> dict[str, float]:
        return {name: float(axis["position_rad"]) for name, axis in self._path.host.status()["axes"].items()}

    def _follow(self, segment: Segment) -> None:
        program = program_of([segment])
        self._command("start", {"program": program.as_document()})
        self._path.host.command(program)

    def _command(self, command: str, data: Mapping[str, object]) -> None:
        self._writer.command(
            self._path.tick, self._path.tick * self._path.step_ns, command, {"command": command, **data}
        )

    def _pass(self, duration_s: float) -> None:
        moving = self._host_state() is HostState.ACTIVE
        self._keep(self._path.advance(max(1, round(duration_s * self.settings.rate_hz))))
        host = self._path.host
        if moving and self._host_state() is not HostState.ACTIVE:
            raise SafetyStopError(f"the host is {host.state.name.lower()}, {host.cause.name.lower()}")

    def _keep(self, recorded: Recorded) -> None:
        self._writer.append_frames(recorded.frame_rows)
        self._writer.append_ticks(recorded.rows)
        for event in recorded.events:
            self._writer.event(event.tick, event.tick * self._path.step_ns, EventKind.NOTE, event.text, {})

    def _flush(self) -> None:
        self._writer.flush()


class DaemonAntennaOfTest(AntennaOfTest):
    """Whatever antenna answers on the link, controlled by a daemon that runs as long as the test does."""

    def __init__(self, settings: DaemonSettings, folder: Path) -> None:
        super().__init__(settings, folder)
        folder.parent.mkdir(parents=True, exist_ok=True)
        configuration = folder.with_name(f"{folder.name}.yaml")
        configuration.write_text(yaml_text(settings.model_dump(mode="json", by_alias=True, exclude_none=True)))
        words = ["daemon", "--config", str(configuration), "--out", str(folder), "--end-with", str(os.getpid())]
        self._output = folder.with_name(f"{folder.name}.txt").open("w", encoding="utf-8")
        program = f"from gimbal_hil.surface.cli import main; main({words!r})"
        with apart_from_the_users_folder():
            self._daemon = subprocess.Popen(
                [sys.executable, "-c", program], stdout=self._output, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL
            )
        try:
            self._client = self._connected()
        except BaseException:
            self._end()
            raise

    def _connected(self) -> OperatorClient:
        """A client of the daemon once its host is ready to move the antenna."""
        deadline = time.monotonic() + _CONNECT_S
        client, said = None, "no daemon"
        while time.monotonic() < deadline:
            if self._daemon.poll() is not None:
                raise LinkError(f"the daemon ended with {self._daemon.returncode}: {self._last_words()}")
            try:
                client = client or OperatorClient(self.folder)
                status = client.request("status")["status"]
                state, test = status["host_state"], status["first_test"]
                # the daemon's own test moves the antenna first
                if state in (_IDLE, _ACTIVE) and test in (None, FirstTestState.PASSED.value):
                    return client
                said = f"{state}, first test {test or 'none'}"
            except (BadInputError, LinkError) as error:
                said = str(error)
            time.sleep(_LOOK_S)
        raise LinkError(f"the antenna is not ready after {_CONNECT_S:g} s: {said}")

    @property
    def now_s(self) -> float:
        """Time of the daemon's ticks."""
        return int(self._client.request("status")["status"]["tick"]) / self.settings.rate_hz

    def close(self) -> None:
        """Brake to rest, end the daemon; its log is closed."""
        try:
            self._client.request("shut_down")
            self._daemon.wait(_END_S)
        except (LinkError, subprocess.TimeoutExpired):
            pass
        finally:
            self._client.close()
            self._end()

    def _end(self) -> None:
        if self._daemon.poll() is None:
            self._daemon.terminate()
            try:
                self._daemon.wait(_END_S)
            except subprocess.TimeoutExpired:
                self._daemon.kill()
                self._daemon.wait()
        self._output.close()

    def _last_words(self) -> str:
        self._output.flush()
        lines = Path(self._output.name).read_text(encoding="utf-8").strip().splitlines()
        return lines[-1] if lines else "it said nothing"

    def _standing(self) -> dict[str, float]:
        positions = self._client.request("status")["status"]["position_rad"]
        return {axis: float(positions[axis]) for axis in self.axes}

    def _follow(self, segment: Segment) -> None:
        self._client.start(program_of([segment]))

    def _pass(self, duration_s: float) -> None:
        moving = self._client.request("status")["status"]["host_state"] == _ACTIVE
        time.sleep(duration_s)
        status = self._client.request("status")["status"]
        if moving and status["host_state"] != _ACTIVE:
            raise SafetyStopError(f"the host is {status['host_state']}, {status['cause']}")

    def _flush(self) -> None:
        """The daemon writes twenty times a second: what was there when it was asked for is, a moment later."""
        time.sleep(_LOOK_S)


def antenna_of(settings: DaemonSettings, folder: Path, *, lockstep: bool = False) -> AntennaOfTest:
    """The antenna that a configuration names: virtual, in virtual time; or on its link, through a daemon, or in
    `lockstep` with an antenna that waits there.
    """
    if not isinstance(settings.link, EmbeddedAntenna) and lockstep:
        require_can_wait(settings.link)
        return LockstepAntennaOfTest(settings, folder)
    if not isinstance(settings.link, EmbeddedAntenna):
        return DaemonAntennaOfTest(settings, folder)
    return LockstepAntennaOfTest(settings, folder)
