"""The test before the first motion: a small known torque on each axis, and whether it turns the right way and gyro and
encoder say the same.

It runs as a program of the host like any other, so guards, limits and the log are as always; one axis is tried while
the other one's weight is held. The size follows from the configured `expectation`; an axis without one is not tried.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from itertools import pairwise

import numpy as np

from firmware_protocol import mail as m
from firmware_protocol.enumerations import FaultCode
from gimbal_hil.loop.control import TORQUE, TORQUE_LIMIT, Mode, gravity_torques
from gimbal_hil.loop.host import layout
from gimbal_hil.loop.host.host import Host
from gimbal_hil.loop.host.layout import MOMENTUM_WINDOW_S
from gimbal_hil.loop.host.program import AxisCommand, Program, Segment, program_of
from gimbal_hil.loop.host.states import HostCause, HostState, LinkStatus, Shape

#: joint rate that a pulse leads to without friction, and how long a pulse is
_RATE_RAD_S, _PULSE_S = 0.15, 0.015
#: there, twice as long back, there again, then a while of nothing
_PATTERN = (1.0, -1.0, -1.0, 1.0, 0.0, 0.0)
#: how much of the pattern is judged, in pulses
_JUDGED_PULSES = 5
#: motion for torque, and encoder for gyro, as shares of what is expected
_MOTION, _SENSORS = (0.3, 3.0), (0.7, 1.4)
#: motion of a sound axis whose inertia is the stated one: lags and friction take from it, a late rate adds to it
_SOUND = (0.7, 1.1)
#: motion beyond which somebody has to look: with half the counts or twice the gear position and rate are alike wrong,
#: and only who knows the inertia can tell that from another one
_AS_EXPECTED = (0.6, 1.3)
#: the second where the rate comes from the encoder too: turns for radians would be 6.3 times as much
_RATE_OF_ENCODER = (0.3, 3.0)
#: share of the ticks that must follow each other
_LEAST_SHARE = 0.5
#: a try that told nothing is made again after this long, twice as long each time
_FIRST_WAIT_S, _LONGEST_WAIT_S = 0.2, 10.0
_LINK_CAUSES = (HostCause.FEEDBACK_LOST, HostCause.SET_POINT_LOST)
_LINK_FAULTS = (FaultCode.DEADMAN, FaultCode.COMMUNICATION)
#: code of the events that tell how far the test is
FIRST_TEST = "first_test"


class FirstTestState(Enum):
    """How far the test is."""

    DUE = "due"
    RUNS = "runs"
    PASSED = "passed"
    FAILED = "failed"


@dataclass(frozen=True, slots=True)
class _Sample:
    tick: int
    torque: float
    rates: tuple[float, float]
    positions: tuple[float, float]
    #: whether feedback was fresh, and the antenna's own tick of it
    fresh: bool
    antenna_tick: int

    def follows(self, before: _Sample) -> bool:
        """Whether exactly one tick has passed on both sides."""
        antenna = (self.antenna_tick - before.antenna_tick) & m.DRIVE_STATUS_TICK_HIGH
        return self.fresh and before.fresh and self.tick == before.tick + 1 and antenna == 1


class FirstTest:
    """One test of one antenna. Call `before_tick` before every tick until it has passed or failed.

    Only the antenna can fail it. A try that the link, the machine or an operator spoilt says nothing about the antenna
    and is made again, after longer and longer waits; until one has passed, the caller lets nothing else move.
    """

    def __init__(
        self, host: Host, step_s: float, has_gyro: bool = True, known_within: Sequence[float] = (3.0, 3.0)
    ) -> None:
        """Without a gyro (`has_gyro` False) the rate is the encoder's own, read at another moment than the position:
        then only units that do not fit count as wrong. `known_within` are the factors within which the axes' inertias
        are known.
        """
        self._host, self._step_s, self._known_within = host, step_s, tuple(known_within)
        self._sensors = _SENSORS if has_gyro else _RATE_OF_ENCODER
        C = host.memory.C
        # the carried axis first: it is the one that falls where its motor does nothing
        self._tried = [a for a in reversed(range(layout.AXES)) if C[layout.axis_c(a) + layout.EXPECTED_INERTIA] > 0.0]
        self._samples: list[list[_Sample]] = [[], []]
        #: axis -> motion for its torque, as a share of what is expected
        self._right: dict[int, float] = {}
        self._spoilt_tries = self._due_at = 0
        #: the axis that is being tried
        self._axis = self._tried[0] if self._tried else 0
        #: why it failed, in words
        self.problem = ""
        #: why the last try told nothing, in words
        self.spoilt = ""
        self.state = FirstTestState.DUE if self._tried else FirstTestState.PASSED
        # compiled and paged in now: in the middle of the ticks a kernel costs half a second, and the solver's 32 MB of
        # work space 12 ms
        _weights_held(host)
        np.linalg.lstsq(np.eye(2), np.ones(2))

    def before_tick(self) -> Program | str:
        """Go on; answers what has just been given to the host, for the record: a program, or the word of a plain
        command ("stop", "fault_reset", "distrust"), empty where nothing was.
        """
        if self.state is FirstTestState.RUNS:
            return self._look()
        return self._begin() if self.state is FirstTestState.DUE and self._now >= self._due_at else ""

    def _begin(self) -> Program | str:
        host = self._host
        if host.state is HostState.IDLE:
            self._samples, self._right = [[], []], {}
            program = program_of([self._segment(axis) for axis in self._tried])
            host.command(program)
            self.state = FirstTestState.RUNS
            return program
        if host.state is HostState.FAULT and self._is_links_fault() and self._may_reconnect():
            # nobody may stand at the door of a daemon that has just been started
            host.reset_fault()
            self._due_at = self._now + self._wait_ticks
            return "fault_reset"
        return ""

    def _look(self) -> str:
        host, G = self._host, self._host.memory.G
        if host.state is HostState.FAULT:
            if self._is_links_fault():
                return self._again("the link was lost, or the machine stood still")
            if host.cause is HostCause.OPERATOR:
                return self._again("an operator stopped it")
            drive = FaultCode(int(G[layout.DRIVE_FAULT])) if host.cause is HostCause.DRIVE_FAULT else FaultCode.NONE
            why = f"the drive's {drive.name.lower()}" if drive else host.cause.name.lower()
            return self._fail(f"{host.axes[self._axis]} brought a fault ({why})")
        axis = int(G[layout.TICK_SEGMENT])
        if axis in self._tried and axis not in self._right:
            self._axis = axis
            self._samples[axis].append(self._sample(axis))
            elapsed = self._samples[axis][-1].tick - self._samples[axis][0].tick
            if elapsed >= _JUDGED_PULSES * self._pulse_ticks:
                return self._judge(axis)
        elif host.state is HostState.IDLE and not host.following:
            if len(self._right) == len(self._tried):
                self.state = FirstTestState.PASSED
            else:
                return self._again(f"it ended before {host.axes[self._axis]} was through ({host.cause.name.lower()})")
        return ""

    def _judge(self, axis: int) -> str:
        found = _measured(self._host, self._samples[axis], axis, self._step_s)
        if found is None:
            self._host.stop()
            self._again("too many ticks were missed to tell; see `gimbal-hil doctor`")
            return "stop"
        problem = _problem(self._host, axis, found, self._sensors) or self._other_inertia(axis, found.motion)
        if problem:
            return self._fail(problem)
        self._right[axis] = found.motion
        return ""

    def _other_inertia(self, axis: int, motion: float) -> str:
        """What speaks against a motion that an axis of the stated inertia does not make; empty where nothing does."""
        within, (least, most) = self._known_within[axis], _SOUND
        if least / within <= motion <= most * within:
            return ""
        return (
            f"{self._host.axes[axis]} moved {motion:.0%} of what its torque should do, and its inertia is known within "
            f"a factor of {within:g} (`expectation.inertia_within`): gear, encoder counts, or something else on it"
        )

    @property
    def said(self) -> str:
        """What a test that is over says: what is wrong, or how far each axis moved for its torque."""
        if self.problem:
            return self.problem
        low, high = _AS_EXPECTED
        moved = {self._host.axes[axis]: motion for axis, motion in sorted(self._right.items())}
        shares = ", ".join(f"{name} {motion:.0%}" for name, motion in moved.items())
        odd = " and ".join(name for name, motion in moved.items() if not low <= motion <= high)
        look = (
            f"; check gear, encoder counts and `expectation` of {odd}: turn it by hand by a known angle" if odd else ""
        )
        if not moved:
            return "first test: none, since no axis has an `expectation`"
        said = "first test: each axis turns as its torque, gyro and encoder say"
        return f"{said}; motion, of what is expected: {shares}{look}"

    def _again(self, why: str) -> str:
        self.state, self.spoilt = FirstTestState.DUE, why
        self._spoilt_tries += 1
        self._due_at = self._now + self._wait_ticks
        return ""

    def _fail(self, problem: str) -> str:
        self.problem, self.state = f"first test: {problem}", FirstTestState.FAILED
        self._host.distrust()
        return "distrust"

    def _is_links_fault(self) -> bool:
        """Whether the host's fault is silence on the way, seen from either end, and the drive has no other."""
        drive = FaultCode(int(self._host.memory.G[layout.DRIVE_FAULT]))
        of_the_drive = self._host.cause is HostCause.DRIVE_FAULT and drive in _LINK_FAULTS
        return of_the_drive or (self._host.cause in _LINK_CAUSES and drive in (FaultCode.NONE, *_LINK_FAULTS))

    def _may_reconnect(self) -> bool:
        G, C = self._host.memory.G, self._host.memory.C
        return C[layout.AUTOMATIC_RECONNECT] != 0.0 and G[layout.FRESH_IN_A_ROW] >= C[layout.CONNECT_TICKS]

    @property
    def _now(self) -> int:
        return int(self._host.memory.G[layout.LAST_TICK])

    @property
    def _wait_ticks(self) -> int:
        wait_s = min(_LONGEST_WAIT_S, _FIRST_WAIT_S * 2.0 ** min(self._spoilt_tries - 1, 10))
        return max(1, round(wait_s / self._step_s))

    @property
    def _pulse_ticks(self) -> int:
        return max(3, round(_PULSE_S / self._step_s))

    def _sample(self, axis: int) -> _Sample:
        H, G = self._host.memory.H, self._host.memory.G
        places = [layout.axis_h(a) for a in range(layout.AXES)]
        outer, inner = (H[h + layout.MEASURED_RATE] - H[h + layout.BASE_RATE] for h in places)
        positions = H[places[0] + layout.MEASURED_POSITION], H[places[1] + layout.MEASURED_POSITION]
        torque, fresh = float(H[places[axis] + TORQUE]), self._host.link_status is LinkStatus.OK
        tick, antenna_tick = int(G[layout.LAST_TICK]), int(G[layout.DEVICE_TICK])
        return _Sample(tick, torque, (outer, inner), positions, fresh, antenna_tick)

    def _segment(self, axis: int) -> Segment:
        """The pattern on one axis, on top of what holds the weight; the last number of the program is nothing."""
        held = _weights_held(self._host)
        C, c = self._host.memory.C, layout.axis_c(axis)
        size = C[c + layout.EXPECTED_INERTIA] * _RATE_RAD_S / (self._pulse_ticks * self._step_s)
        size = min(size, 0.5 * C[c + TORQUE_LIMIT])
        commands = [AxisCommand(Mode.TORQUE, Shape.HOLD, (held[a],)) for a in range(layout.AXES)]
        table = held[axis] + size * np.repeat(_PATTERN, self._pulse_ticks)
        commands[axis] = AxisCommand(Mode.TORQUE, Shape.TABLE, (self._step_s, 1.0), table=table)
        last = axis == self._tried[-1]
        return Segment(commands[0], commands[1], len(table), label=axis, switch_off_afterwards=last)


def _weights_held(host: Host) -> tuple[float, float]:
    """Torques (N m) against both bodies' weight as configured, where the axes stand now."""
    H, C = host.memory.H, host.memory.C
    x, y, z = (float(H[layout.BASE_GRAVITY + k]) for k in range(3))
    outer, inner = (float(H[layout.axis_h(axis) + layout.MEASURED_POSITION]) for axis in range(layout.AXES))
    moments = [layout.axis_c(axis) + layout.EXPECTED_MOMENT for axis in range(layout.AXES)]
    held = gravity_torques(outer, inner, (x, y, z), C, moments[0], moments[1])
    return float(held[0]), float(held[1])


@dataclass(frozen=True, slots=True)
class _Measured:
    """How an axis answered: its motion and the other one's for its torque, as shares of what is expected, the torque
    (N m) that made its rate grow besides, and what its encoder turned of what its gyro says.
    """

    motion: float
    crossed: float
    pull_nm: float
    sensors: float


def _measured(host: Host, samples: list[_Sample], axis: int, step_s: float) -> _Measured | None:
    """None where too many ticks were missed to tell: only samples that follow each other count, so that a busy machine
    makes no wrong verdict.
    """
    inertia = host.memory.C[layout.axis_c(axis) + layout.EXPECTED_INERTIA]
    pairs = [(one, two) for one, two in pairwise(samples) if two.follows(one)]
    if len(pairs) < _LEAST_SHARE * (samples[-1].tick - samples[0].tick):
        return None
    # the last rows of the pattern are nothing but what holds the weight
    torque = np.array([one.torque for one, _ in pairs]) - samples[-1].torque
    rates, moved = (
        np.array([np.subtract(getattr(two, what), getattr(one, what)) for one, two in pairs])
        for what in ("rates", "positions")
    )
    turned = 0.5 * step_s * np.array([one.rates[axis] + two.rates[axis] for one, two in pairs])
    # a load that nobody knows of makes the rate grow evenly
    columns = np.stack([torque * step_s / inertia, np.full(len(pairs), step_s)], axis=1)
    (motion, growth), *_ = np.linalg.lstsq(columns, rates[:, axis], rcond=None)
    (crossed, _), *_ = np.linalg.lstsq(columns, rates[:, 1 - axis], rcond=None)
    # a rate that stands still says nothing of the encoder, and is told as a motion that is not there
    sensors = float(moved[:, axis] @ turned / (turned @ turned)) if np.any(turned) else 0.0
    return _Measured(float(motion), float(crossed), float(abs(growth) * inertia), sensors)


def _problem(host: Host, axis: int, found: _Measured, within: tuple[float, float]) -> str:
    """What is wrong with an axis in words, empty when nothing is."""
    name, other = host.axes[axis], host.axes[1 - axis]
    motion, sensors = found.motion, found.sensors
    if motion < -_MOTION[0]:
        return f"{name} turned against its torque: its motor or its gyro is wired the wrong way round"
    if motion < _MOTION[0]:
        if abs(found.crossed) > _MOTION[0]:
            return f"{name}'s torque turned {other}: the motors or the gyros are swapped"
        return f"{name} moved {max(motion, 0.0):.0%} of what its torque should do: motor, brake, gyro or `expectation`"
    if found.pull_nm > host.memory.C[layout.axis_c(axis) + layout.DISTURBANCE] / MOMENTUM_WINDOW_S:
        return f"{name} is pulled by {found.pull_nm:.1f} N m that its `expectation` does not know of"
    if motion > _MOTION[1]:
        return f"{name} moved {motion:.1f} times what its torque should do: see `expectation`"
    if sensors < 0.0:
        return f"{name}'s encoder counts against its gyro: one of them is the wrong way round"
    if not within[0] <= sensors <= within[1]:
        return f"{name}'s encoder turned {sensors:.0%} of what its gyro says"
    return ""
