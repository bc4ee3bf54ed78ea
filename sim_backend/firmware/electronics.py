"""What stands behind the C device's hardware-access layer: the plant with its motors, brakes and sensors.

The virtual antenna's own record of the drive serves as the electronics: what the C device wants of its motors is put
into it, and its sensors, with the faults that they were given, are read as the virtual antenna reads them.
"""

from __future__ import annotations

import numpy as np

from firmware_protocol import mail as m
from firmware_protocol.compiling import compiled, entry_point
from sim_backend.device import DRIVE, Drive, report_base_attitude, report_base_rate, report_motor, sample, spoilt_torque
from sim_backend.layout import AXES, HELD, HELD_AT, POSITION, HeldBy
from sim_backend.step import plant_tick

_SHORTED, _BRAKED = int(HeldBy.SHORTED_WINDING), int(HeldBy.HOLDING_BRAKE)
#: slots of an axis in `wanted`: torque, power stage on, winding shorted, brake closed
WANTED_SIZE = 4
#: slots of an axis in `sensed`: position, rate, torque, winding, valid; then roll, pitch, yaw, p, q, r
SENSED_SIZE, BASE_SIZE = 5, 6


@entry_point
def pass_tick(
    P: np.ndarray,
    K: np.ndarray,
    X: np.ndarray,
    drive_words: np.ndarray,
    mail: np.ndarray,
    wanted: np.ndarray,
    sensed: np.ndarray,
) -> None:
    """Let one tick pass as the C device wants it (`wanted`, int64 (2 WANTED_SIZE,)) and read the sensors into `sensed`,
    int64 (2 SENSED_SIZE + BASE_SIZE,), raw integers.

    P, K, X, `drive_words` and `mail` are a `Device`'s; `mail` is scratch.
    """
    _pass_tick(P, K, X, drive_words.view(DRIVE)[0], mail, wanted, sensed)


@compiled
def _pass_tick(
    P: np.ndarray,
    K: np.ndarray,
    X: np.ndarray,
    drive: Drive,
    mail: np.ndarray,
    wanted: np.ndarray,
    sensed: np.ndarray,
) -> None:
    drive.tick += 1
    for axis in range(K[AXES]):
        at = axis * WANTED_SIZE
        drive.joints[axis].shorted = wanted[at + 2]
        held = _SHORTED if wanted[at + 2] == 1 else 0
        if wanted[at + 3] == 1:
            if int(X[HELD + axis]) & _BRAKED == 0:
                X[HELD_AT + axis] = X[POSITION + axis]
            held |= _BRAKED
        X[HELD + axis] = held
    plant_tick(P, K, X, (_motor_torque(K, drive, wanted, 0), _motor_torque(K, drive, wanted, 1)))
    sample(P, K, X, drive)
    for axis in range(K[AXES]):
        at, joint = axis * SENSED_SIZE, drive.joints[axis]
        report_motor(mail, P, K, X, drive, axis)
        sensed[at], sensed[at + 1] = joint.encoder, joint.gyro
        sensed[at + 2] = mail[m.MOTOR_STATUS_OUTER_TORQUE + axis * (m.MOTOR_STATUS_INNER - m.MOTOR_STATUS_OUTER)]
        sensed[at + 3] = joint.winding
        sensed[at + 4] = 0 if joint.sensor_fault == m.FAULT_CODE_INTERNAL else 1
    report_base_attitude(mail, P, K, X, drive)
    report_base_rate(mail, P, K, X)
    at = 2 * SENSED_SIZE
    sensed[at], sensed[at + 1], sensed[at + 2] = mail[m.BASE_ATTITUDE_ROLL], mail[m.BASE_ATTITUDE_PITCH], drive.yaw
    sensed[at + 3], sensed[at + 4], sensed[at + 5] = mail[m.BASE_RATE_P], mail[m.BASE_RATE_Q], mail[m.BASE_RATE_R]


@compiled
def _motor_torque(K: np.ndarray, drive: Drive, wanted: np.ndarray, axis: int) -> float:
    """Torque (N m) that the motor of an axis makes: another one than was wanted when it was spoilt."""
    if axis >= K[AXES]:
        return 0.0
    at = axis * WANTED_SIZE
    joint = drive.joints[axis]
    torque = spoilt_torque(joint, wanted[at], wanted[at + 1] == 1)
    return float(torque << joint.exponent) * m.SET_POINT_TORQUE_OUTER_STEP
