"""Memory read by name: one definition gives layout, names, types and documentation of what compiled code works on.

    class Joint(MemoryRecord):
        #: joint angle, rad
        position: float

    class Antenna(MemoryRecord):
        joints: Annotated[Sequence[Joint], 2]

    ANTENNA = layout_of(Antenna)

`words.view(ANTENNA)[0]` is such a record, in Python and in compiled code alike: `antenna.joints[0].position`. It is a
view, so writing to it writes to the words. Make it once, where the words come in, and hand it on: a view made anew in
an inner function costs about ten nanoseconds there (decision record 0063).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any, get_args, get_origin, get_type_hints

import numpy as np

__all__ = ["Annotated", "MemoryRecord", "Sequence", "layout_of"]

_NUMBERS: dict[object, type[np.generic]] = {int: np.int64, float: np.float64}


class MemoryRecord:
    """Base of a definition: fields in order, each `int` (int64), `float` (float64), another definition, or several of
    one of them as `Annotated[Sequence[...], count]`.
    """


def layout_of(definition: type[MemoryRecord]) -> np.dtype[Any]:
    """The memory layout of a definition, eight bytes a number and nothing between them."""
    return np.dtype((np.record, _fields(definition)))


def _fields(definition: type[MemoryRecord]) -> list[tuple[Any, ...]]:
    hints = get_type_hints(definition, include_extras=True)
    return [(name, *_field(hint)) for name, hint in hints.items()]


def _field(hint: Any) -> tuple[Any, ...]:
    if get_origin(hint) is Annotated:
        sequence, count = get_args(hint)
        (element,) = get_args(sequence)
        return (*_field(element), (count,))
    if hint in _NUMBERS:
        return (_NUMBERS[hint],)
    return (layout_of(hint),)
