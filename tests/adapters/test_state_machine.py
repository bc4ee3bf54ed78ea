"""Host, adapter and simulated drives of other makes, with anything happening at any time: what must hold whatever it
is.

`MACHINE_EXAMPLES` sets how many stories are told of each make (default 12, 3 s each).
"""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import Phase, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, rule

from firmware_protocol.adapters import CanFrame
from firmware_protocol.enumerations import FaultCode
from gimbal_hil.loop.host import AxisCommand, HostCause, HostState, Mode, ReferenceOrigin, Segment, Shape, program_of
from gimbal_hil.loop.host.layout import MAX_RATE, axis_c
from sim_backend.layout import RATE
from tests.adapters.faults import rig_of
from tests.adapters.test_stops_by_cause import SHORTED

pytestmark = pytest.mark.heavy
#: what an axis may gain beyond its limit while a guard makes up its mind (see the fault matrix)
GAINED_RAD_S = 1.5
#: faults of a drive that are those of the way to it, and are left by themselves
LINK_FAULTS = {FaultCode.NONE, FaultCode.DEADMAN, FaultCode.COMMUNICATION}
#: ticks after which a stop that was asked for has reached the drives, repeats of a lost one included
OBEYED_TICKS = 30
#: ticks after which drives that hear nobody have stopped by their own watchdogs and stand without torque
LET_GO_TICKS = 1500
#: ticks of a whole bus in which an operator who resets has an antenna again
RECOVERED_TICKS = 4000
MODES = st.sampled_from([Mode.POSITION, Mode.RATE, Mode.TORQUE, Mode.OFF])
VALUES = st.floats(-1.0, 1.0)
TICKS = st.integers(1, 300)
PLACE = st.sampled_from([0, 1])
#: share of the frames that are lost
LOSSES = st.sampled_from([0.02, 0.3, 1.0])


def commanded(mode: Mode, value: float) -> AxisCommand:
    """A hold of a sensible size: up to 1 rad, 1.5 rad/s, 1 N m."""
    size = {Mode.POSITION: 1.0, Mode.RATE: 1.5, Mode.TORQUE: 1.0}.get(mode, 0.0)
    return AxisCommand(mode, Shape.HOLD, (size * value,), ReferenceOrigin.ABSOLUTE)


class _HostAndDrives(RuleBasedStateMachine):
    """The bus, the host's machine, the drives and the operator do as they like; feedback that lies is the fault
    matrix's matter.
    """

    make: str

    @initialize(seed=st.integers(0, 1000))
    def begin(self, seed: int) -> None:
        """A connected antenna."""
        self.folder = tempfile.TemporaryDirectory()
        self.rig = rig_of(self.make, Path(self.folder.name))
        self.chance = np.random.default_rng(seed)
        self.silent = self.in_fault = 0
        self.reset_asked = self.is_deaf = False
        self.state, self.cause, self.drive_fault = HostState.WAITING, HostCause.NONE, FaultCode.NONE
        self.rig.connected()

    def teardown(self) -> None:
        if hasattr(self, "rig"):
            self.rig.close()
            self.folder.cleanup()

    def go(self, ticks: int) -> None:
        """On by some ticks; everything that must hold is looked at after each."""
        for _ in range(ticks):
            self.rig.run(1)
            self.look()

    @rule(modes=st.tuples(MODES, MODES), values=st.tuples(VALUES, VALUES), ticks=TICKS)
    def move(self, modes: tuple[Mode, Mode], values: tuple[float, float], ticks: int) -> None:
        """The operator asks for a motion, and resets before where that is wanted."""
        for _ in range(RECOVERED_TICKS // 100):
            if self.rig.host.state in (HostState.IDLE, HostState.ACTIVE):
                break
            if self.rig.host.state is HostState.FAULT:
                self.rig.host.reset_fault()
                self.reset_asked = True
            self.go(100)
        assert self.rig.host.state in (HostState.IDLE, HostState.ACTIVE), (self.rig.host.cause, self.rig.events[-6:])
        pan, tilt = (commanded(mode, value) for mode, value in zip(modes, values, strict=True))
        self.rig.host.command(program_of([Segment(pan, tilt)]))
        self.go(ticks)

    @rule(way=st.sampled_from(["stop", "quick_stop"]), ticks=TICKS)
    def stop(self, way: str, ticks: int) -> None:
        """The operator stops it."""
        getattr(self.rig.host, way)()
        self.go(ticks)

    @rule(way=st.sampled_from(["lost", "unheard"]), share=LOSSES, ticks=TICKS)
    def noisy_bus(self, way: str, share: float, ticks: int) -> None:
        """A share of what the drives say, or of what is said to them, is lost for a while."""

        def is_lost(frame: CanFrame) -> bool:
            return bool(self.chance.random() < share)

        setattr(self.rig, way, is_lost)
        self.is_deaf = way == "unheard"
        self.go(ticks)
        setattr(self.rig, way, lambda frame: False)
        self.is_deaf = False
        self.go(20)

    @rule(ticks=TICKS)
    def silence(self, ticks: int) -> None:
        """The host says nothing for a while; the gateway goes on."""
        self.rig.host_speaks = False
        for self.silent in range(1, ticks + 1):
            self.rig.run(1)
            assert self.silent <= OBEYED_TICKS or self.rig.only_brakes()
        self.rig.host_speaks, self.silent = True, 0
        self.go(20)

    @rule(ticks=TICKS)
    def stall(self, ticks: int) -> None:
        """The machine of host and gateway stands still: the drives have only their own watchdogs."""
        for passed in range(1, ticks + 1):
            self.rig.away(1)
            assert passed <= OBEYED_TICKS + 100 or self.rig.only_brakes()
        self.in_fault = 0
        self.go(20)

    @rule(place=PLACE, ticks=TICKS)
    def trip(self, place: int, ticks: int) -> None:
        """A drive falls into a fault of its own."""
        drive = self.rig.gimbal.drives[place]
        drive.trip(*() if self.make in ("cia402", "dbc") else (33,))  # type: ignore[attr-defined]
        self.go(ticks)

    @rule()
    def gone(self) -> None:
        """The host's machine is gone for good: nothing has torque in the end. Then it is back."""
        self.rig.away(LET_GO_TICKS)
        assert self.rig.only_brakes() and self.have_let_go()
        self.in_fault = 0
        self.go(20)

    def have_let_go(self) -> bool:
        """Whether no drive has torque of its own; a shorted winding's is the shaft's, and ends with it."""
        drives = self.rig.gimbal.drives
        return all(drive.torque_nm == 0.0 or getattr(drive, "mode", None) == SHORTED for drive in drives)

    def look(self) -> None:
        """What must hold after every tick."""
        host = self.rig.host
        self.in_fault = self.in_fault + 1 if host.state is HostState.FAULT else 0
        # no torque but under control
        sent = [axis["torque_nm"] for axis in host.status()["axes"].values()]
        assert host.state in (HostState.ACTIVE, HostState.STOPPING) or sent == [0.0, 0.0]
        # what is in fault is only braked
        assert self.is_deaf or self.in_fault <= OBEYED_TICKS or self.rig.only_brakes(), host.cause
        # a fault stays until somebody resets it; only silence is left by itself
        if self.state is HostState.FAULT and host.state is not HostState.FAULT:
            silence = self.cause is HostCause.DRIVE_FAULT and self.drive_fault in LINK_FAULTS
            by_itself = self.cause is HostCause.FEEDBACK_LOST or silence
            assert self.reset_asked or by_itself, (self.cause, self.drive_fault)
        if host.state is HostState.FAULT and self.state is not HostState.FAULT:
            self.reset_asked = False
        # nothing gets away
        for axis in range(2):
            rate = abs(float(self.rig.gimbal.plant.X[RATE + axis]))
            assert rate < host.memory.C[axis_c(axis) + MAX_RATE] + GAINED_RAD_S
        self.state, self.cause, self.drive_fault = host.state, host.cause, self.rig.gateway.fault


def _machine(make: str) -> type:
    found = type(f"Host_{make}", (_HostAndDrives,), {"make": make}).TestCase  # type: ignore[attr-defined]
    # a story takes seconds: what fails is told as it was drawn, not shortened for minutes
    found.settings = settings(
        max_examples=int(os.environ.get("MACHINE_EXAMPLES", "12")),
        stateful_step_count=15,
        phases=(Phase.explicit, Phase.reuse, Phase.generate),
    )
    return found


TestMoteus = _machine("moteus")
TestOdrive = _machine("odrive")
TestCia402 = _machine("cia402")
TestDbc = _machine("dbc")
