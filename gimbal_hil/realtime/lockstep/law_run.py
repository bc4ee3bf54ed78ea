"""Host and device in one compiled loop, the host's loops replaced by a sampled linear law: what controllers are
compared with. References, guards and what is fed forward stay the host's.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from firmware_protocol import mail as m
from firmware_protocol.block_codec import quantise
from firmware_protocol.compiling import assembled_entry_point, compiled
from gimbal_hil.loop.control import BASE_RATE_SHARE, LOOP_ERROR, SHAPED_RATE, TORQUE, TORQUE_LIMIT, Mode
from gimbal_hil.loop.host import (
    AXIS_C,
    AXIS_C_SIZE,
    AXIS_G,
    AXIS_G_SIZE,
    AXIS_H,
    AXIS_H_SIZE,
    BASE_RATE,
    C_AT,
    COUNTERS_AT,
    H_AT,
    LOG_WORDS,
    MAIL_AT,
    MEASURED_RATE,
    MODE,
    MOST_TORQUE,
    OCTETS_AT,
    REQUESTS,
    SEGMENT_RUNS,
    TORQUE_STEP,
    host_tick,
    write_row,
)
from gimbal_hil.loop.settings import DaemonSettings
from gimbal_hil.realtime.lockstep.paths import CHUNK_ROWS, CompiledPath, Recorded
from sim_backend.device import DRIVE, device_tick
from sim_backend.layout import POSITION
from sim_backend.model import AntennaModel

Table = NDArray[np.float64]
_POSITION = int(Mode.POSITION)


@assembled_entry_point(device_tick)
def run_law(
    words: np.ndarray,
    plan: np.ndarray,
    P: np.ndarray,
    K: np.ndarray,
    X: np.ndarray,
    drive_words: np.ndarray,
    law: np.ndarray,
    states: np.ndarray,
    rows: np.ndarray,
    joints: np.ndarray,
    tick: int,
    step_ns: int,
) -> int:
    """Run as many ticks as `rows` int64 (n, LOG_WORDS) has room for, or to the end of the program; answers how many.

    `law` float64 (2, k + 1, k + 2) holds [A B; C D] of each axis: states and torque (N m) from the errors of position
    (rad) and inertial rate (rad/s). `states` (2, 2, k): those of each axis, and room for the next. `joints` (n, 2)
    gets the true positions (rad) as the host decides.
    """
    return _run_law(words, plan, P, K, X, drive_words, law, states, rows, joints, tick, step_ns)


@compiled
def _run_law(
    words: np.ndarray,
    plan: np.ndarray,
    P: np.ndarray,
    K: np.ndarray,
    X: np.ndarray,
    drive_words: np.ndarray,
    law: np.ndarray,
    states: np.ndarray,
    rows: np.ndarray,
    joints: np.ndarray,
    tick: int,
    step_ns: int,
) -> int:
    # here and not in the entry point, because there every view would be counted
    G, mail = words[:MAIL_AT], words[MAIL_AT:COUNTERS_AT]
    H, C = words[H_AT:C_AT].view(np.float64), words[C_AT:OCTETS_AT].view(np.float64)
    drive, row_floats = drive_words.view(DRIVE)[0], rows.view(np.float64)
    for k in range(rows.shape[0]):
        now = tick + k
        joints[k, 0], joints[k, 1] = X[POSITION], X[POSITION + 1]
        host_tick(mail, H, G, C, plan, now)
        for axis in range(2):
            if G[AXIS_G + axis * AXIS_G_SIZE + MODE] == _POSITION:
                send_law(mail, H, C, law[axis], states[axis], axis)
            else:
                for i in range(states.shape[2]):
                    states[axis, 0, i] = 0.0
        write_row(rows[k], row_floats[k], H, G, now, now * step_ns, 0)
        device_tick(mail, mail, P, K, X, drive)
        if G[SEGMENT_RUNS] == 0 and G[REQUESTS] == 0:
            return k + 1
    return int(rows.shape[0])


@compiled
def send_law(mail: np.ndarray, H: np.ndarray, C: np.ndarray, law: np.ndarray, state: np.ndarray, axis: int) -> None:
    """Add the law's torque to what the host feeds forward; a law that asks for more than there is stands still."""
    h, c, size = AXIS_H + axis * AXIS_H_SIZE, AXIS_C + axis * AXIS_C_SIZE, state.shape[1]
    off = H[h + LOOP_ERROR]
    slow = H[h + SHAPED_RATE] + C[c + BASE_RATE_SHARE] * H[h + BASE_RATE] - H[h + MEASURED_RATE]
    torque = law[size, size] * off + law[size, size + 1] * slow
    for j in range(size):
        torque += law[size, j] * state[0, j]
    limit = C[c + TORQUE_LIMIT]
    wanted = H[h + TORQUE] + torque
    if abs(wanted) <= limit:
        for i in range(size):
            after = law[i, size] * off + law[i, size + 1] * slow
            for j in range(size):
                after += law[i, j] * state[0, j]
            state[1, i] = after
        for i in range(size):
            state[0, i] = state[1, i]
    most = int(H[h + MOST_TORQUE])
    raw = quantise(min(max(wanted, -limit), limit), H[h + TORQUE_STEP], -most, most)
    mail[m.SET_POINT_TORQUE_OUTER + axis] = raw
    H[h + TORQUE] = raw * H[h + TORQUE_STEP]


class LawPath(CompiledPath):
    """`law` as in `run_law`; the settings' own loops must ask for nothing (gains of zero, no observer)."""

    def __init__(self, settings: DaemonSettings, model: AntennaModel, seed: int, law: Table) -> None:
        super().__init__(settings, model, seed)
        self._law, self._states = law, np.zeros((2, 2, law.shape[1] - 1))
        self._joints: list[Table] = []
        self._began = 0

    def advance(self, ticks: int, *, until_done: bool = False, every: int = 1) -> Recorded:
        """As `CompiledPath`; stretches that end with the program go through the law."""
        if not until_done:
            return super().advance(ticks, every=every)
        if not self._joints:
            self._began = self.tick
        host, device, first, logs, events = self.host, self.device, self.tick, [], []
        while self.tick < first + ticks:
            rows = np.empty((min(CHUNK_ROWS, first + ticks - self.tick), LOG_WORDS), dtype=np.int64)
            joints = np.empty((len(rows), 2))
            done = run_law(
                host.memory.words,
                host.plan,
                device.P,
                device.K,
                device.X,
                device.drive_words,
                self._law,
                self._states,
                rows,
                joints,
                self.tick,
                self.step_ns,
            )
            self.tick += done
            logs.append(rows[:done])
            self._joints.append(joints[:done])
            events += host.events()
            if not host.following:
                break
        return self._recorded(first, logs, [], events)

    def joints(self, first: int) -> Table:
        """True positions (n, 2) from a tick on, the first one of a program."""
        return np.concatenate(self._joints)[first - self._began :]
