"""Host and virtual antenna together, with anything happening at any time: what must hold whatever it is.

`MACHINE_EXAMPLES` sets how many stories are told (default 15).
"""

from __future__ import annotations

import os

from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, precondition, rule

from firmware_protocol.enumerations import DriveState, FaultCode
from gimbal_hil.loop.host import AxisCommand, HostCause, HostState, Mode, ReferenceOrigin, Segment, Shape, program_of
from gimbal_hil.loop.host.layout import MAX_RATE, axis_c
from gimbal_hil.loop.settings import shipped_settings
from gimbal_hil.proof.bench.faults import Rig, Transport
from sim_backend.device import Spoilt
from sim_backend.model import shipped_model

#: after these nothing may be driven by what the sensors say
NO_SENSOR_AFTER = {
    HostCause.GYRO_ENCODER_DISAGREE,
    HostCause.SENSOR_DRIFT,
    HostCause.FEEDBACK_FROZEN,
    HostCause.RUNAWAY,
    HostCause.OVERSPEED,
    HostCause.FOLLOWING_ERROR,
    HostCause.NOT_A_NUMBER,
    HostCause.WRONG_ANTENNA,
}
NO_SENSOR_AFTER_DRIVE = {
    FaultCode.SENSORS_DISAGREE,
    FaultCode.RUNAWAY,
    FaultCode.ENCODER,
    FaultCode.GYRO,
    FaultCode.OVERSPEED,
    FaultCode.TRAVEL_LIMIT,
}
LINK_FAULTS = {FaultCode.NONE, FaultCode.DEADMAN, FaultCode.COMMUNICATION}
LIMITS = shipped_settings()
WINDOW_TICKS = LIMITS.supervisor.deadman.window_ticks
#: a request reaches the drive with the next set, and is obeyed in the tick after it
OBEYED_TICKS = 3
#: what an axis may gain beyond its limit while a guard makes up its mind (see the fault matrix)
GAINED_RAD_S = 1.5
MODES = st.sampled_from([Mode.POSITION, Mode.RATE, Mode.TORQUE, Mode.OFF])
VALUES = st.floats(-1.0, 1.0)
TICKS = st.integers(1, 300)
#: around the deadman's window, and far beyond
SILENCE = st.one_of(st.integers(1, 40), TICKS)
AXIS, LOOK = st.sampled_from([0, 1]), st.integers(100, 600)
SENSOR_FAULTS = st.sampled_from([Spoilt.FROZEN, Spoilt.REVERSED, Spoilt.DEAD, Spoilt.OFF])
#: size of an offset in raw units
OFF_BY = 4000


def commanded(mode: Mode, value: float) -> AxisCommand:
    """A hold of a sensible size: up to 1.5 rad, 2 rad/s, 2 N m."""
    size = {Mode.POSITION: 1.5, Mode.RATE: 2.0, Mode.TORQUE: 2.0}.get(mode, 0.0)
    return AxisCommand(mode, Shape.HOLD, (size * value,), ReferenceOrigin.ABSOLUTE)


class HostAndAntenna(RuleBasedStateMachine):
    """One part of the antenna is broken at a time at most; the line, the host and the operator do as they like."""

    @initialize(seed=st.integers(0, 1000), transport=st.sampled_from(list(Transport)))
    def begin(self, seed: int, transport: Transport) -> None:
        """A connected antenna."""
        self.rig = Rig(LIMITS, shipped_model(), transport, seed)
        self.taken = self.unheard = self.in_fault = self.in_drive_fault = 0
        self.reset_asked = self.restarted = self.all_heard = False
        self.state, self.cause, self.drive_fault = HostState.WAITING, HostCause.NONE, FaultCode.NONE
        self.broken: tuple[int, str] | None = None
        self.go(60)
        assert self.rig.host.state is HostState.IDLE

    def go(self, ticks: int) -> None:
        """On by some ticks; everything that must hold is looked at after each."""
        for _ in range(ticks):
            self.rig.advance(1)
            self.look()

    @rule(modes=st.tuples(MODES, MODES), values=st.tuples(VALUES, VALUES), ticks=TICKS)
    def move(self, modes: tuple[Mode, Mode], values: tuple[float, float], ticks: int) -> None:
        """The operator asks for a motion, after everything has been put right."""
        if self.broken is not None:
            self.rig.device.spoil(*self.broken, Spoilt.NOTHING)
            self.broken = None
        for _ in range(60):
            if self.rig.host.state in (HostState.IDLE, HostState.ACTIVE):
                break
            if self.rig.host.state is HostState.FAULT:
                self.rig.host.reset_fault()
                self.reset_asked = True
            self.go(100)
        assert self.rig.host.state in (HostState.IDLE, HostState.ACTIVE), self.rig.host.cause
        outer, inner = (commanded(mode, value) for mode, value in zip(modes, values, strict=True))
        self.rig.host.command(program_of([Segment(outer, inner)]))
        self.go(ticks)

    @rule(way=st.sampled_from(["stop", "quick_stop"]), ticks=TICKS)
    def stop(self, way: str, ticks: int) -> None:
        """The operator stops it."""
        getattr(self.rig.host, way)()
        self.go(ticks)

    @rule(what=st.sampled_from(["host_speaks", "set_points_pass", "antenna_heard"]), ticks=SILENCE)
    def cut(self, what: str, ticks: int) -> None:
        """Nothing passes one way, or no set-points, for a while."""
        setattr(self.rig, what, False)
        self.go(ticks)
        setattr(self.rig, what, True)
        self.go(20)

    @rule(ticks=SILENCE)
    def stall(self, ticks: int) -> None:
        """The host's machine stands still."""
        self.rig.stall(ticks)
        taken = self.rig.device.set_points[0]
        assert taken - self.taken <= 1
        if ticks > WINDOW_TICKS + 1:
            assert self.rig.device.state is not DriveState.OPERATION_ENABLED
        self.unheard, self.taken = ticks, taken
        # what the drive did meanwhile is not seen tick by tick
        self.drive_fault, self.in_drive_fault, self.in_fault = self.rig.device.fault, 0, 0
        self.go(20)

    @rule(ticks=TICKS)
    def restart(self, ticks: int) -> None:
        """The antenna's electronics begin anew."""
        self.rig.restart_antenna()
        self.restarted, self.broken, self.taken, self.unheard = True, None, 0, 0
        self.go(ticks)

    @precondition(lambda self: self.rig.host.state is HostState.ACTIVE)
    @rule(axis=AXIS, part=st.sampled_from(["encoder", "gyro"]), kind=SENSOR_FAULTS, ticks=LOOK)
    def lie(self, axis: int, part: str, kind: Spoilt, ticks: int) -> None:
        """A sensor begins to lie under way."""
        self.break_one(axis, part, kind, ticks)

    @precondition(lambda self: self.rig.host.state is HostState.ACTIVE)
    @rule(axis=AXIS, kind=st.sampled_from([Spoilt.REVERSED, Spoilt.DEAD]), ticks=LOOK)
    def fail(self, axis: int, kind: Spoilt, ticks: int) -> None:
        """A motor turns the other way under way, or not at all."""
        self.break_one(axis, "motor", kind, ticks)

    def break_one(self, axis: int, part: str, kind: Spoilt, ticks: int) -> None:
        """One thing at a time: what was broken before is right again."""
        if self.broken is not None:
            self.rig.device.spoil(*self.broken, Spoilt.NOTHING)
        self.broken = (axis, part)
        self.rig.device.spoil(axis, part, kind, OFF_BY)
        self.go(ticks)

    def look(self) -> None:
        """What must hold after every tick."""
        host, device = self.rig.host, self.rig.device
        self.count()
        # no torque but under control, and none without a living host
        sent = [host.status()["axes"][name]["torque_nm"] for name in ("outer", "inner")]
        assert host.state in (HostState.ACTIVE, HostState.STOPPING) or sent == [0.0, 0.0]
        assert self.unheard <= WINDOW_TICKS + 1 or device.state is not DriveState.OPERATION_ENABLED
        # a reaction never uses what is suspected
        heard = self.rig.host_speaks and self.rig.set_points_pass
        if heard and host.state is HostState.FAULT and host.cause in NO_SENSOR_AFTER and self.in_fault > OBEYED_TICKS:
            assert device.torques_nm == (0.0, 0.0), host.cause
        if device.fault in NO_SENSOR_AFTER_DRIVE and self.in_drive_fault > 1:
            assert device.torques_nm == (0.0, 0.0), device.fault
        # a fault stays until somebody resets it; only silence on the way is left by itself
        if self.state is HostState.FAULT and host.state is not HostState.FAULT:
            silence = self.cause is HostCause.DRIVE_FAULT and self.drive_fault in LINK_FAULTS
            by_itself = self.cause is HostCause.FEEDBACK_LOST or silence
            assert self.reset_asked or by_itself, self.cause
        if self.drive_fault not in LINK_FAULTS and device.fault is FaultCode.NONE:
            assert self.reset_asked or self.restarted, self.drive_fault
        # nothing gets away
        for axis, rate in enumerate(device.joint_rates):
            assert abs(rate) < host.memory.C[axis_c(axis) + MAX_RATE] + GAINED_RAD_S
        self.remember()

    def count(self) -> None:
        """How long it is since the drive took a set-point, and since each side is in fault."""
        taken = self.rig.device.set_points[0]
        self.unheard = 0 if taken != self.taken else self.unheard + 1
        self.taken = taken
        self.in_fault = self.in_fault + 1 if self.rig.host.state is HostState.FAULT else 0
        same = self.rig.device.fault is self.drive_fault and self.drive_fault is not FaultCode.NONE
        self.in_drive_fault = self.in_drive_fault + 1 if same else 0

    def remember(self) -> None:
        """For the next tick."""
        host, device = self.rig.host, self.rig.device
        if host.state is HostState.FAULT and self.state is not HostState.FAULT:
            self.reset_asked = False
        if device.fault not in LINK_FAULTS and self.drive_fault in LINK_FAULTS:
            self.restarted = False
        self.state, self.cause, self.drive_fault = host.state, host.cause, device.fault


TestHostAndAntenna = HostAndAntenna.TestCase
TestHostAndAntenna.settings = settings(
    max_examples=int(os.environ.get("MACHINE_EXAMPLES", "15")), stateful_step_count=25
)
