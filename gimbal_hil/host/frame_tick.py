"""One host tick from block to block: decode, decide, encode, leave a row; the one compiled call per tick of the frame path."""

from __future__ import annotations

import numpy as np

from firmware_protocol.block_codec import age_receivers, clear_fresh, decode_block, encode_mail
from firmware_protocol.compiling import compiled, entry_point
from firmware_protocol.mail import (
    DEADMAN_CONFIG,
    DEADMAN_CONFIG_MESSAGE,
    DRIVE_CONTROL,
    DRIVE_CONTROL_MESSAGE,
    SET_POINT_MESSAGE,
)
from firmware_protocol.schema import RECORD_SIZE, Direction
from gimbal_hil.host.core import host_tick
from gimbal_hil.host.memory import C_AT, COUNTERS_AT, MAIL_AT, RECEIVED_SIZE, RECEIVER_COLUMNS, RECEIVER_ROWS, RECEIVERS_AT, SENT_AT
from gimbal_hil.host.tick_row import write_row

_TO_HOST = int(Direction.DEVICE_TO_HOST)


@compiled
def encode_host_mail(mail: np.ndarray, counters: np.ndarray, out: np.ndarray, position: int) -> int:
    """Encode what the host sends this tick: requests and configuration first, the set-point last; answers the end position."""
    if mail[DRIVE_CONTROL] > 0:
        position = encode_mail(mail, DRIVE_CONTROL_MESSAGE, counters, out, position)
    if mail[DEADMAN_CONFIG] > 0:
        position = encode_mail(mail, DEADMAN_CONFIG_MESSAGE, counters, out, position)
    return encode_mail(mail, SET_POINT_MESSAGE, counters, out, position)


@entry_point
def host_frame_tick(
    octets: np.ndarray,
    integers: np.ndarray,
    floats: np.ndarray,
    plan: np.ndarray,
    rows: np.ndarray,
    place: int,
    received: int,
    tick: int,
    time_ns: int,
    skipped: int,
) -> int:
    """One tick on a `HostMemory`'s arrays: `received` bytes at the start of `octets`; answers how many stand at SENT_AT to be sent.

    `rows` int64 (n, LOG_WORDS) gets this tick's row at `place`.
    """
    G, mail, counters = integers[:MAIL_AT], integers[MAIL_AT:COUNTERS_AT], integers[COUNTERS_AT:RECEIVERS_AT]
    receivers = integers[RECEIVERS_AT:].reshape(RECEIVER_ROWS, RECEIVER_COLUMNS)
    H, C = floats[:C_AT], floats[C_AT:]
    age_receivers(receivers, _TO_HOST)
    clear_fresh(mail, _TO_HOST)
    good = decode_block(octets[:RECEIVED_SIZE], received, mail, receivers, _TO_HOST)
    host_tick(mail, H, G, C, plan, tick)
    write_row(rows[place], rows.view(np.float64)[place], H, G, tick, time_ns, skipped, received // RECORD_SIZE - good)
    return encode_host_mail(mail, counters, octets, SENT_AT) - SENT_AT
