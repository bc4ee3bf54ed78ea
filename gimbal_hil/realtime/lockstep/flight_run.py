"""Host and device in one compiled loop, with a navigation that errs between them and the truth of every tick kept: what
a flight is certified by.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from firmware_protocol import mail as m
from firmware_protocol.compiling import assembled_entry_point, compiled
from gimbal_hil.loop.host import C_AT, COUNTERS_AT, H_AT, MAIL_AT, MUTED, OCTETS_AT, REQUESTS, SEGMENT_RUNS, host_tick
from sim_backend.base_motion import base_attitude
from sim_backend.device import DRIVE, device_tick
from sim_backend.layout import POSITION, STEP_S, STEPS

#: columns of the errors: roll, pitch, yaw and p, q, r in steps of the wire, and whether navigation is silent
ERROR_COLUMNS = 7
SILENT = 6
#: columns of the truth: both joints (rad), roll, pitch, yaw of the base (rad), and whether the transmitter is muted
TRUE_COLUMNS = 6
#: the wire counts when an attitude was true in 1 / 256 of a tick
FRACTIONS = 256


@assembled_entry_point(device_tick)
def run_flight(
    words: np.ndarray,
    plan: np.ndarray,
    P: np.ndarray,
    K: np.ndarray,
    X: np.ndarray,
    drive_words: np.ndarray,
    errors: np.ndarray,
    truth: np.ndarray,
    each: int,
    late: int,
    tick: int,
    ticks: int,
    until_done: bool,
) -> int:
    """Run up to `ticks` ticks from number `tick` on; answers how many were run. With `until_done` the run ends with the
    program.

    `words` are a HostMemory's, P, K, X and `drive_words` a Device's. `errors` int64 (n, ERROR_COLUMNS) are added to
    what navigation tells, a row for `each` ticks; every attitude is `late` / FRACTIONS ticks older than it says.
    `truth` (m, TRUE_COLUMNS) gets the row of each tick at its number, as things stand when the host has decided.
    """
    return _run_flight(words, plan, P, K, X, drive_words, errors, truth, each, late, tick, ticks, until_done)


@compiled
def _run_flight(
    words: np.ndarray,
    plan: np.ndarray,
    P: np.ndarray,
    K: np.ndarray,
    X: np.ndarray,
    drive_words: np.ndarray,
    errors: np.ndarray,
    truth: np.ndarray,
    each: int,
    late: int,
    tick: int,
    ticks: int,
    until_done: bool,
) -> int:
    # here and not in the entry point, because there every view would be counted
    G, mail = words[:MAIL_AT], words[MAIL_AT:COUNTERS_AT]
    H, C = words[H_AT:C_AT].view(np.float64), words[C_AT:OCTETS_AT].view(np.float64)
    drive = drive_words.view(DRIVE)[0]
    for k in range(ticks):
        now = tick + k
        row = truth[now]
        row[0], row[1] = X[POSITION], X[POSITION + 1]
        row[2], row[3], row[4] = base_attitude(P, K, X[STEPS] * P[STEP_S])
        host_tick(mail, H, G, C, plan, now)
        row[5] = float(G[MUTED])
        device_tick(mail, mail, P, K, X, drive)
        if mail[m.BASE_ATTITUDE] > 0 or mail[m.BASE_HEADING] > 0 or mail[m.BASE_RATE] > 0:
            spoil_navigation(mail, drive, errors[min(now // each, errors.shape[0] - 1)], late)
        if until_done and G[SEGMENT_RUNS] == 0 and G[REQUESTS] == 0:
            return k + 1
    return ticks


@compiled
def spoil_navigation(mail: np.ndarray, drive: Any, error: np.ndarray, late: int) -> None:
    """Put the errors of this moment into what navigation tells at this tick, or leave it out."""
    if error[SILENT] > 0:
        mail[m.BASE_ATTITUDE] = mail[m.BASE_HEADING] = mail[m.BASE_RATE] = mail[m.BASE_ACCELERATION] = 0
        return
    if mail[m.BASE_ATTITUDE] > 0:
        mail[m.BASE_ATTITUDE_ROLL] += error[0]
        mail[m.BASE_ATTITUDE_PITCH] += error[1]
        # the heading of the same moment is sent later, with the time at which both were true
        valid = drive.attitude_tick * FRACTIONS + drive.attitude_fraction + late
        drive.yaw = turned(drive.yaw + error[2])
        drive.attitude_tick = (valid // FRACTIONS) & m.BASE_HEADING_VALID_TICK_HIGH
        drive.attitude_fraction = valid % FRACTIONS
        mail[m.BASE_ATTITUDE_SET] = drive.attitude_tick & m.BASE_ATTITUDE_SET_HIGH
    if mail[m.BASE_RATE] > 0:
        for k in range(3):
            mail[m.BASE_RATE_P + k] += error[3 + k]


@compiled
def turned(raw: int) -> int:
    """A heading in steps of the wire, between half a turn to either side."""
    turn = int(2.0 * np.pi / m.BASE_HEADING_YAW_STEP + 0.5)
    if raw > m.BASE_HEADING_YAW_HIGH or 2 * raw > turn:
        return raw - turn
    return raw + turn if 2 * raw < -turn else raw
