"""How the wire does, second by second: the deadman's margin, how full the bus is, frames that were dropped."""

from __future__ import annotations

from dataclasses import dataclass

from firmware_protocol import schema
from firmware_protocol.bus_load import frame_bits
from firmware_protocol.json_object import Json
from gimbal_hil.realtime.telemetry.records import Exchange

_STATUS = schema.BY_NAME["drive_status"]
_STATUS_ID = _STATUS.can_id.to_bytes(2, "little")
_MARGIN_BITS = next(field.bits for field in _STATUS.fields if field.name == "deadman_margin")
_MARGIN_SHIFT = _STATUS.start("deadman_margin")
#: COBS byte, CRC-16 and delimiter of a tick's packet, and bits of a byte on a serial line
_PACKET_OVERHEAD, _SERIAL_BITS = 4, 10


@dataclass(frozen=True, slots=True)
class Wire:
    """What carries the frames: bit/s, None where nothing has a rate (a socket, this process)."""

    bits_per_s: float | None = None
    is_serial: bool = False
    #: ticks without a set-point after which the drive reacts
    deadman_window: int | None = None


@dataclass(slots=True)
class _Second:
    margin: int | None = None
    rejected: int = 0
    sent: int = 0
    received: int = 0
    ticks: int = 0


class WireWatch:
    """Fed with every exchange; tells the last whole second and the one that runs."""

    def __init__(self, period_ns: int, wire: Wire) -> None:
        self.wire = wire
        self._ticks_per_s = max(1, round(1e9 / period_ns))
        self._last, self._now = _Second(), _Second()

    def take(self, exchange: Exchange, rejected: int) -> None:
        """One tick."""
        now, received = self._now, exchange.received
        for at in range(0, len(received), schema.RECORD_SIZE):
            if received[at : at + 2] == _STATUS_ID:
                word = int.from_bytes(received[at + 2 : at + schema.RECORD_SIZE], "little")
                margin = (word >> _MARGIN_SHIFT) & ((1 << _MARGIN_BITS) - 1)
                now.margin = margin if now.margin is None else min(now.margin, margin)
        now.rejected += rejected
        now.received += len(received)
        now.sent += len(exchange.sent)
        now.ticks += 1
        if now.ticks >= self._ticks_per_s:
            self._last, self._now = now, _Second()

    def state(self) -> Json:
        """For people: least margin and dropped frames of the last second or two, share of the bus in the last one."""
        margins = [second.margin for second in (self._last, self._now) if second.margin is not None]
        return {
            "deadman_margin_ticks": min(margins, default=None),
            "deadman_window_ticks": self.wire.deadman_window,
            "rejected_lately": self._last.rejected + self._now.rejected,
            "bus_load": self._load(),
        }

    def _load(self) -> float | None:
        second, rate = self._last, self.wire.bits_per_s
        if rate is None or second.ticks == 0:
            return None
        if self.wire.is_serial:
            # each direction has a line of its own
            octets = max(second.sent, second.received) + _PACKET_OVERHEAD * second.ticks
            return octets * _SERIAL_BITS / rate
        frames = (second.sent + second.received) // schema.RECORD_SIZE
        return frames * frame_bits() / rate
