"""A trivial antenna for tests of the host: two free inertias, a drive that obeys, and faults at will; speaks blocks."""

from __future__ import annotations

import numpy as np

from firmware_protocol import mail as m
from firmware_protocol.block_codec import encode_messages, new_counters, new_mail, new_receivers, receive_block
from firmware_protocol.schema import PROTOCOL_VERSION, name_code

INERTIA = (0.5, 0.07)
_NEXT = {
    (1, m.DRIVE_REQUEST_SHUTDOWN): 2,
    (2, m.DRIVE_REQUEST_SWITCH_ON): 3,
    (3, m.DRIVE_REQUEST_ENABLE_OPERATION): 4,
}


class FakeAntenna:
    """Double integrators behind frames. `silent` sends nothing, `friction` is viscous (N m s/rad)."""

    def __init__(self, step_s: float = 1e-3) -> None:
        self.step_s = step_s
        self.position, self.rate, self.torque = [0.0, 0.0], [0.0, 0.0], [0.0, 0.0]
        self.load = [0.0, 0.0]
        self.base_rate, self.base_acceleration, self.base_roll = [0.0, 0.0, 0.0], [0.0, 0.0, 0.0], 0.0
        self.gyro_error = [0.0, 0.0]
        self.drive_state, self.fault, self.last_sequence = m.DRIVE_STATE_SWITCH_ON_DISABLED, 0, 0
        self.silent, self.tick_stands_still, self.limits = False, False, 0
        self.motor_sign = [1.0, 1.0]
        self.friction = (0.06, 0.03)
        self.requests: list[tuple[int, int, int]] = []
        self.deadman: list[tuple[int, int]] = []
        self._reset_seen = 0
        self._mail, self._receivers, self._counters = new_mail(), new_receivers(), new_counters()
        self._out = np.zeros(512, dtype=np.uint8)
        self._messages = np.array([m.FEEDBACK_OUTER_MESSAGE, m.FEEDBACK_INNER_MESSAGE, m.DRIVE_STATUS_MESSAGE])
        base = (m.BASE_ATTITUDE_MESSAGE, m.BASE_RATE_MESSAGE, m.BASE_HEADING_MESSAGE, m.BASE_ACCELERATION_MESSAGE)
        self._with_base = np.array([*base, *self._messages])
        self._with_identity = np.array([m.IDENTITY_MESSAGE, m.IDENTITY_UNIT_MESSAGE, *self._with_base])
        self.protocol_version, self.name, self.serial_number, self.torque_exponents = (
            PROTOCOL_VERSION,
            "fake",
            7,
            (0, 0),
        )
        self.says_who_it_is, self.introduce_unasked = True, False
        self._ticks = 0

    def tick(self, received: bytes) -> bytes:
        """One tick: take the host's block, move, answer with a feedback set."""
        block = np.frombuffer(received, dtype=np.uint8).copy() if received else np.zeros(1, dtype=np.uint8)
        receive_block(block, len(received), self._mail, self._receivers, 0)
        messages = self.answer(self._mail)
        return self._out[: encode_messages(self._mail, messages, self._counters, self._out)].tobytes()

    def answer(self, mail: np.ndarray) -> np.ndarray:
        """One tick from the host's messages in the mail to the antenna's own in it; answers which ones it sends."""
        self._mail = mail
        self._obey()
        self._move()
        self._ticks += 1
        if self.silent:
            return self._messages[:0]
        self._fill(mail)
        mail[m.DRIVE_STATUS_STATE], mail[m.DRIVE_STATUS_FAULT] = self.drive_state, self.fault
        if not self.tick_stands_still:
            mail[m.DRIVE_STATUS_TICK] = self._ticks % 4096
        mail[m.DRIVE_STATUS_LAST_SEQUENCE], mail[m.DRIVE_STATUS_DEADMAN_MARGIN] = self.last_sequence, 20
        for k in range(3):
            mail[m.BASE_RATE_P + k] = round(self.base_rate[k] / m.BASE_RATE_P_STEP)
            mail[m.BASE_ACCELERATION_AX + k] = round(self.base_acceleration[k] / m.BASE_ACCELERATION_AX_STEP)
        mail[m.DRIVE_STATUS_LIMITS] = self.limits
        mail[m.BASE_ATTITUDE_ROLL] = round(self.base_roll / m.BASE_ATTITUDE_ROLL_STEP)
        messages = self._with_base if self._ticks % 10 == 1 else self._messages
        asked = mail[m.DRIVE_CONTROL] > 0 and mail[m.DRIVE_CONTROL_IDENTIFY] > 0
        if self.says_who_it_is and (asked or self.introduce_unasked):
            messages = self._with_identity
            self._introduce_itself()
        return messages

    def _fill(self, mail: np.ndarray, positions: dict[int, float] | None = None) -> None:
        """Put what the sensors read into the mail; `positions` (rad) in place of what an axis' encoder would say."""
        slots = ((m.FEEDBACK_OUTER_POSITION, m.FEEDBACK_OUTER_RATE), (m.FEEDBACK_INNER_POSITION, m.FEEDBACK_INNER_RATE))
        for axis, (position, rate) in enumerate(slots):
            mail[position] = round((positions or {}).get(axis, self.position[axis]) / m.FEEDBACK_OUTER_POSITION_STEP)
            mail[rate] = round(
                (self.rate[axis] + self._base_part(axis) + self.gyro_error[axis]) / m.FEEDBACK_OUTER_RATE_STEP
            )

    def _introduce_itself(self) -> None:
        mail = self._mail
        mail[m.IDENTITY_PROTOCOL_VERSION], mail[m.IDENTITY_NAME] = self.protocol_version, name_code(self.name)
        mail[m.IDENTITY_UNIT_SERIAL_NUMBER] = self.serial_number
        mail[m.IDENTITY_UNIT_TORQUE_EXPONENT_OUTER], mail[m.IDENTITY_UNIT_TORQUE_EXPONENT_INNER] = self.torque_exponents

    def _base_part(self, axis: int) -> float:
        p, q, r = self.base_rate
        return r if axis == 0 else float(np.cos(self.position[0]) * q - np.sin(self.position[0]) * p)

    def _obey(self) -> None:
        mail = self._mail
        if mail[m.DEADMAN_CONFIG] > 0:
            self.deadman.append((int(mail[m.DEADMAN_CONFIG_WINDOW_TICKS]), int(mail[m.DEADMAN_CONFIG_REACTION])))
        if mail[m.DRIVE_CONTROL] > 0:
            request, reset = int(mail[m.DRIVE_CONTROL_REQUEST]), int(mail[m.DRIVE_CONTROL_FAULT_RESET])
            quick_stop = int(mail[m.DRIVE_CONTROL_QUICK_STOP])
            self.requests.append((request, reset, quick_stop))
            if self.drive_state == m.DRIVE_STATE_FAULT and reset > self._reset_seen:
                self.drive_state, self.fault = m.DRIVE_STATE_SWITCH_ON_DISABLED, 0
            self._reset_seen = reset
            if quick_stop and self.drive_state == m.DRIVE_STATE_OPERATION_ENABLED:
                self.drive_state = m.DRIVE_STATE_QUICK_STOP_ACTIVE
            elif request == m.DRIVE_REQUEST_DISABLE_VOLTAGE and self.drive_state != m.DRIVE_STATE_FAULT:
                self.drive_state = m.DRIVE_STATE_SWITCH_ON_DISABLED
            self.drive_state = _NEXT.get((self.drive_state, request), self.drive_state)
        enabled = self.drive_state == m.DRIVE_STATE_OPERATION_ENABLED
        if mail[m.SET_POINT] > 0:
            self.last_sequence = int(mail[m.SET_POINT_SEQUENCE])
            for axis in range(2):
                allowed = enabled and mail[m.SET_POINT_ENABLE_OUTER + axis]
                self.torque[axis] = (
                    float(mail[m.SET_POINT_TORQUE_OUTER + axis]) * m.SET_POINT_TORQUE_OUTER_STEP if allowed else 0.0
                )

    def _move(self) -> None:
        for axis in range(2):
            drive = self.motor_sign[axis] * self.torque[axis] + self.load[axis] - self.friction[axis] * self.rate[axis]
            self.rate[axis] += drive / INERTIA[axis] * self.step_s
            self.position[axis] += self.rate[axis] * self.step_s
