"""Copies of documents."""

from __future__ import annotations

import copy

from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol.documents import copied

LEAVES = st.one_of(st.none(), st.booleans(), st.integers(), st.floats(allow_nan=False), st.text())
DOCUMENTS = st.recursive(
    LEAVES, lambda inner: st.one_of(st.lists(inner, max_size=4), st.dictionaries(st.text(), inner, max_size=4))
)


def emptied(document: object) -> None:
    """Every mapping and list of a document, made empty."""
    if isinstance(document, dict | list):
        for value in document.values() if isinstance(document, dict) else document:
            emptied(value)
        document.clear()


@given(DOCUMENTS)
def test_a_copy_is_equal_and_what_is_done_to_it_is_not_done_to_the_document(document: object) -> None:
    expected = copy.deepcopy(document)
    made = copied(document)
    assert made == expected
    emptied(made)
    assert document == expected
