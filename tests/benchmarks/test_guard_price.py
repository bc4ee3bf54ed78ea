"""The copy of the host without guards keeps up with the host."""

from __future__ import annotations

import ast

import pytest

from tests.benchmarks.guard_price import WITHOUT, source_without


@pytest.mark.parametrize("name", WITHOUT)
def test_what_the_copy_leaves_out_is_in_the_source_and_does_nothing(name: str) -> None:
    functions = {node.name: node for node in source_without(name).body if isinstance(node, ast.FunctionDef)}
    for left_out in WITHOUT[name]:
        assert [type(node) for node in functions[left_out].body] == [ast.Pass]
