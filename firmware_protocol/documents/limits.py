"""How much of a document is read, and which text and numbers may stand in one."""

from __future__ import annotations

import math
import stat
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from firmware_protocol.errors import BadInputError


@dataclass(frozen=True, slots=True)
class DocumentLimits:
    """Largest size in bytes, deepest nesting, most values (aliases count as often as they are used), most digits of an
    integer.

    `finite` False lets the NaN and infinities of a program's own JSON pass.
    """

    size_bytes: int = 4 << 20
    depth: int = 32
    values: int = 400_000
    digits: int = 30
    finite: bool = True


LIMITS = DocumentLimits()


def read_text(path: Path, expected: str, limits: DocumentLimits) -> str:
    """The text of a file in UTF-8, within the limit of size; BadInputError says what is wrong with it."""
    require_regular(path, expected)
    try:
        with path.open("rb") as file:
            data = file.read(limits.size_bytes + 1)
    except FileNotFoundError:
        raise BadInputError(str(path), "no such file", expected) from None
    except IsADirectoryError:
        raise BadInputError(str(path), "is a folder", expected) from None
    except (OSError, ValueError) as error:
        raise BadInputError(
            str(path), f"cannot be read ({getattr(error, 'strerror', None) or error})", expected
        ) from None
    return text_of(data, str(path), expected, limits)


def require_regular(path: Path, expected: str) -> None:
    """BadInputError for a pipe, a device or a socket: reading one may wait, or go on, for ever. What is not there, and
    folders, are for whoever opens it.
    """
    try:
        mode = path.stat().st_mode
    except (OSError, ValueError):
        return
    if not (stat.S_ISREG(mode) or stat.S_ISDIR(mode)):
        kind = "a pipe" if stat.S_ISFIFO(mode) else "a socket" if stat.S_ISSOCK(mode) else "a device"
        raise BadInputError(str(path), f"is {kind}, not a file", expected)


def text_of(data: bytes | str, where: str, expected: str, limits: DocumentLimits) -> str:
    """Bytes as text; BadInputError where they are too many or not UTF-8."""
    if len(data) > limits.size_bytes:
        raise BadInputError(where, f"is longer than {size_words(limits.size_bytes)}", expected)
    if isinstance(data, str):
        return data
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise BadInputError(where, f"line {line} is not UTF-8 text", expected) from None


def size_words(size_bytes: int) -> str:
    """A size as people say it."""
    return f"{size_bytes >> 20} MiB" if size_bytes >= 1 << 20 else f"{size_bytes} bytes"


def text_problem(text: str) -> str | None:
    """Why a string may not stand in a document, None where it may: half a character cannot be printed or written
    again.
    """
    if text.isascii():
        return None
    try:
        text.encode()
    except UnicodeEncodeError:
        return "half a character (a lone surrogate)"
    return None


def printable(value: Any) -> Any:
    """Plain content as any reader takes it: a byte of a path that is no UTF-8 (Python holds it as half a character)
    stands as \\xNN.
    """
    if isinstance(value, str):
        try:
            return value.encode(errors="surrogateescape").decode(errors="backslashreplace")
        except UnicodeEncodeError:
            return value.encode(errors="backslashreplace").decode()
    if isinstance(value, dict):
        return {printable(key): printable(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [printable(one) for one in value]
    return value


def number_problem(number: float, limits: DocumentLimits) -> str | None:
    """Why a number may not stand in a document, None where it may."""
    if isinstance(number, int):
        return f"an integer of more than {limits.digits} digits" if abs(number) >= 10**limits.digits else None
    if math.isfinite(number) or not limits.finite:
        return None
    if math.isnan(number):
        return "nan, which is no number"
    return "a number that is infinite or too large"
