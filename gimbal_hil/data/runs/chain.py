"""The seal of a run: one line for every block that was written, each with the hash of all that came before it.

    sha256(n) = SHA-256(sha256(n-1), SHA-256(tick rows), SHA-256(frame rows), SHA-256(event lines))

It starts from what is fixed when a run begins (who, when, software, configuration, model, seed, period) and ends, in
`run.yaml`, with how the run ended. A line is written after its rows: a kill can leave rows without a line, never a line
without its rows.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from firmware_protocol.documents import json_line
from firmware_protocol.errors import BadInputError
from gimbal_hil.data.runs.segments import segments_of

CHAIN_FILE = "chain.jsonl"


@dataclass(frozen=True, slots=True)
class SealedBlock:
    """One line: how many rows of each kind the log holds up to and with this block, and the hash of all of them."""

    ticks: int
    frames: int
    events: int
    sha256: str

    def line(self) -> bytes:
        """As it stands in the file."""
        return (
            json.dumps({"ticks": self.ticks, "frames": self.frames, "events": self.events, "sha256": self.sha256})
            + "\n"
        ).encode()


def linked(before: str, ticks: bytes, frames: bytes, events: bytes) -> str:
    """Hash of a block whose predecessor's is `before`."""
    digest = hashlib.sha256(bytes.fromhex(before))
    for part in (ticks, frames, events):
        digest.update(hashlib.sha256(part).digest())
    return digest.hexdigest()


def plain_hash(content: object) -> str:
    """SHA-256 of plain data, whatever the order of its keys."""
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def sealed_with(last: str, end: Mapping[str, object]) -> str:
    """The hash that seals a run whose last block has the hash `last` and which ended as `end` says."""
    return hashlib.sha256(bytes.fromhex(last) + bytes.fromhex(plain_hash(end))).hexdigest()


def read_chain(folder: Path) -> tuple[tuple[SealedBlock, ...], bool]:
    """The whole lines of the chain, and whether one of them is damaged (what follows it is left out); nothing in an
    older run.

    The chain of a further segment begins with the last line of the one before. Where that was given up, the first block
    here stands for all that is gone.
    """
    blocks: list[SealedBlock] = []
    for _, path in segments_of(folder, CHAIN_FILE):
        try:
            lines = path.read_bytes().split(b"\n")[:-1]
        except OSError as error:
            raise BadInputError(str(path), error.strerror or "cannot be read", "the seal of the run") from error
        before = tuple(blocks)
        for place, line in enumerate(lines):
            block = _block(line)
            if block is None or (place == 0 and before and block != before[-1]):
                return tuple(blocks), True
            if place or not before:
                blocks.append(block)
    return tuple(blocks), False


def _block(line: bytes) -> SealedBlock | None:
    try:
        document = json_line(line, CHAIN_FILE, "a block")
    except BadInputError:
        return None
    ticks, frames, events, sha256 = (document.get(key) for key in ("ticks", "frames", "events", "sha256"))
    counted = all(
        isinstance(count, int) and not isinstance(count, bool) and count >= 0 for count in (ticks, frames, events)
    )
    if not counted or not isinstance(sha256, str) or len(sha256) != 64 or not set(sha256) <= set("0123456789abcdef"):
        return None
    return SealedBlock(ticks, frames, events, sha256)  # type: ignore[arg-type]
