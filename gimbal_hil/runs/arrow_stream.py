"""Log rows as an Arrow IPC stream: written one whole message at a time, read back from whatever bytes are left.

Any Arrow reader opens an intact stream. `read_rows` also reads one that ends anywhere, is still being written, or has
damaged bytes in it: it keeps every batch that is whole and says where it had to skip. Format: Apache Arrow columnar
specification, "Encapsulated message format" and "IPC streaming format".
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.errors import BadInputError
from gimbal_hil.runs.schema import FRAME_ROW, TICK_ROW, stored_name

END_OF_STREAM = b"\xff\xff\xff\xff\0\0\0\0"
_CONTINUATION = b"\xff\xff\xff\xff"
_LONGEST_METADATA = 1 << 20
#: so much of a growing stream is read at once
_PIECE_BYTES = 1 << 24
_KINDS = {TICK_ROW: b"ticks", FRAME_ROW: b"frames"}


@dataclass(frozen=True)
class StreamContent:
    """Rows of every whole batch, the row count after each batch, and what could not be read.

    `skipped` holds (first byte, byte past the last, rows read before) of every stretch without a whole batch.
    """

    rows: NDArray[np.void]
    batch_ends: tuple[int, ...]
    skipped: tuple[tuple[int, int, int], ...]
    ended: bool


def header_bytes(row_type: np.dtype, axes: tuple[str, str]) -> bytes:
    """The schema message that starts a stream of an antenna with these axes."""
    return bytes(_schema(row_type, axes).serialize())


def batch_bytes(rows: NDArray[np.void], axes: tuple[str, str]) -> bytes:
    """One record batch message."""
    import pyarrow as pa

    schema, arrays = _schema(rows.dtype, axes), []
    for name, field in zip(rows.dtype.names or (), schema, strict=True):
        # the bytes as they are: `pa.array` would import pandas where there is one, in the middle of a recording
        column = np.ascontiguousarray(rows[name])
        arrays.append(pa.Array.from_buffers(field.type, len(rows), [None, pa.py_buffer(column)], null_count=0))
    return bytes(pa.record_batch(arrays, schema=schema).serialize())


def read_rows(path: Path, row_type: np.dtype, axes: tuple[str, str]) -> StreamContent:
    """Every row that is whole in the file; raises BadInputError when the file is not a log of this kind."""
    expected = f"a log stream of {_KINDS[row_type].decode()} that gimbal-hil wrote"
    try:
        data = path.read_bytes()  # not mapped: a writer that meets a full disk cuts its file
    except OSError as error:
        raise BadInputError(str(path), error.strerror or "cannot be read", expected) from error
    header = header_bytes(row_type, axes)
    start = data[: len(header)]
    if start != header[: len(start)]:
        raise BadInputError(str(path), "is not such a log, or its header is damaged", expected)
    return _read_batches(data, len(header), row_type, axes)


def _read_batches(data: bytes, at: int, row_type: np.dtype, axes: tuple[str, str]) -> StreamContent:
    import pyarrow as pa

    buffer = pa.py_buffer(data)
    pieces: list[NDArray[np.void]] = []
    ends: list[int] = []
    skipped: list[tuple[int, int, int]] = []
    total, ended = 0, False
    while at < len(data):
        if data[at : at + 8] == END_OF_STREAM:
            ended = True
            at += 8
            continue
        found = _batch_at(buffer, data, at, row_type, axes)
        if found is None:
            following = _next_batch(buffer, data, at, row_type, axes)
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
        self._axes = axes
        self._header = header_bytes(row_type, axes)
        self._at = 0

    def new_batches(self) -> Iterator[NDArray[np.void]]:
        """Rows of every whole batch that is new; a batch that is half written, or does not read, ends the look."""
        import pyarrow as pa

        expected = f"a log stream of {_KINDS[self.row_type].decode()} that gimbal-hil wrote"
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
            buffer = pa.py_buffer(data)
            while (found := _batch_at(buffer, data, at, self.row_type, self._axes)) is not None:
                rows, at = found
                yield rows
            self._at += at
            if len(data) < wanted:
                return
            # the piece ends inside a batch: read on from that one's start, with more room where it did not fit at all
            wanted = least if at else 2 * wanted


def _batch_at(
    buffer: Any, data: bytes, at: int, row_type: np.dtype, axes: tuple[str, str]
) -> tuple[NDArray[np.void], int] | None:
    """Rows of the batch message at byte `at` and the byte after it; None when there is no whole, valid one."""
    import pyarrow as pa

    head = data[at : at + 8]
    if len(head) < 8 or head[:4] != _CONTINUATION:
        return None
    length = struct.unpack("<i", head[4:])[0]
    if not 0 < length <= _LONGEST_METADATA or length % 8:
        return None
    try:
        message = pa.ipc.read_message(pa.BufferReader(buffer.slice(at)))
        if message.type != "record batch":
            return None
        batch = pa.ipc.read_record_batch(message, _schema(row_type, axes))
        batch.validate(full=True)
    except (pa.ArrowException, OSError, ValueError):
        return None
    rows = np.zeros(batch.num_rows, row_type)
    for place, name in enumerate(row_type.names or ()):
        stored = batch.column(place)
        if stored.offset or stored.null_count or len(stored) != len(rows):
            return None
        rows[name] = np.frombuffer(stored.buffers()[1], row_type[name], len(rows)) if len(rows) else 0
    return rows, at + 8 + length + message.body.size


def _next_batch(buffer: Any, data: bytes, at: int, row_type: np.dtype, axes: tuple[str, str]) -> int:
    """Byte at which the next readable batch starts after damage, or the end of the data."""
    while True:
        at = data.find(_CONTINUATION, at + 1)
        if at < 0:
            return len(data)
        if at % 8 == 0 and (
            (data[at : at + 8] == END_OF_STREAM and at + 8 == len(data)) or _batch_at(buffer, data, at, row_type, axes)
        ):
            return at


@cache
def _schema(row_type: np.dtype, axes: tuple[str, str]) -> Any:
    import pyarrow as pa

    fields = [
        (stored_name(name, axes), pa.binary(8) if name == "payload" else pa.from_numpy_dtype(row_type[name]))
        for name in row_type.names or ()
    ]
    return pa.schema(fields, metadata={b"gimbal_hil": _KINDS[row_type], b"version": b"1"})
