"""Messages of an Arrow IPC stream for rows of one fixed type: the schema that begins it, and a batch of rows.

Every column has a fixed width and no nulls, so of a batch's metadata only the numbers differ from one to the next: a
reader knows a whole batch by comparing it with what would have been written. Bytes are those that Arrow's own C++
library writes. Format: Apache Arrow columnar specification, "Encapsulated message format", Schema.fbs, Message.fbs.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from functools import cache

import flatbuffers
import numpy as np
from numpy.typing import NDArray

from gimbal_hil.data.runs.schema import FRAME_ROW, TICK_ROW, stored_name

CONTINUATION = b"\xff\xff\xff\xff"
#: what a stream says of itself
KINDS = {TICK_ROW: b"ticks", FRAME_ROW: b"frames"}
#: tags of the unions MessageHeader and Type, and versions, in the two .fbs files
_SCHEMA, _RECORD_BATCH, _METADATA_V5 = 1, 3, 4
_INT, _FLOATING_POINT, _FIXED_SIZE_BINARY = 2, 3, 15
_FLOAT_PRECISION = {4: 1, 8: 2}
#: a batch's metadata as far as the number of its buffers: where Message and RecordBatch have their fields, and these
_HEAD = struct.Struct("<4sII xxxx6H ixBHIq xx5H iIIq xxxxI")
#: of a batch without rows, which leaves out what is zero: its lengths
_HEAD_OF_NONE = struct.Struct("<4sII xx5H ixBHI xx5H iIII")
_FIRST_PLACE, _PLACE_OF_NONE = struct.Struct("<I"), 16
_ROWS_AT, _ROWS = 72, struct.Struct("<q")


@cache
def header_bytes(row_type: np.dtype, axes: tuple[str, str]) -> bytes:
    """The schema message that starts a stream of an antenna with these axes."""
    builder = flatbuffers.Builder(4096)
    names = row_type.names or ()
    columns = _places(builder, [_column(builder, stored_name(n, axes), row_type[n], n == "payload") for n in names])
    said = []
    for key, value in ((b"gimbal_hil", KINDS[row_type]), (b"version", b"1")):
        told = builder.CreateString(key), builder.CreateString(value)
        builder.StartObject(2)
        for slot in (1, 0):
            builder.PrependUOffsetTRelativeSlot(slot, told[slot], 0)
        said.append(builder.EndObject())
    said_at = _places(builder, said)
    builder.StartObject(4)
    builder.PrependUOffsetTRelativeSlot(2, said_at, 0)
    builder.PrependUOffsetTRelativeSlot(1, columns, 0)
    schema = builder.EndObject()
    builder.StartObject(5)
    builder.PrependUOffsetTRelativeSlot(2, schema, 0)
    builder.PrependInt16Slot(0, _METADATA_V5, 0)
    builder.PrependUint8Slot(1, _SCHEMA, 0)
    builder.Finish(builder.EndObject())
    content = bytes(builder.Output())
    content += bytes(-len(content) % 8)
    return CONTINUATION + struct.pack("<I", len(content)) + content


def batch_bytes(rows: NDArray[np.void]) -> bytes:
    """A batch of rows."""
    columns = [np.ascontiguousarray(rows[name]).tobytes() for name in rows.dtype.names or ()]
    return _metadata(rows.dtype, len(rows)) + b"".join(column + bytes(-len(column) % 8) for column in columns)


def rows_of_batch(data: bytes, at: int, row_type: np.dtype) -> tuple[NDArray[np.void], int] | None:
    """Rows of the batch at byte `at` and the byte after it; None where no whole one begins."""
    if data[at : at + 4] != CONTINUATION or len(data) < at + _ROWS_AT + _ROWS.size:
        return None
    none = _FIRST_PLACE.unpack_from(data, at + 8)[0] == _PLACE_OF_NONE
    count = 0 if none else _ROWS.unpack_from(data, at + _ROWS_AT)[0]
    if not 0 <= count * row_type.itemsize <= len(data) - at:
        return None
    metadata, columns = _metadata(row_type, count), _columns(row_type, count)
    body = at + len(metadata)
    end = body + _padded(columns)
    if data[at:body] != metadata or len(data) < end:
        return None
    rows = np.empty(count, row_type)
    for name, (start, _) in zip(row_type.names or (), columns, strict=True):
        rows[name] = np.frombuffer(data, row_type[name], count, body + start)
    return rows, end


def _metadata(row_type: np.dtype, count: int) -> bytes:
    """What stands before the columns of a batch of `count` rows."""
    columns = _columns(row_type, count)
    width = len(columns)
    if count:
        head = _HEAD.pack(
            CONTINUATION, 88 + 48 * width, 20,
            12, 22, 6, 5, 8, 12, 12, _RECORD_BATCH, _METADATA_V5, 24, _padded(columns),
            10, 24, 12, 4, 8, 10, 28 + 32 * width, 16, count, 2 * width,
        )  # fmt: skip
    else:
        head = _HEAD_OF_NONE.pack(
            CONTINUATION, 64 + 48 * width, _PLACE_OF_NONE,
            10, 14, 6, 5, 8, 10, _RECORD_BATCH, _METADATA_V5, 16,
            10, 12, 0, 4, 8, 10, 16 + 32 * width, 4, 2 * width,
        )  # fmt: skip
    # a column has two buffers: which of its rows are null, which is empty, and the values
    buffers = struct.pack(f"<{4 * width}q", *(number for at, length in columns for number in (at, 0, at, length)))
    nodes = struct.pack(f"<xxxxI{2 * width}q", width, *([count, 0] * width))
    return head + buffers + nodes


def _columns(row_type: np.dtype, count: int) -> list[tuple[int, int]]:
    """First byte, counted from the first column's, and length of each; each begins at a multiple of eight."""
    found, at = [], 0
    for name in row_type.names or ():
        length = row_type[name].itemsize * count
        found.append((at, length))
        at += length + -length % 8
    return found


def _padded(columns: Sequence[tuple[int, int]]) -> int:
    """Bytes of all columns."""
    return sum(length + -length % 8 for _, length in columns)


def _column(builder: flatbuffers.Builder, name: str, stored: np.dtype, octets: bool) -> int:
    """One field of the schema."""
    if octets:
        kind = _FIXED_SIZE_BINARY
        builder.StartObject(1)
        builder.PrependInt32Slot(0, stored.itemsize, 0)
    elif stored.kind == "f":
        kind = _FLOATING_POINT
        builder.StartObject(1)
        builder.PrependInt16Slot(0, _FLOAT_PRECISION[stored.itemsize], 0)
    else:
        kind = _INT
        builder.StartObject(2)
        builder.PrependInt32Slot(0, 8 * stored.itemsize, 0)
        builder.PrependBoolSlot(1, stored.kind == "i", False)
    type_at = builder.EndObject()
    name_at, children = builder.CreateString(name), _places(builder, ())
    builder.StartObject(7)
    for slot, place in ((5, children), (3, type_at), (0, name_at)):
        builder.PrependUOffsetTRelativeSlot(slot, place, 0)
    builder.PrependUint8Slot(2, kind, 0)
    builder.PrependBoolSlot(1, True, False)
    return int(builder.EndObject())


def _places(builder: flatbuffers.Builder, found: Sequence[int]) -> int:
    builder.StartVector(4, len(found), 4)
    for one in reversed(found):
        builder.PrependUOffsetTRelative(one)
    return int(builder.EndVector())
