"""What a program's numbers must be before the host core may index and compute with them; looked at by whole columns, to
be quick.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.documents import LARGEST_NUMBER
from firmware_protocol.errors import BadInputError
from gimbal_hil.loop.control import Mode
from gimbal_hil.loop.host import layout
from gimbal_hil.loop.host.states import EndKind, ReferenceOrigin, Shape

PARAMETER_COUNT = {
    Shape.HOLD: 1,
    Shape.RAMP: 3,
    Shape.SINE: 4,
    Shape.CHIRP: 5,
    Shape.TRAPEZOID: 3,
    Shape.SMOOTH: 2,
    Shape.PULSES: 6,
    Shape.TABLE: 4,
    Shape.TIMETABLE: 5,
}
#: shapes whose first two parameters are where rows lie in the program and how many
TABLES = (Shape.TABLE, Shape.TIMETABLE)
_POSITIVE = {
    Shape.TRAPEZOID: (1, 2),
    Shape.SMOOTH: (1,),
    Shape.PULSES: (2, 3),
    Shape.CHIRP: (2, 4),
    Shape.TABLE: (2,),
    Shape.TIMETABLE: (2,),
    Shape.SINE: (2,),
}

Bad = NDArray[np.bool_]
#: which segments are wrong, what is wrong, what was expected
Finding = tuple[Bad, str, str]


def require_program(values: NDArray[np.float64], length: int, where: str) -> None:
    """BadInputError names the first segment with something in it that the core could not follow; it must never see a
    NaN.
    """
    size = layout.SEGMENT_SIZE
    if length < 1 or len(values) < length * size or np.any(np.isnan(values)):
        raise BadInputError(where, "is no program", "whole segments without NaN")
    if np.any(np.abs(values[length * size :]) > LARGEST_NUMBER):
        raise BadInputError(where, "a table holds numbers that are infinite or too large", "finite numbers")
    segments = values[: length * size].reshape(length, size)
    for bad, problem, expected in _findings(segments, len(values)):
        if bad.any():
            raise BadInputError(f"{where}: segment {int(np.argmax(bad))}", problem, expected)


def _findings(segments: NDArray[np.float64], size: int) -> Iterator[Finding]:
    yield from _of_headers(segments)
    yield from _of_directions(segments)
    for axis in range(layout.AXES):
        start = layout.AXIS_SEGMENT + axis * layout.AXIS_SEGMENT_SIZE
        yield from _of_axis(segments[:, start : start + layout.AXIS_SEGMENT_SIZE], segments.size, size)


def _of_headers(segments: NDArray[np.float64]) -> Iterator[Finding]:
    header = segments[:, : layout.AXIS_SEGMENT]
    yield np.any(np.abs(header) > LARGEST_NUMBER, axis=1), "a number that is infinite or too large", "finite numbers"
    counts = header[:, [layout.DURATION_TICKS, layout.RECORD_EVERY]]
    bad = np.any((counts != np.floor(counts)) | (counts < 0), axis=1)
    yield bad, "duration or decimation out of range", "whole numbers of ticks, 0 or more"
    label = header[:, layout.SEGMENT_ID]
    yield (
        (label < 0) | (label >= 2**31) | (label != np.floor(label)),
        "a label that is none",
        "a whole number from 0 to 2^31 - 1",
    )
    for k in range(layout.END_CONDITIONS):
        end = header[:, layout.END + k * layout.END_SIZE :]
        known = np.isin(end[:, layout.END_KIND], list(EndKind)) & np.isin(end[:, layout.END_AXIS], (0, 1))
        yield (
            ~known | (end[:, layout.END_HOLD_TICKS] < 0),
            "an end condition that does not exist",
            "a kind, an axis, a threshold",
        )


def _of_directions(segments: NDArray[np.float64]) -> Iterator[Finding]:
    """A direction takes both axes, and has no start to count or move from."""
    outer, inner = (
        segments[:, start : start + layout.SHAPE_PARAMETERS]
        for start in (layout.AXIS_SEGMENT, layout.AXIS_SEGMENT + layout.AXIS_SEGMENT_SIZE)
    )
    points = [block[:, layout.SEGMENT_MODE] == Mode.POINTING for block in (outer, inner)]
    yield points[0] != points[1], "mode pointing on one axis", "on both: they hold a direction together"
    for block in (outer, inner):
        moves = np.isin(block[:, layout.SHAPE], (Shape.TRAPEZOID, Shape.SMOOTH))
        bad = points[0] & (moves | (block[:, layout.ORIGIN] == ReferenceOrigin.START))
        yield bad, "mode pointing with a start", "hold, ramp, sine, chirp, pulses or a table, from zero"


def _of_axis(block: NDArray[np.float64], tables: int, size: int) -> Iterator[Finding]:
    """Modes, shapes and their parameters; tables lie from value number `tables` on in a program of `size` values."""
    named = [np.isin(block[:, place], list(kind)) for place, kind in enumerate((Mode, Shape, ReferenceOrigin))]
    yield (
        ~np.all(named, axis=0),
        "a mode, shape or origin that does not exist",
        "one of the lists in gimbal_hil.loop.host",
    )
    shapes, parameters = block[:, 1], block[:, layout.SHAPE_PARAMETERS :]
    used = np.zeros(parameters.shape, bool)
    bad = np.zeros(len(block), bool)
    for shape, count in PARAMETER_COUNT.items():
        rows = shapes == shape
        used[rows, :count] = True
        for place in _POSITIVE.get(shape, ()):
            bad |= rows & ~(parameters[:, place] > 0.0)
    # a ramp without an end has an infinite span
    used[shapes == Shape.RAMP, 2] = False
    yield (
        np.any(used & (np.abs(parameters) > LARGEST_NUMBER), axis=1),
        "a parameter that is infinite or too large",
        "finite numbers",
    )
    yield bad, "a shape with a time, rate or frequency that is not positive", "positive numbers"
    first, rows = parameters[:, 0], parameters[:, 1]
    inside = (tables <= first) & (rows >= 1) & (first + rows <= size) & (first % 1 == 0) & (rows % 1 == 0)
    yield np.isin(shapes, TABLES) & ~inside, "a table outside the program", "rows behind the segments"
