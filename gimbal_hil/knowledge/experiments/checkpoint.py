"""A checkpoint: everything needed to go on with an experiment after a stop, a crash or a kill.

Two files in the run folder, each replaced in one move: `checkpoint.json` (which steps are done, their rows, how long
the log was) and `checkpoint.npz` (the state of the virtual antenna and its host, where there is one). The JSON names
the state it belongs to, so that a kill between the two moves leaves a checkpoint that is either whole or seen not to
be.
"""

from __future__ import annotations

import hashlib
import io
import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from firmware_protocol.documents import DocumentLimits, Strict, read_json, validated
from firmware_protocol.errors import BadInputError
from firmware_protocol.json_object import Json
from gimbal_hil.knowledge.experiments.experiment import Row

CHECKPOINT_FILE = "checkpoint.json"
#: a figure that could not be measured is a NaN in its row
_LIMITS = DocumentLimits(size_bytes=64 << 20, values=2_000_000, finite=False)


class _KeptState(Strict):
    """Where the arrays are: a file beside this one."""

    file: Annotated[str, Field(pattern=r"^checkpoint-[0-9]{1,9}\.npz$")]
    sha256: str
    kept: bool


class _KeptCheckpoint(Strict):
    """`checkpoint.json`."""

    done: Annotated[int, Field(ge=0)]
    plan_hash: str
    rows: tuple[Json, ...]
    log_mark: dict[str, Annotated[int, Field(ge=0)]]
    state: _KeptState


@dataclass(frozen=True)
class Checkpoint:
    """After `done` steps of the experiment whose plan hashes to `plan_hash`."""

    done: int
    plan_hash: str
    rows: tuple[Row, ...]
    log_mark: Mapping[str, int]
    state: Mapping[str, NDArray[np.generic]] | None
    #: signals of the steps that the report draws, by step name
    drawn: Mapping[str, Mapping[str, NDArray[np.float64]]]


def write_checkpoint(folder: Path, checkpoint: Checkpoint) -> None:
    """Keep a checkpoint; the one before stays valid until this one is whole.

    Without a state of a virtual antenna the experiment cannot be made again: then the checkpoint survives a power cut
    too, not a kill only.
    """
    durable = checkpoint.state is None
    arrays: dict[str, NDArray[np.generic]] = {
        f"state/{name}": array for name, array in (checkpoint.state or {}).items()
    }
    arrays |= {
        f"drawn/{step}/{name}": column for step, signals in checkpoint.drawn.items() for name, column in signals.items()
    }
    buffer = io.BytesIO()
    np.savez(buffer, **arrays)  # type: ignore[arg-type]
    digest = hashlib.sha256(buffer.getvalue()).hexdigest()
    name = f"checkpoint-{checkpoint.done}.npz"
    _replace(folder / name, buffer.getvalue(), durable)
    document = {
        "done": checkpoint.done,
        "plan_hash": checkpoint.plan_hash,
        "rows": list(checkpoint.rows),
        "log_mark": dict(checkpoint.log_mark),
        "state": {"file": name, "sha256": digest, "kept": checkpoint.state is not None},
    }
    _replace(folder / CHECKPOINT_FILE, json.dumps(document).encode(), durable)
    for old in folder.glob("checkpoint-*.npz"):
        if old.name != name:
            old.unlink()


def read_checkpoint(folder: Path) -> Checkpoint:
    """The last whole checkpoint of a run folder; BadInputError where there is none."""
    path = folder / CHECKPOINT_FILE
    document = read_json(path, "the checkpoint of an experiment that was stopped", _LIMITS)
    kept = validated(_KeptCheckpoint, document, str(path))
    arrays = _arrays(folder / kept.state.file, kept.state.sha256)
    state = {name.removeprefix("state/"): array for name, array in arrays.items() if name.startswith("state/")}
    drawn: dict[str, dict[str, NDArray[np.float64]]] = {}
    for name, array in arrays.items():
        if name.startswith("drawn/"):
            step, column = name.removeprefix("drawn/").rsplit("/", 1)
            drawn.setdefault(step, {})[column] = np.asarray(array, np.float64)
    return Checkpoint(kept.done, kept.plan_hash, kept.rows, kept.log_mark, state if kept.state.kept else None, drawn)


def _arrays(path: Path, sha256: str) -> dict[str, NDArray[np.generic]]:
    """The arrays of a checkpoint, which must be the bytes that were hashed; only then are they taken apart."""
    expected = "the file that the experiment left"
    try:
        data = path.read_bytes()
    except OSError as error:
        raise BadInputError(str(path), f"cannot be read ({error.strerror or error})", expected) from None
    if hashlib.sha256(data).hexdigest() != sha256:
        raise BadInputError(str(path), "is not what its checkpoint was made with", expected)
    return dict(np.load(io.BytesIO(data), allow_pickle=False))


def remove_checkpoint(folder: Path) -> None:
    """Take the checkpoint away once the experiment is complete."""
    (folder / CHECKPOINT_FILE).unlink(missing_ok=True)
    for old in folder.glob("checkpoint-*.npz"):
        old.unlink()


def _replace(path: Path, data: bytes, durable: bool) -> None:
    part = path.with_name(path.name + ".part")
    with part.open("wb") as handle:
        handle.write(data)
        if durable:
            handle.flush()
            os.fsync(handle.fileno())
    os.replace(part, path)
