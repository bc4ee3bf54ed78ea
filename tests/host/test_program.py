"""Programs: what may be asked of the host, exactly as it goes over a socket or into a log."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol.errors import BadInputError
from gimbal_hil.loop.host import AxisCommand, EndCondition, EndKind, Guard, Mode, Program, Segment, Shape, program_of


def test_a_program_is_the_same_bits_after_json() -> None:
    axis = AxisCommand(
        Mode.RATE, Shape.TABLE, (0.01, 0.1), table=np.array([0.1, 1 / 3, -2.0]), guard=Guard(-1.0, math.inf)
    )
    program = program_of(
        [Segment(axis, AxisCommand(), 100, (EndCondition(EndKind.RATE_BELOW, 1, 0.01, 5),), label=9)] * 3
    )
    again = Program.from_document(json.loads(json.dumps(program.as_document())))
    assert again.length == 3
    assert again.values.tobytes() == program.values.tobytes()


@pytest.mark.parametrize(
    ("axis", "says"),
    [
        (AxisCommand(Mode.RATE, Shape.HOLD, (math.nan,)), "NaN"),
        (AxisCommand(Mode.RATE, Shape.HOLD, (math.inf,)), "infinite"),
        (AxisCommand(Mode.RATE, Shape.HOLD, (1.0, 2.0)), "parameters for HOLD"),
        (AxisCommand(Mode.POSITION, Shape.SMOOTH, (1.0, 0.0)), "not positive"),
        (AxisCommand(Mode.POSITION, Shape.TABLE, (0.1, 1.0)), "without rows"),
        (AxisCommand(Mode.POSITION, Shape.TABLE, (0.1, 1.0), table=(1.0, math.inf)), "infinite"),
    ],
)
def test_what_the_host_could_not_follow_is_refused(axis: AxisCommand, says: str) -> None:
    with pytest.raises(BadInputError, match=says):
        program_of([Segment(axis, AxisCommand())])


def test_segments_of_one_label_share_their_decimation() -> None:
    with pytest.raises(BadInputError, match="decimation"):
        program_of([Segment(label=1, record_every=2), Segment(label=1, record_every=3)])


@given(
    st.dictionaries(
        st.sampled_from(["length", "values"]),
        st.one_of(st.integers(-5, 5), st.lists(st.floats(), max_size=60), st.text()),
    )
)
def test_any_document_is_a_program_or_bad_input(document: dict[str, object]) -> None:
    try:
        Program.from_document(document)
    except BadInputError as error:
        assert "program" in str(error) or "segment" in str(error) or "table" in str(error)


@given(st.lists(st.floats(-20.0, 20.0), min_size=46, max_size=46))
def test_numbers_that_name_nothing_are_refused(numbers: list[float]) -> None:
    values = program_of([Segment()]).values.copy()
    assert len(values) <= 46
    values[:] = np.round(numbers[: len(values)])
    try:
        program = Program.from_document({"length": 1, "values": values.tolist()})
    except BadInputError:
        return
    assert program.values[0] >= 0
