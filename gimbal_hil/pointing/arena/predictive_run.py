"""Host and device tick by tick, the host's torques replaced by predictive control on the estimates of its observers:
what controllers are compared with. References, guards, estimates and what is fed forward stay the host's. The quadratic
programs are solved by daqp (extra `predictive`).
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firmware_protocol import mail as m
from firmware_protocol.block_codec import quantise
from firmware_protocol.compiling import assembled_entry_point
from firmware_protocol.errors import BadInputError
from gimbal_hil.knowledge.tuning import PredictedJoint
from gimbal_hil.loop.control import Mode, clamp
from gimbal_hil.loop.control import layout as control
from gimbal_hil.loop.host import (
    AXIS_H,
    AXIS_H_SIZE,
    C_AT,
    COUNTERS_AT,
    H_AT,
    LOG_WORDS,
    MAIL_AT,
    MOST_TORQUE,
    OCTETS_AT,
    TORQUE_STEP,
    host_tick,
    layout,
    write_row,
)
from gimbal_hil.loop.settings import DaemonSettings
from gimbal_hil.realtime.lockstep import CompiledPath, Recorded
from sim_backend.device import DRIVE, device_tick
from sim_backend.layout import POSITION
from sim_backend.model import AntennaModel

Table = NDArray[np.float64]
#: a constraint that may be broken where there is no other way, as daqp marks it
_SOFT = 8


@assembled_entry_point(device_tick)
def decide(words: np.ndarray, plan: np.ndarray, tick: int) -> None:
    """The host's tick."""
    G, mail = words[:MAIL_AT], words[MAIL_AT:COUNTERS_AT]
    H, C = words[H_AT:C_AT].view(np.float64), words[C_AT:OCTETS_AT].view(np.float64)
    host_tick(mail, H, G, C, plan, tick)


@assembled_entry_point(device_tick)
def answer(
    words: np.ndarray,
    torques: np.ndarray,
    P: np.ndarray,
    K: np.ndarray,
    X: np.ndarray,
    drive_words: np.ndarray,
    row: np.ndarray,
    tick: int,
    step_ns: int,
) -> None:
    """The device's tick under `torques` (N m; NaN: what the host sent), and the row int64 (LOG_WORDS,) of both."""
    G, mail = words[:MAIL_AT], words[MAIL_AT:COUNTERS_AT]
    H = words[H_AT:C_AT].view(np.float64)
    drive = drive_words.view(DRIVE)[0]
    for axis in range(2):
        if torques[axis] == torques[axis]:
            h = AXIS_H + axis * AXIS_H_SIZE
            most = int(H[h + MOST_TORQUE])
            raw = quantise(torques[axis], H[h + TORQUE_STEP], -most, most)
            mail[m.SET_POINT_TORQUE_OUTER + axis] = raw
            H[h + control.TORQUE] = raw * H[h + TORQUE_STEP]
            # what the observer knows to be on its way
            H[h + control.PENDING] = (H[h + control.TORQUE] - H[h + control.DRAG]) / H[h + control.MOVED_INERTIA]
    write_row(row, row.view(np.float64), H, G, tick, tick * step_ns, 0)
    device_tick(mail, mail, P, K, X, drive)


class Predictor:
    """The program of one joint, solved anew each tick from where it was solved before."""

    def __init__(self, joint: PredictedJoint, rate_limit_rad_s: float) -> None:
        try:
            import daqp
        except ImportError:
            raise BadInputError(
                "controller mpc", "needs daqp, which is not installed", 'pip install "gimbal-hil[predictive]"'
            ) from None
        self._joint, self._rate_limit = joint, rate_limit_rad_s
        self._rows = n = len(joint.hessian)
        sense = np.array([0] * n + [_SOFT] * n, dtype=np.int32)
        self._program: Any = daqp.Model()
        wide = np.full(2 * n, 1e6)
        flag, _ = self._program.setup(joint.hessian, np.zeros(n), joint.to_rate, wide, -wide, sense)
        if flag < 0:
            raise ArithmeticError(f"the program of the joint cannot be set up: daqp says {flag}")

    def move(self, behind: tuple[float, float], rate: float, low: float, high: float) -> float:
        """First move (rad/s^2) within `low` and `high` for a joint that turns at `rate` and is `behind` its reference
        (rad, rad/s).
        """
        n = self._rows
        upper, lower = np.full(2 * n, high), np.full(2 * n, low)
        upper[n:], lower[n:] = self._rate_limit - rate, -self._rate_limit - rate
        self._program.update(f=self._joint.of_state @ np.array(behind), bupper=upper, blower=lower)
        moves, _, flag, _ = self._program.solve()
        if flag <= 0:
            raise ArithmeticError(f"the program of the joint has no solution: daqp says {flag}")
        return clamp(float(moves[0]), low, high)


class PredictivePath(CompiledPath):
    """Predictive control of both axes in modes of a position; the settings' loops are an observer's."""

    def __init__(
        self, settings: DaemonSettings, model: AntennaModel, seed: int, joints: tuple[PredictedJoint, ...]
    ) -> None:
        super().__init__(settings, model, seed)
        C = self.host.memory.C
        self._predictors = [
            Predictor(joint, C[layout.axis_c(axis) + control.RATE_REFERENCE_LIMIT]) for axis, joint in enumerate(joints)
        ]
        self._joints: list[tuple[float, float]] = []
        self._began = 0
        #: processor time of both programs together, s, one a tick
        self.solving_s: list[float] = []

    def advance(self, ticks: int, *, until_done: bool = False, every: int = 1) -> Recorded:
        """As `CompiledPath`; stretches that end with the program are predicted."""
        if not until_done:
            return super().advance(ticks, every=every)
        if not self._joints:
            self._began = self.tick
        host, device, first, events, rows = self.host, self.device, self.tick, [], []
        while self.tick < first + ticks:
            row = np.empty(LOG_WORDS, dtype=np.int64)
            self._joints.append((float(device.X[POSITION]), float(device.X[POSITION + 1])))
            decide(host.memory.words, host.plan, self.tick)
            began = time.thread_time()
            torques = np.array([self._torque(axis) for axis in range(2)])
            self.solving_s.append(time.thread_time() - began)
            answer(
                host.memory.words,
                torques,
                device.P,
                device.K,
                device.X,
                device.drive_words,
                row,
                self.tick,
                self.step_ns,
            )
            self.tick += 1
            rows.append(row)
            if not self.tick % 32 or not host.following:
                events += host.events()
            if not host.following:
                break
        return self._recorded(first, [np.array(rows)], [], events)

    def joints(self, first: int) -> Table:
        """True positions (n, 2) from a tick on, the first one of a program."""
        return np.array(self._joints)[first - self._began :]

    def _torque(self, axis: int) -> float:
        """Torque (N m) of an axis, NaN where the host's is sent."""
        if self.host.memory.G[layout.axis_g(axis) + layout.MODE] != int(Mode.POSITION):
            return np.nan
        H = self.host.memory.H[layout.axis_h(axis) :][: control.LEARNED_TABLE].tolist()
        C = self.host.memory.C[layout.axis_c(axis) :][: control.OBSERVER_GAIN].tolist()
        step_s, delay = self.step_ns * 1e-9, int(C[control.DELAY_TICKS])
        q, v, w = H[control.EST_POSITION], H[control.EST_RATE], H[control.EST_DISTURBANCE]
        # this tick's torque of the host stands first; those before it act until ours does
        for k in range(delay, 0, -1):
            acceleration = H[control.PENDING + k] + w
            q += step_s * (v + 0.5 * step_s * acceleration)
            v += step_s * acceleration
        ahead, curve = delay * step_s, H[control.SHAPED_ACCELERATION]
        behind = H[control.SHAPED_POSITION] + ahead * (H[control.SHAPED_RATE] + 0.5 * ahead * curve) - q
        slower = H[control.SHAPED_RATE] + ahead * curve - v
        inertia, drag, limit = H[control.MOVED_INERTIA], H[control.DRAG], C[control.TORQUE_LIMIT]
        low, high = ((side * limit - drag) / inertia - curve + w for side in (-1.0, 1.0))
        move = self._predictors[axis].move((behind, slower), v, low, high)
        return clamp(inertia * (curve + move - w) + drag, -limit, limit)
