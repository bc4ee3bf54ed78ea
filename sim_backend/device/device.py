"""The virtual antenna as Python sees it: a block of frames in, a block of frames out, one compiled call a tick."""

from __future__ import annotations

import numpy as np

from firmware_protocol import mail as m
from firmware_protocol.block_codec import age_receivers, clear_fresh, decode_block, encode_mail, new_receivers
from firmware_protocol.compiling import compiled, entry_point
from firmware_protocol.enumerations import BrakeState, DriveState, FaultCode
from firmware_protocol.receiver import CRC_ERRORS, DUPLICATES, OUT_OF_RANGE
from firmware_protocol.schema import MESSAGES, RECORD_SIZE, Direction
from sim_backend.device.core import applied_torque, device_tick
from sim_backend.device.records import DRIVE, DRIVE_WORDS, Drive
from sim_backend.device.settings import FirmwareSettings, settings_to_plant, settings_to_state
from sim_backend.device.spoiling import Spoilt, spoil
from sim_backend.layout import EFFECT_STATES, IN_FORCE, IN_FORCE_SIZE, K_SIZE, MAX_AXES, POSITION, RATE
from sim_backend.model import AntennaModel, plant_arrays

_FROM_HOST = int(Direction.HOST_TO_DEVICE)
#: slow messages first, then the feedback set, which drive_status closes: who has seen the status has seen all of the
#: tick
_SENDING_ORDER = np.array(
    [
        m.DRIVE_EVENT_MESSAGE,
        m.MOTOR_STATUS_OUTER_MESSAGE,
        m.MOTOR_STATUS_INNER_MESSAGE,
        m.BASE_ATTITUDE_MESSAGE,
        m.BASE_HEADING_MESSAGE,
        m.BASE_RATE_MESSAGE,
        m.BASE_ACCELERATION_MESSAGE,
        m.IDENTITY_MESSAGE,
        m.IDENTITY_UNIT_MESSAGE,
        m.FEEDBACK_OUTER_MESSAGE,
        m.FEEDBACK_INNER_MESSAGE,
        m.DRIVE_STATUS_MESSAGE,
    ],
    dtype=np.int64,
)
_FRESH_SLOTS = np.array(
    [
        m.DRIVE_EVENT,
        m.MOTOR_STATUS_OUTER,
        m.MOTOR_STATUS_INNER,
        m.BASE_ATTITUDE,
        m.BASE_HEADING,
        m.BASE_RATE,
        m.BASE_ACCELERATION,
        m.IDENTITY,
        m.IDENTITY_UNIT,
        m.FEEDBACK_OUTER,
        m.FEEDBACK_INNER,
        m.DRIVE_STATUS,
    ],
    dtype=np.int64,
)


#: bytes that the block received may have; and where the block to be sent stands behind it
_RECEIVED_SIZE = ANSWER_AT = 65536
#: places in a device's 64-bit words: drive, K, mail, alive counters, receivers, octets, then as float64 X and P
_RECEIVERS = new_receivers()
_ROWS, _COLUMNS = _RECEIVERS.shape
_K_AT = DRIVE_WORDS
_MAIL_AT = _K_AT + K_SIZE
_COUNTERS_AT = _MAIL_AT + m.MAIL_SIZE
_RECEIVERS_AT = _COUNTERS_AT + m.MESSAGE_COUNT
_OCTETS_AT = _RECEIVERS_AT + _RECEIVERS.size
_FLOATS_AT = _OCTETS_AT + (_RECEIVED_SIZE + RECORD_SIZE * len(MESSAGES) + 7) // 8
#: from where to where the octets are, of which the first are the block received
DEVICE_OCTETS = (_OCTETS_AT, _FLOATS_AT)


@compiled
def encode_device_mail(mail: np.ndarray, counters: np.ndarray, out: np.ndarray, position: int) -> int:
    """Encode what the device sends this tick in its sending order, from `position` on; answers the end position."""
    for place in range(_SENDING_ORDER.size):
        if mail[_FRESH_SLOTS[place]] > 0:
            position = encode_mail(mail, _SENDING_ORDER[place], counters, out, position)
    return position


@entry_point
def device_frame_tick(words: np.ndarray, x_size: int, received: int) -> int:
    """One tick with frames on both sides on a device's words: the block of `received` bytes at the start of the octets
    is decoded, the antenna goes on by one tick, its frames are encoded from ANSWER_AT on; answers how many bytes
    they are.

    One array instead of nine, because each costs a tenth of a microsecond at every call; X has `x_size` numbers.
    """
    return device_block_tick(words, x_size, received)


@compiled
def device_block_tick(words: np.ndarray, x_size: int, received: int) -> int:
    """`device_frame_tick` for those that are compiled themselves."""
    # here and not in the entry point, because there every view would be counted, a tenth of a microsecond in all
    drive, K, mail = words[:_K_AT].view(DRIVE)[0], words[_K_AT:_MAIL_AT], words[_MAIL_AT:_COUNTERS_AT]
    counters, receivers = words[_COUNTERS_AT:_RECEIVERS_AT], words[_RECEIVERS_AT:_OCTETS_AT].reshape(_ROWS, _COLUMNS)
    octets, floats = words[_OCTETS_AT:_FLOATS_AT].view(np.uint8), words[_FLOATS_AT:].view(np.float64)
    age_receivers(receivers, _FROM_HOST)
    clear_fresh(mail, _FROM_HOST)
    decode_block(octets[:_RECEIVED_SIZE], received, mail, receivers, _FROM_HOST)
    device_tick(mail, mail, floats[x_size:], K, floats[:x_size], drive)
    return encode_device_mail(mail, counters, octets, ANSWER_AT) - ANSWER_AT


class Device:
    """A virtual antenna: plant, firmware and its end of the wire.

    `P`, `K`, `X`, `drive` and `mail` are what `device_tick` works on; the compiled lockstep path uses them directly.
    """

    def __init__(
        self, model: AntennaModel, settings: FirmwareSettings | None = None, rate_hz: float = 1000.0, seed: int = 0
    ) -> None:
        self.model, self.rate_hz, self.seed = model, rate_hz, seed
        self.settings = settings or FirmwareSettings.for_model(model)
        arrays = plant_arrays(model, rate_hz, seed)
        self.x_size = len(arrays.X)
        self.words = words = np.zeros(_FLOATS_AT + len(arrays.X) + len(arrays.P), dtype=np.int64)
        self._octets = words[_OCTETS_AT:_FLOATS_AT].view(np.uint8).data
        floats = words[_FLOATS_AT:].view(np.float64)
        self.X, self.P = floats[: self.x_size], floats[self.x_size :]
        self.drive_words, self.K, self.mail = words[:_K_AT], words[_K_AT:_MAIL_AT], words[_MAIL_AT:_COUNTERS_AT]
        self.receivers = words[_RECEIVERS_AT:_OCTETS_AT].reshape(_ROWS, _COLUMNS)
        self.X[:], self.P[:] = arrays.X, arrays.P
        settings_to_plant(self.settings, self.P)
        self.drive: Drive = self.drive_words.view(DRIVE)[0]
        self.drive_words[:], self.K[:], self.receivers[:] = (
            settings_to_state(self.settings, rate_hz),
            arrays.K,
            _RECEIVERS,
        )

    def tick(self, received: bytes = b"") -> bytes:
        """Take a block of frames, whatever is in it, go on by one tick, and answer the block of this tick's feedback.

        Of a block beyond 64 KiB (six thousand frames) the newest frames count.
        """
        size = len(received)
        if size > _RECEIVED_SIZE:
            size = _RECEIVED_SIZE - _RECEIVED_SIZE % RECORD_SIZE
            end = len(received) - len(received) % RECORD_SIZE
            received = received[end - size : end]
        self._octets[:size] = received
        sent = device_frame_tick(self.words, self.x_size, size)
        return self._octets[ANSWER_AT : ANSWER_AT + sent].tobytes()

    @property
    def arrays(self) -> dict[str, np.ndarray]:
        """What decides what comes next: copied it is a checkpoint, written to it is put back."""
        return {"X": self.X, "drive": self.drive_words, "device_mail": self.mail}

    def take_over(self, before: Device) -> None:
        """Go on where another antenna stands, with this one's own model: an effect that sets in while it runs."""
        words, others = self.words, before.words
        words[:_K_AT], words[_MAIL_AT:_OCTETS_AT] = others[:_K_AT], others[_MAIL_AT:_OCTETS_AT]
        own = self.X[IN_FORCE : IN_FORCE + MAX_AXES * IN_FORCE_SIZE].copy()
        self.X[:EFFECT_STATES] = before.X[:EFFECT_STATES]
        self.X[IN_FORCE : IN_FORCE + len(own)] = own

    @property
    def state(self) -> DriveState:
        """State of the drive."""
        return DriveState(int(self.drive.state))

    @property
    def fault(self) -> FaultCode:
        """Latched fault."""
        return FaultCode(int(self.drive.fault))

    @property
    def ticks(self) -> int:
        """Ticks since power-up."""
        return int(self.drive.tick)

    @property
    def joint_positions(self) -> tuple[float, ...]:
        """True joint positions, rad (m on a linear axis)."""
        return tuple(float(x) for x in self.X[POSITION : POSITION + len(self.model.axes)])

    @property
    def joint_rates(self) -> tuple[float, ...]:
        """True joint rates, rad/s (m/s on a linear axis)."""
        return tuple(float(x) for x in self.X[RATE : RATE + len(self.model.axes)])

    @property
    def torques_nm(self) -> tuple[float, ...]:
        """Torque that the drive applied in the last tick, N m (N on a linear axis)."""
        return tuple(float(applied_torque(self.drive.joints[axis])) for axis in range(len(self.model.axes)))

    def brake(self, axis: int) -> BrakeState:
        """Where an axis' holding brake stands."""
        return BrakeState(int(self.drive.joints[axis].brake_state))

    @property
    def set_points(self) -> tuple[int, int]:
        """Set-points that fed the deadman, and repeats or stale ones that did not."""
        return int(self.drive.taken), int(self.drive.refused)

    @property
    def bad_frames(self) -> int:
        """Frames dropped so far because of their CRC, a field's range, a strange identifier or a fragment."""
        return int(self.receivers[:-1, [CRC_ERRORS, OUT_OF_RANGE]].sum() + self.receivers[-1].sum())

    @property
    def repeated_frames(self) -> int:
        """Frames dropped so far because their alive counter repeats, comes late, or is that of a host that has just
        started anew.
        """
        return int(self.receivers[:-1, DUPLICATES].sum())

    def spoil(self, axis: int, part: str, kind: Spoilt, amount: int = 0) -> None:
        """Give an axis a fault of its `encoder`, `gyro` or `motor` from the next tick on, as on a bench; see
        `Spoilt`.
        """
        spoil(self.drive, axis, part, kind, amount)

    def set_supply(self, supply_v: float) -> None:
        """Let the supply have another voltage, as on a bench: below the firmware's least one the drive faults."""
        self.drive.supply = min(
            max(round(supply_v / m.MOTOR_STATUS_OUTER_SUPPLY_STEP), 0), m.MOTOR_STATUS_OUTER_SUPPLY_HIGH
        )
