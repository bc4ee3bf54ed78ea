"""The one place where blocks of `bytes` (links, recorder) meet the arrays that compiled code reads and writes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.schema import RECORD_SIZE

#: frames that one tick can carry at most; a longer block is taken in parts
FRAMES_PER_BUFFER = 512


class BlockBuffer:
    """A fixed buffer of `FRAMES_PER_BUFFER` records: nothing is allocated per tick but the `bytes` handed out."""

    def __init__(self) -> None:
        self.octets: NDArray[np.uint8] = np.zeros(FRAMES_PER_BUFFER * RECORD_SIZE, dtype=np.uint8)
        self._view = self.octets.data

    def fill(self, block: bytes) -> int:
        """Copy a block in and answer its length in bytes; what is beyond the buffer is left out: see `parts`."""
        size = min(len(block), len(self._view))
        self._view[:size] = block if size == len(block) else block[:size]
        return size

    def take(self, size: int) -> bytes:
        """The first `size` bytes as a block."""
        return bytes(self._view[:size])


def parts(block: bytes) -> list[bytes]:
    """A block cut into pieces that each fit a `BlockBuffer`, at record bounds."""
    size = FRAMES_PER_BUFFER * RECORD_SIZE
    return [block] if len(block) <= size else [block[at : at + size] for at in range(0, len(block), size)]
