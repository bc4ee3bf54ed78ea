"""A checkpoint: everything needed to go on with an experiment after a stop, a crash or a kill.

Two files in the run folder, each replaced in one move: `checkpoint.json` (which steps are done, their rows, how long the log was) and
`checkpoint.npz` (the state of the virtual antenna and its host, where there is one). The JSON names the state it belongs to, so that a kill
between the two moves leaves a checkpoint that is either whole or seen not to be.
"""

from __future__ import annotations

import hashlib
import io
import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.errors import BadInputError
from gimbal_hil.experiments.experiment import Row

CHECKPOINT_FILE = "checkpoint.json"


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

    Without a state of a virtual antenna the experiment cannot be made again: then the checkpoint survives a power cut too, not a kill only.
    """
    durable = checkpoint.state is None
    arrays: dict[str, NDArray[np.generic]] = {f"state/{name}": array for name, array in (checkpoint.state or {}).items()}
    arrays |= {f"drawn/{step}/{name}": column for step, signals in checkpoint.drawn.items() for name, column in signals.items()}
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
    try:
        document: dict[str, Any] = json.loads(path.read_text())
        data = (folder / document["state"]["file"]).read_bytes()
        if hashlib.sha256(data).hexdigest() != document["state"]["sha256"]:
            raise BadInputError(str(folder / document["state"]["file"]), "is not what its checkpoint was made with")
        arrays = dict(np.load(io.BytesIO(data)))
        state = {name.removeprefix("state/"): array for name, array in arrays.items() if name.startswith("state/")}
        drawn: dict[str, dict[str, NDArray[np.float64]]] = {}
        for name, array in arrays.items():
            if name.startswith("drawn/"):
                step, column = name.removeprefix("drawn/").rsplit("/", 1)
                drawn.setdefault(step, {})[column] = array
        kept = bool(document["state"]["kept"])
        return Checkpoint(
            int(document["done"]), str(document["plan_hash"]), tuple(document["rows"]), document["log_mark"], state if kept else None, drawn
        )
    except FileNotFoundError:
        raise BadInputError(str(path), "no such file", "the folder of an experiment that was stopped") from None
    except (KeyError, TypeError, ValueError, OSError) as error:
        raise BadInputError(str(path), f"is no checkpoint ({error})", "the file that the experiment left") from None


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
