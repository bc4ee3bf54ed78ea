"""Thousands of broken documents: each is read or refused with the project's own error, never anything else."""

from __future__ import annotations

import os
from random import Random

import pytest

from firmware_protocol.documents import yaml_mapping, yaml_text
from firmware_protocol.errors import BadInputError
from tests.fuzz.mutations import json_text, mutated, mutated_text
from tests.fuzz.targets import READERS, REQUESTS, shipped, start_request

#: per kind; `FUZZ_DOCUMENTS=20000` digs deeper
ROUNDS = int(os.environ.get("FUZZ_DOCUMENTS", "1500"))


def outcome(kind: str, data: bytes) -> str:
    """Read or refused; anything else fails with the document that did it."""
    try:
        READERS[kind](data)
    except BadInputError as refused:
        text = str(refused)
        assert "\n" not in text and len(text) < 2000 and text.encode(), text[:300]
        return "refused"
    except Exception as error:
        raise AssertionError(f"{type(error).__name__}: {error}\n{data[:3000].decode(errors='replace')}") from error
    return "read"


@pytest.mark.parametrize("kind", ["configuration", "plan", "model"])
def test_a_broken_yaml_document_is_read_or_refused_and_nothing_else(kind: str) -> None:
    random = Random(f"{kind} 1")
    texts = shipped(kind)
    outcomes = []
    for place in range(ROUNDS):
        text = texts[place % len(texts)]
        if place % 2:
            data = mutated_text(text, random)
        else:
            data = json_text(mutated(yaml_mapping(text, kind, kind), random)).encode()
        outcomes.append(outcome(kind, data))
    # both ends are met: a fuzzer whose documents are all refused at the first byte shows nothing
    assert outcomes.count("read") > ROUNDS // 50 and outcomes.count("refused") > ROUNDS // 3


def test_a_broken_request_is_taken_or_refused_and_nothing_else() -> None:
    random = Random("request 1")
    outcomes = []
    for place in range(ROUNDS):
        request = start_request(random) if place % 5 == 4 else REQUESTS[place % 5]
        broken = mutated(request, random)
        data = json_text(broken).encode() if place % 3 else mutated_text(json_text(broken), random)
        outcomes.append(outcome("request", data))
    assert outcomes.count("read") > ROUNDS // 50 and outcomes.count("refused") > ROUNDS // 3


@pytest.mark.parametrize("kind", ["configuration", "plan", "model"])
def test_what_is_shipped_is_read_and_survives_being_written(kind: str) -> None:
    for text in shipped(kind):
        document = yaml_mapping(text, kind, kind)
        assert yaml_mapping(yaml_text(document), kind, kind) == document
        assert outcome(kind, text.encode()) == "read"
