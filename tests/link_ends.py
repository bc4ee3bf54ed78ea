"""Both ends of a link for tests: opened as a configuration opens it, blocks to send, blocks received."""

from __future__ import annotations

from pydantic import TypeAdapter

from firmware_protocol.links import (
    Link,
    LinkConfig,
)
from firmware_protocol.messages import SetPoint
from firmware_protocol.opening import open_link
from tests.endpoints import Sender

CONFIG = TypeAdapter(LinkConfig)


def opened(**config: object) -> Link:
    return open_link(CONFIG.validate_python(config))


def set_points(count: int) -> bytes:
    return Sender().encode(
        *[SetPoint(0.001 * number, -0.002 * number, number % 1024, True, False) for number in range(count)]
    )


def received(link: Link, size: int) -> bytes:
    block = b""
    for _ in range(100):
        block += link.receive()
        if len(block) >= size:
            break
        link.wait(20_000_000)
    return block
