"""Bytes of a text file as text: packed or not, in whichever encoding spreadsheets, shells and loggers leave it."""

from __future__ import annotations

import codecs
import zlib
from pathlib import Path

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.tables.raw import GUESSED, IN_UTF_8

GZIP_START = b"\x1f\x8b"
#: a packed file that unpacks to more is none that was logged
_LARGEST = 1 << 30
_MARKS = (
    (codecs.BOM_UTF8, "utf-8-sig"),
    # before its half
    (codecs.BOM_UTF32_LE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)
#: share of zeros at every second byte from which on they are halves of UTF-16
_HALVES = 0.7
_LOOKED_AT = 4096
_CONTROLS = frozenset(map(chr, range(32))) - set("\t\n\r\f\v\x1a\x1b\0")
#: what nobody sees in a name: a second byte order mark, a blank without width, a joiner
_UNSEEN = "\ufeff\u200b\u2060"
_TAR = b"ustar"
_EXPECTED = "a table of text, a Parquet or npz file with one row per sample"


def decoded(path: Path, data: bytes) -> tuple[str, list[str]]:
    """The text with line ends of one kind, and what a reader should know. BadInputError for what is no text."""
    notes: list[str] = []
    if data.startswith(GZIP_START):
        data = _unpacked(path, data, notes)
    if data[257:262] == _TAR:
        raise BadInputError(str(path), "is a tar archive", "the file that is in it (tar -xf FILE)")
    text = _text(path, data, notes)
    if any(mark in text for mark in _UNSEEN):
        text = text.translate(dict.fromkeys(map(ord, _UNSEEN)))
    if _CONTROLS.intersection(text[:_LOOKED_AT]):
        raise BadInputError(str(path), "is no text: it has control characters in it", _EXPECTED)
    # a file that was given its size beforehand ends in zeros
    text = text.rstrip("\0\x1a")
    return text.replace("\r\r\n", "\n").replace("\r\n", "\n").replace("\r", "\n"), notes


def _unpacked(path: Path, data: bytes, notes: list[str]) -> bytes:
    parts: list[bytes] = []
    left = _LARGEST
    while data.startswith(GZIP_START):
        member = zlib.decompressobj(wbits=31)
        try:
            part = member.decompress(data, left)
        except zlib.error as error:
            raise BadInputError(str(path), f"is no whole gzip file: {error}", _EXPECTED) from error
        parts.append(part)
        left -= len(part)
        if left <= 0:
            raise BadInputError(str(path), f"unpacks to more than {_LARGEST >> 20} MiB", "a shorter log")
        if not member.eof:
            notes.append("the gzip file is cut: what could be unpacked was read")
            break
        data = member.unused_data
    return b"".join(parts)


def _text(path: Path, data: bytes, notes: list[str]) -> str:
    encoding = next((name for mark, name in _MARKS if data.startswith(mark)), _unmarked(data))
    try:
        # half a unit at the end of UTF-16 is what a cut leaves
        return (data[: len(data) // 2 * 2] if encoding.startswith("utf-16") else data).decode(encoding)
    except UnicodeDecodeError:
        pass
    try:
        text = data.decode("cp1252")
    except UnicodeDecodeError as error:
        problem = f"is no text in UTF-8, UTF-16 or cp1252, from byte {error.start} on"
        raise BadInputError(str(path), problem, f"{_EXPECTED}; of text, {IN_UTF_8}") from error
    notes.append(f"is no UTF-8 and {GUESSED}, the usual encoding of Windows")
    return text


def _unmarked(data: bytes) -> str:
    start = data[: _LOOKED_AT - 1]
    if len(start) > 3:
        if start[1::2].count(0) > _HALVES * len(start[1::2]) and not start[::2].count(0):
            return "utf-16-le"
        if start[::2].count(0) > _HALVES * len(start[::2]) and not start[1::2].count(0):
            return "utf-16-be"
    return "utf-8"
