"""A record is a view of words by name, the same in Python and in compiled code."""

from __future__ import annotations

import numpy as np

from firmware_protocol.compiling import compiled, entry_point
from firmware_protocol.records import Annotated, MemoryRecord, Sequence, layout_of


class Joint(MemoryRecord):
    position: float
    count: int


class Antenna(MemoryRecord):
    tick: int
    joints: Annotated[Sequence[Joint], 2]
    spare: Annotated[Sequence[float], 3]


ANTENNA = layout_of(Antenna)


@compiled
def _advance(antenna: Antenna) -> None:
    antenna.tick += 1
    for axis in range(2):
        joint = antenna.joints[axis]
        joint.position += 0.5 * (axis + 1)
        joint.count = antenna.tick << axis


@entry_point
def advance(words: np.ndarray) -> None:
    _advance(words.view(ANTENNA)[0])


def test_a_record_lies_in_its_words_in_the_order_of_its_definition() -> None:
    words = np.zeros(8, dtype=np.int64)
    antenna = words.view(ANTENNA)[0]
    antenna.tick, antenna.joints[1].count = 7, 9
    antenna.joints[0].position = 0.25
    assert ANTENNA.itemsize == words.nbytes
    assert words.tolist()[:1] == [7] and words[4] == 9
    assert words.view(np.float64)[1] == 0.25


def test_compiled_code_and_python_read_and_write_the_same_record() -> None:
    compiled_words, python_words = np.zeros(8, dtype=np.int64), np.zeros(8, dtype=np.int64)
    for _ in range(3):
        advance(compiled_words)
        getattr(_advance, "py_func", _advance)(python_words.view(ANTENNA)[0])
    assert compiled_words.tobytes() == python_words.tobytes()
    assert compiled_words.view(ANTENNA)[0].joints[1].count == 6
