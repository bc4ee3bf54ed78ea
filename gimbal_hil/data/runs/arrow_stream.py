"""Log rows as an Arrow IPC stream: written one whole message at a time, read back from whatever bytes are left.

Any Arrow reader opens an intact stream. `read_rows` also reads one that ends anywhere, is still being written, or has
damaged bytes in it: it keeps every batch that is whole and says where it had to skip. Format: Apache Arrow columnar
specification, "IPC streaming format".
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.runs.arrow_messages import CONTINUATION, KINDS, header_bytes, rows_of_batch

END_OF_STREAM = b"\xff\xff\xff\xff\0\0\0\0"
#: so much of a growing stream is read at once
_PIECE_BYTES = 1 << 24


@dataclass(frozen=True)
class StreamContent:
    """Rows of every whole batch, the row count after each batch, and what could not be read.

    `skipped` holds (first byte, byte past the last, rows read before) of every stretch without a whole batch.
    """

    rows: NDArray[np.void]
    batch_ends: tuple[int, ...]
    skipped: tuple[tuple[int, int, int], ...]
    ended: bool


def read_rows(path: Path, row_type: np.dtype, axes: tuple[str, str]) -> StreamContent:
    """Every row that is whole in the file; raises BadInputError when the file is not a log of this kind."""
    expected = f"a log stream of {KINDS[row_type].decode()} that gimbal-hil wrote"
    try:
        data = path.read_bytes()  # not mapped: a writer that meets a full disk cuts its file
    except OSError as error:
        raise BadInputError(str(path), error.strerror or "cannot be read", expected) from error
    header = header_bytes(row_type, axes)
    start = data[: len(header)]
    if start != header[: len(start)]:
        raise BadInputError(str(path), "is not such a log, or its header is damaged", expected)
    return _read_batches(data, len(header), row_type)


def _read_batches(data: bytes, at: int, row_type: np.dtype) -> StreamContent:
    pieces: list[NDArray[np.void]] = []
    ends: list[int] = []
    skipped: list[tuple[int, int, int]] = []
    total, ended = 0, False
    while at < len(data):
        if data[at : at + 8] == END_OF_STREAM:
            ended = True
            at += 8
            continue
        found = rows_of_batch(data, at, row_type)
        if found is None:
            following = _next_batch(data, at, row_type)
            skipped.append((at, following, total))
            at = following
            continue
        rows, at = found
        pieces.append(rows)
        total += len(rows)
        ends.append(total)
    rows = np.concatenate(pieces) if pieces else np.zeros(0, row_type)
    return StreamContent(rows, tuple(ends), tuple(skipped), ended)


class GrowingStream:
    """A stream that a writer appends to: each call of `new_batches` reads on where the last one ended.

    Raises BadInputError when the file is not a log of this kind.
    """

    def __init__(self, path: Path, row_type: np.dtype, axes: tuple[str, str]) -> None:
        self.row_type = row_type
        self._path = path
        self._header = header_bytes(row_type, axes)
        self._at = 0

    def new_batches(self) -> Iterator[NDArray[np.void]]:
        """Rows of every whole batch that is new; a batch that is half written, or does not read, ends the look."""
        expected = f"a log stream of {KINDS[self.row_type].decode()} that gimbal-hil wrote"
        wanted = least = _PIECE_BYTES + len(self._header)
        while True:
            try:
                with self._path.open("rb") as file:
                    file.seek(self._at)
                    data = file.read(wanted)
            except OSError as error:
                raise BadInputError(str(self._path), error.strerror or "cannot be read", expected) from error
            at = 0
            if self._at == 0:
                if data[: len(self._header)] != self._header[: len(data)]:
                    raise BadInputError(str(self._path), "is not such a log, or its header is damaged", expected)
                if len(data) < len(self._header):
                    return
                at = len(self._header)
            while (found := rows_of_batch(data, at, self.row_type)) is not None:
                rows, at = found
                yield rows
            self._at += at
            if len(data) < wanted:
                return
            # the piece ends inside a batch: read on from that one's start, with more room where it did not fit at all
            wanted = least if at else 2 * wanted


def _next_batch(data: bytes, at: int, row_type: np.dtype) -> int:
    """Byte at which the next readable batch starts after damage, or the end of the data."""
    while True:
        at = data.find(CONTINUATION, at + 1)
        if at < 0:
            return len(data)
        if at % 8 == 0 and (
            (data[at : at + 8] == END_OF_STREAM and at + 8 == len(data)) or rows_of_batch(data, at, row_type)
        ):
            return at
