"""One host tick from block to block: decode, decide, encode, leave a row; the one compiled call per tick of the frame
path.
"""

from __future__ import annotations

import numpy as np

from firmware_protocol.block_codec import age_receivers, clear_fresh, decode_block, encode_mail, reset_receivers
from firmware_protocol.compiling import compiled, entry_point
from firmware_protocol.mail import (
    DEADMAN_CONFIG,
    DEADMAN_CONFIG_MESSAGE,
    DRIVE_CONTROL,
    DRIVE_CONTROL_MESSAGE,
    SET_POINT_MESSAGE,
)
from firmware_protocol.schema import RECORD_SIZE, Direction
from gimbal_hil.loop.host.core import host_tick
from gimbal_hil.loop.host.layout import LINK_STATUS
from gimbal_hil.loop.host.memory import (
    C_AT,
    COUNTERS_AT,
    H_AT,
    LOG_AT,
    LOG_COUNT,
    MAIL_AT,
    OCTETS_AT,
    RECEIVED_SIZE,
    RECEIVER_COLUMNS,
    RECEIVER_ROWS,
    RECEIVERS_AT,
    ROWS_KEPT,
    SENT_AT,
)
from gimbal_hil.loop.host.states import LinkStatus, number
from gimbal_hil.loop.host.tick_row import LOG_WORDS, write_row

_LOST = number(LinkStatus.LOST)
_TO_HOST = int(Direction.DEVICE_TO_HOST)


@compiled
def encode_host_mail(mail: np.ndarray, counters: np.ndarray, out: np.ndarray, position: int) -> int:
    """Encode what the host sends this tick: requests and configuration first, the set-point last; answers the end
    position.
    """
    if mail[DRIVE_CONTROL] > 0:
        position = encode_mail(mail, DRIVE_CONTROL_MESSAGE, counters, out, position)
    if mail[DEADMAN_CONFIG] > 0:
        position = encode_mail(mail, DEADMAN_CONFIG_MESSAGE, counters, out, position)
    return encode_mail(mail, SET_POINT_MESSAGE, counters, out, position)


@entry_point
def host_frame_tick(words: np.ndarray, plan: np.ndarray, received: int, tick: int, time_ns: int) -> int:
    """One tick on the memory of a host: `received` bytes at the start of its octets; answers how many stand at SENT_AT
    to be sent.

    The row of this tick goes into the memory's log. One array for nearly all, because each costs a tenth of a
    microsecond at every call.
    """
    return host_block_tick(words, plan, received, tick, time_ns)


@compiled
def host_block_tick(words: np.ndarray, plan: np.ndarray, received: int, tick: int, time_ns: int) -> int:
    """`host_frame_tick` for those that are compiled themselves."""
    # here and not in the entry point, because there every view would be counted, a tenth of a microsecond in all
    G, mail, counters = words[:MAIL_AT], words[MAIL_AT:COUNTERS_AT], words[COUNTERS_AT:RECEIVERS_AT]
    receivers = words[RECEIVERS_AT:LOG_COUNT].reshape(RECEIVER_ROWS, RECEIVER_COLUMNS)
    H, C = words[H_AT:C_AT].view(np.float64), words[C_AT:OCTETS_AT].view(np.float64)
    octets = words[OCTETS_AT:LOG_AT].view(np.uint8)
    age_receivers(receivers, _TO_HOST)
    clear_fresh(mail, _TO_HOST)
    good = decode_block(octets[:RECEIVED_SIZE], received, mail, receivers, _TO_HOST)
    host_tick(mail, H, G, C, plan, tick)
    if G[LINK_STATUS] == _LOST:
        reset_receivers(receivers)
    row = words[LOG_AT + (words[LOG_COUNT] % ROWS_KEPT) * LOG_WORDS :][:LOG_WORDS]
    words[LOG_COUNT] += 1
    write_row(row, row.view(np.float64), H, G, tick, time_ns, received // RECORD_SIZE - good)
    return encode_host_mail(mail, counters, octets, SENT_AT) - SENT_AT
