"""All that one host is, in one array of 64-bit words, so that a compiled tick is called with few arrays and a host is
copied at once.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.block_codec import new_counters, new_receivers
from firmware_protocol.schema import MAIL_SIZE, TORQUE_STEP_NM
from gimbal_hil.loop.control import GRAVITY_M_S2
from gimbal_hil.loop.host import layout
from gimbal_hil.loop.host.reception import NEVER
from gimbal_hil.loop.host.states import LinkStatus
from gimbal_hil.loop.host.tick_row import LOG_WORDS

_RECEIVERS = new_receivers()
#: rows and columns of the receivers array, and number of alive counters
RECEIVER_ROWS, RECEIVER_COLUMNS = _RECEIVERS.shape
COUNTER_COUNT = len(new_counters())

# --- integers: G, mail, alive counters, receivers, number of log rows written
# ----------------------------------------------
MAIL_AT = layout.G_SIZE
COUNTERS_AT = MAIL_AT + MAIL_SIZE
RECEIVERS_AT = COUNTERS_AT + COUNTER_COUNT
LOG_COUNT = RECEIVERS_AT + RECEIVER_ROWS * RECEIVER_COLUMNS
# --- floats: H, C
# -------------------------------------------------------------------------------------------------------
H_AT = LOG_COUNT + 1
C_AT = H_AT + layout.H_SIZE
# --- octets: block received, block to send; places in bytes
# ---------------------------------------------------------------
OCTETS_AT = C_AT + layout.C_SIZE
RECEIVED_SIZE = 65536
SENT_AT = RECEIVED_SIZE
# --- log: the newest rows, see `tick_row`
# ---------------------------------------------------------------------------------
LOG_AT = OCTETS_AT + (RECEIVED_SIZE + 256) // 8
ROWS_KEPT = 1024
#: from where to where the octets are, of which the first are the block received
HOST_OCTETS = (OCTETS_AT, LOG_AT)
WORDS = LOG_AT + ROWS_KEPT * LOG_WORDS


class HostMemory:
    """Views of `words`, int64 (WORDS,): copying the words into another host's makes it the same host."""

    def __init__(self, words: NDArray[np.int64]) -> None:
        self.words = words
        #: everything that counts: G, mail, alive counters, receivers
        self.integers = words[:H_AT]
        self.G, self.mail = words[:MAIL_AT], words[MAIL_AT:COUNTERS_AT]
        self.receivers = words[RECEIVERS_AT:LOG_COUNT].reshape(RECEIVER_ROWS, RECEIVER_COLUMNS)
        #: control state and configuration
        self.floats = words[H_AT:OCTETS_AT].view(np.float64)
        self.H, self.C = self.floats[: layout.H_SIZE], self.floats[layout.H_SIZE :]
        self.octets = words[OCTETS_AT:LOG_AT].view(np.uint8)
        self.log = words[LOG_AT:].reshape(ROWS_KEPT, LOG_WORDS)


def new_memory(configuration: NDArray[np.float64]) -> HostMemory:
    """Memory of a host that has heard nothing yet, with the configuration `C`, shape (C_SIZE,)."""
    if configuration.shape != (layout.C_SIZE,):
        raise ValueError(f"a configuration has {layout.C_SIZE} numbers")
    memory = HostMemory(np.zeros(WORDS, dtype=np.int64))
    G = memory.G
    G[layout.FEEDBACK_AGE] = G[layout.BASE_AGE] = G[layout.ATTITUDE_TICKS] = NEVER
    G[layout.MUTED] = 1
    G[layout.LINK_STATUS] = int(LinkStatus.LOST)
    G[layout.SENT_CONTROL] = G[layout.SEGMENT] = G[layout.TICK_SEGMENT] = G[layout.LAST_TICK] = -1
    # a base that was never heard is level
    memory.H[layout.BASE_GRAVITY + 2] = -GRAVITY_M_S2
    for axis in range(layout.AXES):
        memory.H[layout.axis_h(axis) + layout.TORQUE_STEP] = TORQUE_STEP_NM
    memory.receivers[:], memory.C[:] = _RECEIVERS, configuration
    return memory
