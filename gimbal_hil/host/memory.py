"""The arrays behind one host, laid end to end in three blocks so that a compiled tick is called with few of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.block_codec import new_counters, new_receivers
from firmware_protocol.schema import MAIL_SIZE
from gimbal_hil.control.layout import CONTROL_PARAMETERS
from gimbal_hil.host import layout
from gimbal_hil.host.reception import NEVER
from gimbal_hil.host.states import LinkStatus

_RECEIVERS = new_receivers()
#: rows and columns of the receivers array, and number of alive counters
RECEIVER_ROWS, RECEIVER_COLUMNS = _RECEIVERS.shape
COUNTER_COUNT = len(new_counters())

# --- integers: G, mail, alive counters, receivers -----------------------------------------------------------------------
MAIL_AT = layout.G_SIZE
COUNTERS_AT = MAIL_AT + MAIL_SIZE
RECEIVERS_AT = COUNTERS_AT + COUNTER_COUNT
INTEGERS_SIZE = RECEIVERS_AT + RECEIVER_ROWS * RECEIVER_COLUMNS
# --- floats: H, C -------------------------------------------------------------------------------------------------------
C_AT = layout.H_SIZE
FLOATS_SIZE = C_AT + layout.C_SIZE
# --- octets: block received, block to send ------------------------------------------------------------------------------
RECEIVED_SIZE = 65536
SENT_AT = RECEIVED_SIZE
OCTETS_SIZE = RECEIVED_SIZE + 256


@dataclass(frozen=True, slots=True, eq=False)
class HostMemory:
    """All that a host is: copying the arrays copies the host."""

    octets: NDArray[np.uint8]
    integers: NDArray[np.int64]
    floats: NDArray[np.float64]

    @property
    def G(self) -> NDArray[np.int64]:
        """Host state, a view."""
        return self.integers[:MAIL_AT]

    @property
    def mail(self) -> NDArray[np.int64]:
        """Mail, a view."""
        return self.integers[MAIL_AT:COUNTERS_AT]

    @property
    def receivers(self) -> NDArray[np.int64]:
        """Receivers of the codec, a view of shape (messages + 1, columns)."""
        return self.integers[RECEIVERS_AT:].reshape(RECEIVER_ROWS, RECEIVER_COLUMNS)

    @property
    def H(self) -> NDArray[np.float64]:
        """Control state, a view."""
        return self.floats[:C_AT]

    @property
    def C(self) -> NDArray[np.float64]:
        """Configuration, a view."""
        return self.floats[C_AT:]


def new_memory(configuration: NDArray[np.float64]) -> HostMemory:
    """Memory of a host that has heard nothing yet, with the configuration `C`, shape (C_SIZE,)."""
    if configuration.shape != (layout.C_SIZE,) or layout.AXIS_C_SIZE <= CONTROL_PARAMETERS:
        raise ValueError(f"a configuration has {layout.C_SIZE} numbers")
    integers = np.zeros(INTEGERS_SIZE, dtype=np.int64)
    integers[layout.FEEDBACK_AGE] = integers[layout.BASE_AGE] = NEVER
    integers[layout.LINK_STATUS] = int(LinkStatus.LOST)
    integers[layout.SENT_CONTROL] = integers[layout.SEGMENT] = integers[layout.TICK_SEGMENT] = -1
    integers[RECEIVERS_AT:] = _RECEIVERS.ravel()
    floats = np.concatenate([np.zeros(layout.H_SIZE), configuration])
    return HostMemory(np.zeros(OCTETS_SIZE, dtype=np.uint8), integers, floats)
