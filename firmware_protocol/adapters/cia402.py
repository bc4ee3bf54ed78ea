"""CiA 402 drives over CANopen: cyclic synchronous torque by PDO, set up by SDO when the bus is opened.

Facts from CiA 402 / IEC 61800-7-201 (objects 0x6040, 0x6041, 0x6060, 0x6064, 0x606C, 0x6071, 0x6077; states in the
statusword) and CiA 301 (NMT, SYNC, expedited SDO, PDO mapping, heartbeat). Torque is in thousandths of the motor's
rated torque (0x6076), position in increments: both are stated in the configuration. The drive watches this side's
heartbeat (0x1016) where it can; what it does without one is its object 0x6007. A drive that cannot is held against
NMT stop, which has the same consequence.
"""

from __future__ import annotations

import math
import struct
from collections import deque
from dataclasses import replace

from firmware_protocol.adapters.drive import AxisSample, DriveTiming, Gives, Power
from firmware_protocol.adapters.sdo import SDO_ANSWER, answer_of, asked, written
from firmware_protocol.adapters.spoken import Spoken
from firmware_protocol.errors import BadInputError
from firmware_protocol.links import CanFrame, DriveSection

_EMERGENCY = 0x80
NMT, SYNC, STATUS_PDO, MOTION_PDO, COMMAND_PDO = 0x000, 0x80, 0x180, 0x280, 0x200
HEARTBEAT, HOST_NODE = 0x700, 127
_OPERATIONAL, _BOOT_UP, _START, _HALT = 5, 0, 1, 2
_DISABLE, _SHUTDOWN, _SWITCH_ON, _ENABLE, _QUICK_STOP, _RESET = 0x00, 0x06, 0x07, 0x0F, 0x02, 0x80
_CYCLIC_TORQUE = 10
_OFF, _EVERY_SYNC, _ON_CHANGE = 0x8000_0000, 1, 255
_HEARTBEAT_CONSUMER, _ERROR_CODE, _DEVICE_TYPE = 0x1016, 0x603F, 0x1000
_LARGEST = 32767
#: periods without a statusword after which a node is started again: one that missed heartbeats leaves that state
_SILENT_TICKS = 50
_WORDS = {
    SDO_ANSWER: "answer to SDO",
    STATUS_PDO: "statusword and position",
    MOTION_PDO: "rate and torque",
    _EMERGENCY: "emergency",
    HEARTBEAT: "heartbeat",
}
_POWERS = {0x27: Power.ON, 0x07: Power.STOPPING, 0x0F: Power.REACTING, 0x08: Power.FAULT}
#: controlword that leads one state on, by the state that the statusword tells
_STEPS = {0x40: _SHUTDOWN, 0x21: _SWITCH_ON, 0x23: _ENABLE, 0x27: _ENABLE}


class Cia402Drive:
    """One CANopen node with the drive profile."""

    is_asked = True
    gives = frozenset({Gives.RATE, Gives.TORQUE})

    def __init__(self, section: DriveSection, timing: DriveTiming) -> None:
        if section.counts_per_turn is None or section.rated_torque_nm is None:
            missing = "counts_per_turn" if section.counts_per_turn is None else "rated_torque_nm"
            raise BadInputError(
                f"link.drives: {missing}", "is missing", "a number, which a CiA 402 drive does not tell"
            )
        if not section.id:
            raise BadInputError("link.drives: id", "0 is no CANopen node", "1 to 127")
        most_nm, shaft_nm = 1e-3 * _LARGEST * section.rated_torque_nm, section.torque_nm / section.gear
        if shaft_nm > most_nm:
            raise BadInputError(
                "link.drives: torque_nm",
                f"{shaft_nm:.6g} N m at the shaft, and 0x6071 carries {most_nm:.6g} N m at most",
                "a smaller one, or the drive's 0x6076 as rated_torque_nm, in N m",
            )
        self._id = section.id
        self._radian, self._rated = 2.0 * math.pi / section.counts_per_turn, section.rated_torque_nm
        self._watchdog_ms = max(1, round(timing.watchdog_s * 1e3))
        self.answers_s = timing.watchdog_s
        self._writes: deque[tuple[int, int, int, int]] = deque()
        self._status = 0
        self._silent = self._starved = 0
        self._error = self._refused = ""
        self._watches = True
        self._outbox: list[CanFrame] = []
        remedy = "answers SYNC only once it is set up and started: see its faults, or whether another master stops it"
        self.spoken = (
            Spoken("answer to SDO", f"power, wiring, bit rate and node {section.id}"),
            Spoken("statusword and position", remedy),
            Spoken("rate and torque", remedy),
        )
        self.sample = AxisSample()

    def sender_of(self, frame: CanFrame) -> int | None:
        node = frame.identifier & 0x7F
        kind = frame.identifier - node
        return node if node and not frame.extended and kind in _WORDS and node != HOST_NODE else None

    def question_to(self, number: int) -> CanFrame | None:
        return asked(number, _DEVICE_TYPE, 0)

    def word_of(self, frame: CanFrame) -> str:
        return "" if frame.extended else _WORDS.get(frame.identifier - self._id, "")

    def begin(self) -> list[CanFrame]:
        self._writes, self._refused = deque(self._set_up()), ""
        return [self._next_write()]

    def ask(self) -> list[CanFrame]:
        self._starved = 0
        return [*self._queued(), CanFrame(HEARTBEAT + HOST_NODE, bytes([_OPERATIONAL])), *self._sync()]

    def enable(self) -> list[CanFrame]:
        # nothing leads out of a fault here; out of a stop only switching off does
        return [self._command(_STEPS.get(state_of(self._status), _DISABLE), 0.0), *self.ask()]

    def command(self, torque_nm: float) -> list[CanFrame]:
        # a drive that stopped by itself is not to go on because of the next set-point (transition 16)
        word = _QUICK_STOP if self.sample.power is Power.STOPPING else _ENABLE
        return [self._command(word, torque_nm), *self.ask()]

    def release(self) -> list[CanFrame]:
        # the one word that leads to no torque from every state: "shut down" leads nowhere out of a quick stop
        return [self._command(_DISABLE, 0.0)]

    def stop(self) -> list[CanFrame]:
        return [self._command(_QUICK_STOP, 0.0)]

    def starve(self) -> list[CanFrame]:
        self._starved += 1
        halts = not self._watches and self._starved % _SILENT_TICKS == 1
        halted = [CanFrame(NMT, bytes([_HALT, self._id]))] if halts else []
        return [*self._queued(), *self.release(), *halted, *self._sync()]

    def leave(self) -> list[CanFrame]:
        # else it would be in fault for want of this side's heartbeat
        return [written(self._id, _HEARTBEAT_CONSUMER, 1, 4, 0)] if self._watches else []

    def reset(self) -> list[CanFrame]:
        # one that refused an object is asked again: whoever resets has mended why
        again = self.begin() if self._refused else []
        # an edge: low first
        self._error = ""
        return [*again, self._command(_DISABLE, 0.0), self._command(_RESET, 0.0)]

    def take(self, frame: CanFrame) -> bool:
        if frame.extended:
            return False
        kind, data = frame.identifier - self._id, frame.data
        if kind == STATUS_PDO and len(data) >= 6:
            self._told(*struct.unpack_from("<Hi", data))
        elif kind == MOTION_PDO and len(data) >= 6:
            rate, torque = struct.unpack_from("<ih", data)
            self.sample = replace(self.sample, rate_rad_s=rate * self._radian, torque_nm=1e-3 * torque * self._rated)
        elif kind == _EMERGENCY and len(data) == 8:
            # CiA 301: error code (the drive's 0x603F) and error register; 0 says that it has passed
            code, register = struct.unpack_from("<HB", data)
            self._error = f"error 0x{code:04X}, register 0x{register:02X}" if code else ""
            # a drive that is not set up is not fed either: what it says of that is no news
            self.sample = replace(self.sample, fault=self._refused or self._error)
        elif kind == SDO_ANSWER and len(data) == 8:
            self._answered(data)
        elif kind == HEARTBEAT and data[:1] == bytes([_BOOT_UP]):
            # it started anew, and has nothing left of what was set up, nor perhaps of its zero
            self._outbox = self.begin()
            if self.sample.updates:
                self.sample = replace(self.sample, power=Power.FAULT, fault="started anew")
        else:
            return kind == HEARTBEAT
        return True

    def _told(self, status: int, counts: int) -> None:
        """A statusword and the position that came with it."""
        self._status, self._silent = status, 0
        before, power = self.sample.power, _POWERS.get(state_of(status), Power.OFF)
        if self._refused:
            # one that an earlier host has started, and that is not as this one needs it
            power = Power.REACTING if power.is_powered else Power.FAULT
        elif power is Power.FAULT and before is not Power.FAULT and not self._error:
            # its emergency was lost, or it sends none
            self._outbox.append(asked(self._id, _ERROR_CODE, 0))
        self.sample = replace(
            self.sample,
            updates=self.sample.updates + 1,
            position_rad=counts * self._radian,
            power=power,
            fault=(self._refused or self._error or f"statusword 0x{status:04X}") if power.is_faulty else "",
        )

    def _answered(self, data: bytes) -> None:
        """The next object once the last one was written; what the drive does not have is a fault, but a watch."""
        answer = answer_of(data)
        if answer is None:
            return
        if answer.index == _ERROR_CODE and answer.value:
            self._error = f"error 0x{answer.value:04X}"
            return
        if not self._writes or (answer.index, answer.sub) != self._writes[0][:2]:
            return
        if answer.index == _HEARTBEAT_CONSUMER:
            self._watches = not answer.abort
            caution = f"does not watch this side ({answer.refusal})" if answer.abort else ""
            self.sample = replace(self.sample, caution=caution)
        elif answer.abort:
            self._writes.clear()
            self._refused = answer.refusal
            self.sample = replace(self.sample, power=Power.FAULT, fault=self._refused)
            return
        self._writes.popleft()
        self._silent = 0
        self._outbox.append(self._next_write())

    def _next_write(self) -> CanFrame:
        return written(self._id, *self._writes[0]) if self._writes else CanFrame(NMT, bytes([_START, self._id]))

    def _sync(self) -> list[CanFrame]:
        """The question for the next sample; a node that answers none any more is told again first to start, or set up
        from the beginning: the last object alone may be refused by one that took it and whose answer was lost, as a PDO
        is that is switched on twice.
        """
        self._silent += 1
        again = not self._refused and self._silent % _SILENT_TICKS == 0
        if not again:
            return [CanFrame(SYNC, b"")]
        return [*(self.begin() if self._writes else [self._next_write()]), CanFrame(SYNC, b"")]

    def _queued(self) -> list[CanFrame]:
        queued, self._outbox = self._outbox, []
        return queued

    def _command(self, controlword: int, torque_nm: float) -> CanFrame:
        thousandths = round(1e3 * torque_nm / self._rated)
        held = max(-_LARGEST, min(_LARGEST, thousandths))
        return CanFrame(COMMAND_PDO + self._id, struct.pack("<Hh", controlword, held))

    def _set_up(self) -> list[tuple[int, int, int, int]]:
        """(object, sub-index, bytes, value), in order."""
        return [
            (_HEARTBEAT_CONSUMER, 1, 4, HOST_NODE << 16 | min(self._watchdog_ms, 0xFFFF)),
            *self._pdo(0x1400, 0x1600, COMMAND_PDO, _ON_CHANGE, (0x60400010, 0x60710010)),
            *self._pdo(0x1800, 0x1A00, STATUS_PDO, _EVERY_SYNC, (0x60410010, 0x60640020)),
            *self._pdo(0x1801, 0x1A01, MOTION_PDO, _EVERY_SYNC, (0x606C0020, 0x60770010)),
            (0x6060, 0, 1, _CYCLIC_TORQUE),
        ]

    def _pdo(
        self, parameters: int, mapping: int, base: int, kind: int, objects: tuple[int, ...]
    ) -> list[tuple[int, int, int, int]]:
        """Switch a PDO off, map it, switch it on again."""
        identifier = base + self._id
        return [
            (parameters, 1, 4, _OFF | identifier),
            (mapping, 0, 1, 0),
            *((mapping, place, 4, entry) for place, entry in enumerate(objects, 1)),
            (mapping, 0, 1, len(objects)),
            (parameters, 2, 1, kind),
            (parameters, 1, 4, identifier),
        ]


def state_of(statusword: int) -> int:
    """The bits of a statusword that tell the state: 0x40 switch-on disabled, 0x21 ready, 0x23 switched on, 0x27
    enabled, 0x07 quick stop, 0x0F fault reaction, 0x08 fault, 0x00 not ready.
    """
    return statusword & 0x4F if statusword & 0x4F in (0x40, 0x08, 0x0F, 0x00) else statusword & 0x6F
