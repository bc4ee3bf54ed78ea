"""Documents: what the reader takes a text for, what it refuses in which words, and that what is written is read
again.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

import pytest
from hypothesis import given
from hypothesis import strategies as some
from pydantic import Field

from firmware_protocol.documents import (
    LARGEST_NUMBER,
    DocumentLimits,
    Strict,
    json_line,
    read_yaml,
    validated,
    yaml_mapping,
    yaml_text,
)
from firmware_protocol.errors import BadInputError


def test_plain_scalars_are_what_they_look_like() -> None:
    text = "a: [1, -2, +3, 1e-3, .5, 2., 0x1F, true, False, null, ~, , 'true', \"1\"]"
    assert yaml_mapping(text.replace(", ,", ","), "f", "x")["a"] == [
        1,
        -2,
        3,
        0.001,
        0.5,
        2.0,
        31,
        True,
        False,
        None,
        None,
        "true",
        "1",
    ]


@pytest.mark.parametrize(
    "text", ["2026-13-45", "1:30", "0o17", "1_000", "yes", "no", "on", "<<", "=", "0b1", "1e", "e1", ".", "+"]
)
def test_what_other_readers_take_for_dates_times_and_switches_is_text(text: str) -> None:
    assert yaml_mapping(f"a: {text}", "f", "x")["a"] == text


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("a: 1\nb: 2\na: 3", "line 3: the key 'a' stands here again, first in line 1"),
        ("a: !!float 1", "line 1: the tag"),
        ("a: !own {}", "line 1: the tag '!own'"),
        ("a: *b", "line 1: the alias *b"),
        ("a: &a [*a]", "line 1: the alias *a"),
        ("x:\n  - " + "[" * 40, "nested deeper than 32 levels"),
        ("a: " + "7" * 31, "more than 30 digits"),
        ("a: 0x" + "7" * 5000, "more than 30 digits"),
        ("a: .inf", "no finite number"),
        ("a: -.INF", "no finite number"),
        ("a: .nan", "no finite number"),
        ("a: 1e400", "infinite or too large"),
        ("a: 010", "octal or decimal"),
        ("a: 1\n---\nb: 2", "line 2: a second document"),
        ("? [a]\n: 1", "cannot be a key"),
        ("? {a: 1}\n: 1", "cannot be a key"),
        ("- 1", "holds no mapping"),
        ("", "holds no mapping"),
        ("a: \x00", "control characters"),
    ],
)
def test_a_text_with_a_surprise_in_it_is_refused_with_its_line(text: str, says: str) -> None:
    with pytest.raises(BadInputError) as refused:
        yaml_mapping(text, "file.yaml", "a plan")
    assert (
        says in str(refused.value)
        and str(refused.value).startswith("file.yaml")
        and str(refused.value).endswith("expected a plan")
    )


def test_an_alias_is_a_copy_and_counts_as_often_as_it_is_used() -> None:
    document = yaml_mapping("a: &a {x: [1]}\nb: *a", "f", "x")
    document["a"]["x"].append(2)
    assert document["b"] == {"x": [1]}
    bomb = "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n"
    bomb += "".join(f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 10)}]\n" for n in range(1, 9))
    with pytest.raises(BadInputError, match="more than 400000 values"):
        yaml_mapping(bomb, "f", "x")
    with pytest.raises(BadInputError, match="nested deeper"):
        yaml_mapping(
            "a: &a [1]\n" + "".join(f"b{n}: &b{n} [*{'a' if n == 0 else f'b{n - 1}'}]\n" for n in range(40)), "f", "x"
        )


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ('{"a": 1, "a": 2}', "the key 'a' twice"),
        ('{"a": {"b": [1e400]}}', "a.b.0: is or holds a number that is infinite"),
        ('{"a": NaN}', "nan"),
        ('{"a": -Infinity}', "infinite"),
        ('{"a": ' + "9" * 400 + "}", "more than 30 digits"),
        ('{"a": ' + "9" * 5000 + "}", "more than 30 digits"),
        ('{"a": "\\ud800"}', "half a character"),
        ('{"\\ud800": 1}', "half a character"),
        ("[" * 100_000, "nested deeper"),
        ('{"a":' * 40 + "1" + "}" * 40, "nested deeper"),
        ("[1]", "no JSON object"),
        ("{", "is not JSON"),
    ],
)
def test_json_is_held_to_the_same(text: str, says: str) -> None:
    with pytest.raises(BadInputError) as refused:
        json_line(text, "line 1", "an event")
    assert says in str(refused.value)


def test_a_document_that_is_too_large_or_no_text_is_refused_before_it_is_parsed(tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    path.write_bytes(b"a: " + b"x" * (20 << 20))
    with pytest.raises(BadInputError, match="longer than 4 MiB"):
        read_yaml(path, "a plan")
    path.write_bytes(b"a: 1\nb: \xff")
    with pytest.raises(BadInputError, match="line 2 is not UTF-8"):
        read_yaml(path, "a plan")
    with pytest.raises(BadInputError, match="is a folder"):
        read_yaml(tmp_path, "a plan")
    with pytest.raises(BadInputError, match="no such file"):
        read_yaml(tmp_path / "none.yaml", "a plan")
    with pytest.raises(BadInputError, match="more than 3 values"):
        json_line("{" + ", ".join(f'"{n}": 0' for n in range(4)) + "}", "f", "x", DocumentLimits(values=3))


_LEAF = (
    some.none()
    | some.booleans()
    | some.integers(-(10**20), 10**20)
    | some.floats(allow_nan=False, allow_infinity=False)
    | some.text()
)
_TREES = some.recursive(
    _LEAF,
    lambda inner: some.lists(inner, max_size=4) | some.dictionaries(some.text(), inner, max_size=4),
    max_leaves=12,
)


@given(some.dictionaries(some.text(), _TREES, max_size=4))
def test_what_is_written_is_read_back_as_it_was(document: dict[str, object]) -> None:
    def plain(text: str) -> bool:
        return all(character.isprintable() or character in "\n\t " for character in text)

    if all(plain(text) for text in _texts(document)):
        assert yaml_mapping(yaml_text(document), "f", "x") == document


def _texts(value: object) -> list[str]:
    if isinstance(value, dict):
        return [*value, *(text for inner in value.values() for text in _texts(inner))]
    if isinstance(value, list):
        return [text for inner in value for text in _texts(inner)]
    return [value] if isinstance(value, str) else []


class Inner(Strict):
    """A section."""

    rate_rad_s: float
    points: tuple[float, ...] = ()


class Outer(Strict):
    """A document."""

    inner: Inner
    ticks: int = 1
    listed: dict[str, int | float | bool | str] | None = None


@pytest.mark.parametrize(
    ("document", "says"),
    [
        ({"inner": {"rate_rad_s": True}}, "f: inner.rate_rad_s: True: Input should be a valid number"),
        ({"inner": {"rate_rad_s": "3"}}, "f: inner.rate_rad_s: '3': Input should be a valid number"),
        ({"inner": {"rate_rad_s": 1e300}}, "f: inner.rate_rad_s: 1e+300: Input should be less than or equal to"),
        ({"inner": {"rate_rad_s": -1e300}}, "greater than or equal to"),
        ({"inner": {"rate_rad_s": math.inf}}, "finite"),
        ({"inner": {"rate_rad_s": 1.0, "points": [1.0, True]}}, "f: inner.points.1"),
        ({"inner": {"rate_rad_s": 1.0}, "ticks": True}, "f: ticks"),
        ({"inner": {"rate_rad_s": 1.0}, "ticks": 2.0}, "f: ticks"),
        ({"inner": {"rate": 1.0}}, "f: inner.rate: unknown key (and 1 more); expected one of rate_rad_s, points"),
        ({"inner": {"rate_rads": 1.0}}, "expected rate_rad_s?"),
        ({"iner": {}}, "f: iner: unknown key (and 1 more); expected inner?"),
        ({"inner": {}}, "f: inner.rate_rad_s: is missing"),
    ],
)
def test_a_section_takes_numbers_for_numbers_and_names_the_key(document: dict[str, object], says: str) -> None:
    with pytest.raises(BadInputError) as wrong:
        validated(Outer, document, "f")
    assert says in str(wrong.value)


def test_a_section_takes_whole_numbers_for_floats_and_keeps_what_else_is_right() -> None:
    read = Outer.model_validate(
        {"inner": {"rate_rad_s": 1, "points": [1, 2.5, LARGEST_NUMBER]}, "listed": {"a": True, "b": 1, "c": "x"}}
    )
    assert (
        read.inner.rate_rad_s == 1.0
        and read.inner.points == (1.0, 2.5, LARGEST_NUMBER)
        and read.listed == {"a": True, "b": 1, "c": "x"}
    )


class _Item(Strict):
    size: float


class _Pair(Strict):
    items: Annotated[tuple[_Item, ...], Field(min_length=2)]


@pytest.mark.parametrize(
    ("items", "wrong"),
    [
        ([{"size": "large"}, {"size": 1.0}], ["f: items.0.size"]),
        ([{"size": 1.0}], ["f: items"]),
        ([{"size": "large"}], ["f: items.0.size", "f: items"]),
    ],
)
def test_a_list_is_too_short_only_where_an_item_is_missing(items: list[dict[str, object]], wrong: list[str]) -> None:
    with pytest.raises(BadInputError) as found:
        validated(_Pair, {"items": items}, "f")
    assert [found.value.where, *(other.where for other in found.value.others)] == wrong
