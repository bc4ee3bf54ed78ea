"""How much of a CAN bus the messages take, and whether it can carry a rate at all."""

from __future__ import annotations

from firmware_protocol.errors import BadInputError
from firmware_protocol.schema import MESSAGES, PAYLOAD_SIZE, RECORD_SIZE, REFERENCE_RATE_HZ, Direction, Message

#: most of the bus that the messages may take; the rest is for repeats after bus errors and for other nodes
LOAD_LIMIT = 0.6

#: event messages are counted as if one came in so many ticks
EVENT_PERIOD_TICKS = 100


def frame_bits(payload_bytes: int = PAYLOAD_SIZE) -> int:
    """Longest classic frame with an 11-bit identifier, in bit times, interframe space included.

    44 bits of frame (start, identifier, control, CRC sequence, delimiters, acknowledge, end of frame), 8 per byte, 3 of
    interframe space. Stuffing acts on the 34 + 8 n bits from start to CRC sequence; in the worst case the first five
    equal bits and every four after them draw a stuff bit (Davis, Burns, Bril and Lukkien, Real-Time Systems 35, 2007,
    eq. 1).
    """
    stuffed = 34 + 8 * payload_bytes
    return 44 + 8 * payload_bytes + 3 + (stuffed - 1) // 4


def frames_per_second(message: Message, rate_hz: float) -> float:
    """How often a message comes at this tick rate."""
    return rate_hz / (message.period_ticks or EVENT_PERIOD_TICKS)


def bus_load(rate_hz: float = REFERENCE_RATE_HZ, bitrate: int = 1_000_000) -> float:
    """Share of the bus that all messages take in the worst case, both directions together; 1.0 is all of it."""
    return sum(frames_per_second(message, rate_hz) for message in MESSAGES) * frame_bits() / bitrate


def highest_rate_hz(bitrate: int) -> float:
    """Tick rate at which the load reaches `LOAD_LIMIT`."""
    return LOAD_LIMIT / bus_load(1.0, bitrate)


def require_bus_carries(rate_hz: float, bitrate: int, where: str) -> float:
    """Load at this rate, or a BadInputError at `where` when it is over `LOAD_LIMIT`."""
    load = bus_load(rate_hz, bitrate)
    if load > LOAD_LIMIT:
        raise BadInputError(
            where,
            f"{rate_hz:g} Hz loads a bus of {bitrate / 1e3:g} kbit/s to {load:.0%}",
            f"at most {int(highest_rate_hz(bitrate))} Hz ({LOAD_LIMIT:.0%} of the bus)",
        )
    return load


def serial_load(rate_hz: float, baudrate: int) -> float:
    """Share of a full-duplex serial line that its busier direction takes; ten bits per byte, one packet per tick."""
    # per tick: COBS byte, CRC-16, delimiter
    packet_overhead = 4
    directions = []
    for direction in Direction:
        frames = sum(frames_per_second(message, rate_hz) for message in MESSAGES if message.direction is direction)
        directions.append((frames * RECORD_SIZE + rate_hz * packet_overhead) * 10 / baudrate)
    return max(directions)


def require_serial_carries(rate_hz: float, baudrate: int, where: str) -> float:
    """Load of the line at this rate, or a BadInputError at `where` when it is over `LOAD_LIMIT`."""
    load = serial_load(rate_hz, baudrate)
    if load > LOAD_LIMIT:
        highest = int(LOAD_LIMIT / serial_load(1.0, baudrate))
        raise BadInputError(
            where, f"{rate_hz:g} Hz loads a line of {baudrate} bit/s to {load:.0%}", f"at most {highest} Hz"
        )
    return load
