"""A refusal by a worker reaches the process that asked."""

from __future__ import annotations

import pickle

from firmware_protocol.errors import BadInputError


def test_a_refusal_is_the_same_in_another_process() -> None:
    refusal = BadInputError("a.yaml", "is 3", "below 2", [BadInputError("b", "is missing")])
    again = pickle.loads(pickle.dumps(refusal))
    assert str(again) == str(refusal) and [str(one) for one in again.others] == ["b: is missing"]
