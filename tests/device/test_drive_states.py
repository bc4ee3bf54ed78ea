"""Whatever a host sends, the drive keeps to its states, its deadman and its latches."""

from __future__ import annotations

from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

from firmware_protocol.enumerations import DriveRequest, DriveState, FaultCode, StopReaction
from firmware_protocol.messages import AnyMessage, DeadmanConfig, DriveEvent, DriveStatus
from tests.device.bench import WINDOW, bench, control

_S = DriveState
#: transitions of CiA 402 that this drive has, faults apart
_LEGAL = {
    (_S.NOT_READY, _S.SWITCH_ON_DISABLED),
    (_S.SWITCH_ON_DISABLED, _S.READY_TO_SWITCH_ON),
    (_S.READY_TO_SWITCH_ON, _S.SWITCH_ON_DISABLED),
    (_S.READY_TO_SWITCH_ON, _S.SWITCHED_ON),
    (_S.SWITCHED_ON, _S.SWITCH_ON_DISABLED),
    (_S.SWITCHED_ON, _S.READY_TO_SWITCH_ON),
    (_S.SWITCHED_ON, _S.OPERATION_ENABLED),
    (_S.OPERATION_ENABLED, _S.SWITCHED_ON),
    (_S.OPERATION_ENABLED, _S.READY_TO_SWITCH_ON),
    (_S.OPERATION_ENABLED, _S.SWITCH_ON_DISABLED),
    (_S.OPERATION_ENABLED, _S.QUICK_STOP_ACTIVE),
    (_S.QUICK_STOP_ACTIVE, _S.SWITCH_ON_DISABLED),
    (_S.FAULT_REACTION_ACTIVE, _S.FAULT),
    (_S.FAULT, _S.SWITCH_ON_DISABLED),
} | {(state, _S.FAULT_REACTION_ACTIVE) for state in _S if state not in (_S.FAULT_REACTION_ACTIVE, _S.FAULT)}
_WITH_TORQUE = (_S.OPERATION_ENABLED, _S.QUICK_STOP_ACTIVE, _S.FAULT_REACTION_ACTIVE)
_POWERED = (_S.OPERATION_ENABLED, _S.QUICK_STOP_ACTIVE)

_torques = st.tuples(st.floats(-16.3, 16.3), st.floats(-16.3, 16.3))
_controls = st.builds(
    control,
    st.sampled_from(DriveRequest),
    fault_reset=st.booleans(),
    quick_stop=st.sampled_from((False, False, False, True)),
    clear_travel=st.booleans(),
)
_configs = st.builds(DeadmanConfig, st.integers(1, 255), st.sampled_from(StopReaction))


class DriveStates(RuleBasedStateMachine):
    """A host that does anything, a supply, windings and hands that do too."""

    @initialize(reaction=st.sampled_from(StopReaction), silence=st.sampled_from((0, 40)))
    def power_up(self, reaction: StopReaction, silence: int) -> None:
        self.bench = bench(
            travel=(-0.6, 0.6),
            deadman_reaction=reaction,
            fault_reaction=reaction,
            hold_s=0.02,
            reaction_timeout_s=0.05,
            control_silence_ticks=silence,
        )
        self.window, self.silent_ticks, self.reset_level = WINDOW, 0, True
        self.status: DriveStatus = self.bench.tick()
        self.bench.events.clear()

    @rule(torque=_torques, others=st.lists(_controls, max_size=1), config=st.lists(_configs, max_size=1))
    def fresh_set_point(self, torque: tuple[float, float], others: list[AnyMessage], config: list[AnyMessage]) -> None:
        self._tick(torque, [*others, *config])

    @rule(torque=_torques, request=_controls)
    def repeated_set_point(self, torque: tuple[float, float], request: AnyMessage) -> None:
        self._tick(torque, [request], sequence=self.bench.sequence)

    @rule(ticks=st.integers(1, 25))
    def silence(self, ticks: int) -> None:
        for _ in range(ticks):
            self._tick(None, [])

    @rule()
    def one_state_up(self) -> None:
        wanted = {
            _S.SWITCH_ON_DISABLED: DriveRequest.SHUTDOWN,
            _S.READY_TO_SWITCH_ON: DriveRequest.SWITCH_ON,
            _S.SWITCHED_ON: DriveRequest.ENABLE_OPERATION,
        }
        for _ in range(3):
            self._tick((0.5, 0.5), [control(wanted.get(self.status.state, DriveRequest.NONE))])

    @rule()
    def reset_the_fault(self) -> None:
        for level in (False, True):
            self._tick((0.0, 0.0), [control(fault_reset=level)])

    @rule(noise=st.binary(max_size=60))
    def garbage(self, noise: bytes) -> None:
        self._expect_after(self.status, lambda: self._receive(self.bench.device.tick(noise)), [])

    @rule(volts=st.sampled_from((28.0, 28.0, 10.0)))
    def supply(self, volts: float) -> None:
        self.bench.device.set_supply(volts)

    @rule(axis=st.integers(0, 1), degc=st.sampled_from((20.0, 20.0, 130.0)))
    def winding(self, axis: int, degc: float) -> None:
        self.bench.heat(axis, degc)

    @rule(axis=st.integers(0, 1), position=st.floats(-0.7, 0.7), rate=st.sampled_from((0.0, 2.0, -16.0, 19.5)))
    def hand(self, axis: int, position: float, rate: float) -> None:
        self.bench.place(axis, position)
        self.bench.spin(axis, rate)

    @invariant()
    def torque_only_where_it_may_be(self) -> None:
        if not hasattr(self, "bench"):
            return
        outer, inner = self.bench.torque
        assert abs(outer) <= 15.5 and abs(inner) <= 6.6
        if self.status.state not in _WITH_TORQUE:
            assert (outer, inner) == (0.0, 0.0)

    def _tick(self, torque: tuple[float, float] | None, others: list[AnyMessage], sequence: int | None = None) -> None:
        before = self.status
        last = before.last_sequence
        taken = int(self.bench.device.drive.taken)

        def go() -> DriveStatus:
            return self.bench.tick(torque, *others, sequence=sequence)

        self._expect_after(before, go, others)
        fresh = torque is not None and sequence is None
        assert int(self.bench.device.drive.taken) - taken == int(fresh)
        assert self.status.last_sequence == (self.bench.sequence if fresh else last)

    def _receive(self, block: bytes) -> DriveStatus:
        self.bench.answer = self.bench.wire.receiver.receive(block)  # type: ignore[attr-defined]
        self.bench.events += [message for message in self.bench.answer if isinstance(message, DriveEvent)]
        return self.bench.status

    def _expect_after(self, before: DriveStatus, go, others: list[AnyMessage]) -> None:  # type: ignore[no-untyped-def]
        self.bench.events.clear()
        taken = int(self.bench.device.drive.taken)
        after: DriveStatus = go()
        self.status = after
        self.silent_ticks = 0 if int(self.bench.device.drive.taken) > taken else self.silent_ticks + 1
        moved = before.state is not after.state
        assert after.tick == (before.tick + 1) % 4096
        assert [(e.from_state, e.to_state, e.tick) for e in self.bench.events] == (
            [(before.state, after.state, after.tick)] if moved else []
        )
        assert not moved or (before.state, after.state) in _LEGAL
        self._check_reset(before, after, others)
        if before.state not in _WITH_TORQUE and any(isinstance(message, DeadmanConfig) for message in others):
            self.window = next(message.window_ticks for message in others if isinstance(message, DeadmanConfig))
        if after.state in _POWERED:
            assert self.silent_ticks < self.window
            assert after.deadman_margin_ticks == self.window - self.silent_ticks
        if after.state is _S.OPERATION_ENABLED and moved:
            assert any(getattr(message, "request", None) is DriveRequest.ENABLE_OPERATION for message in others)

    def _check_reset(self, before: DriveStatus, after: DriveStatus, others: list[AnyMessage]) -> None:
        levels = [message.fault_reset for message in others if hasattr(message, "fault_reset")]
        edge = bool(levels) and levels[-1] and not self.reset_level
        self.reset_level = levels[-1] if levels else self.reset_level
        if before.state in (_S.FAULT, _S.FAULT_REACTION_ACTIVE):
            left = after.state is _S.SWITCH_ON_DISABLED
            assert not left or edge
            assert after.fault is (FaultCode.NONE if left else before.fault)
        assert (after.fault is FaultCode.NONE) == (after.state not in (_S.FAULT, _S.FAULT_REACTION_ACTIVE))


DriveStates.TestCase.settings = settings(max_examples=200, stateful_step_count=40, deadline=None)
TestDriveStates = DriveStates.TestCase
