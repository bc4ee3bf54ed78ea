"""Values changed in a YAML text: what is not changed stays, character by character."""

from __future__ import annotations

import pytest

from firmware_protocol.documents import yaml_edited, yaml_mapping
from firmware_protocol.errors import BadInputError

TEXT = """\
# first
a: 1  # one
b:
  c: {d: 2.0, e: word}   # flow
  f:
    g: 3
    # of h
    h: [1, 2]
# last
z: end
"""


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"a": 5}, TEXT.replace("a: 1  #", "a: 5  #")),
        ({"b.c.d": 0.001}, TEXT.replace("d: 2.0", "d: 0.001")),
        ({"b.c.x": True}, TEXT.replace("e: word}", "e: word, x: true}")),
        ({"b.f.h": [3.5]}, TEXT.replace("[1, 2]", "[3.5]")),
        ({"b.f.i": "new"}, TEXT.replace("[1, 2]\n", "[1, 2]\n    i: new\n")),
        ({"b.k": {"l": 1.0}}, TEXT.replace("[1, 2]\n", "[1, 2]\n  k: {l: 1.0}\n")),
        ({"b.m.n": 1}, TEXT.replace("[1, 2]\n", "[1, 2]\n  m: {n: 1}\n")),
        ({"y": None}, TEXT + "y: null\n"),
        ({"b.f": {"g": 4}}, TEXT.replace("  f:\n    g: 3\n    # of h\n    h: [1, 2]\n", "  f: {g: 4}\n")),
    ],
)
def test_only_the_value_changes(changes: dict[str, object], expected: str) -> None:
    found = yaml_edited(TEXT, changes, "a file")
    assert found == expected
    yaml_mapping(found, "a file", "a table")


def test_a_key_below_no_table_and_an_anchor_are_refused() -> None:
    with pytest.raises(BadInputError, match=r"a file: a.*is no table"):
        yaml_edited(TEXT, {"a.b": 1}, "a file")
    with pytest.raises(BadInputError, match="anchors"):
        yaml_edited("a: &x {b: 1}\nc: *x\n", {"a.b": 2}, "a file")
