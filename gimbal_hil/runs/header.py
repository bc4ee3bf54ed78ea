"""`run.yaml`: who recorded what, when and with which software, configuration, model and seed; and how it ended."""

from __future__ import annotations

import getpass
import hashlib
import json
import os
import platform
import socket
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from firmware_protocol.documents import read_yaml, yaml_text
from firmware_protocol.errors import BadInputError
from gimbal_hil import __version__
from gimbal_hil.runs.schema import AXES

RUN_FILE = "run.yaml"
SCHEMA = 1
LOG_PARTS = ("ticks", "frames", "events")
_KINDS = {dict: "a table", int: "an integer", str: "text", bool: "true or false"}


@dataclass(frozen=True)
class RunHeader:
    """What is fixed when a run starts. `configuration` and `model` are the full, plain contents of their files."""

    configuration: Mapping[str, Any]
    model: Mapping[str, Any]
    seed: int
    period_ns: int
    lockstep: bool
    title: str = ""
    #: names of the axes, the carrying one first: columns of the log are named after them
    axes: tuple[str, str] = AXES
    command_line: tuple[str, ...] = field(default_factory=lambda: tuple(sys.argv))


@dataclass(frozen=True)
class RunEnd:
    """How a run ended: the exit code of the command, why, how many rows of each kind the log then held, and their hashes.

    `counts` and `hashes` have the keys `ticks`, `frames` and `events`.
    """

    exit_code: int
    reason: str
    counts: Mapping[str, int]
    hashes: Mapping[str, str]


@dataclass(frozen=True)
class RunRecord:
    """`run.yaml` as read back; `end` is None while the run goes on and after a kill."""

    header: RunHeader
    who: Mapping[str, Any]
    started_utc: str
    ended_utc: str | None
    software: Mapping[str, Any]
    hashes: Mapping[str, str]
    end: RunEnd | None


def wall_clock_utc() -> str:
    """Time of day for people; nothing computes with it."""
    return datetime.now(UTC).isoformat(timespec="milliseconds")


def plain_hash(content: Mapping[str, Any]) -> str:
    """SHA-256 of plain data, whatever the order of its keys."""
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def write_header(folder: Path, header: RunHeader, started_utc: str, end: RunEnd | None) -> None:
    """Write `run.yaml` so that at every moment it is whole: the old one or the new one. Raises OSError."""
    configuration, model = _plain(header.configuration), _plain(header.model)
    hashes = {"configuration": plain_hash(configuration), "model": plain_hash(model)}
    document = {
        "schema": SCHEMA,
        "title": header.title,
        "who": {"user": _user(), "host": socket.gethostname(), "command": list(header.command_line)},
        "when": {"started_utc": started_utc, "ended_utc": wall_clock_utc() if end else None},
        "software": {
            "gimbal_hil": __version__,
            "python": platform.python_version(),
            "machine": f"{platform.system()} {platform.release()} {platform.machine()}",
        },
        "period_ns": header.period_ns,
        "lockstep": header.lockstep,
        "seed": header.seed,
        "axes": list(header.axes),
        "exit_status": {"code": end.exit_code, "reason": end.reason} if end else None,
        "log": dict(end.counts) if end else None,
        "hashes": hashes | (dict(end.hashes) if end else {}),
        "configuration": configuration,
        "model": model,
    }
    temporary = folder / f".{RUN_FILE}.{os.getpid()}"
    try:
        temporary.write_text(yaml_text(document), encoding="utf-8")
        temporary.replace(folder / RUN_FILE)
    except OSError:
        temporary.unlink(missing_ok=True)
        raise


def read_header(folder: Path) -> RunRecord:
    """Read `run.yaml`; raises BadInputError that names the file and the key."""
    path = folder / RUN_FILE
    if not folder.exists():
        raise BadInputError(str(folder), "does not exist", f"a folder with {RUN_FILE}")
    if not folder.is_dir():
        raise BadInputError(str(folder), "is a file", f"a run folder with {RUN_FILE}")
    if not path.exists():
        raise BadInputError(str(folder), "is not a run folder", f"a folder with {RUN_FILE}")
    return _parse(path, read_yaml(path, "the run.yaml of a run folder"))


def _parse(path: Path, document: dict[str, Any]) -> RunRecord:
    if document.get("schema") != SCHEMA:
        raise BadInputError(f"{path}: schema", f"is {document.get('schema')!r}", f"{SCHEMA}: this version reads no other")
    who, when = _get(path, document, "who", dict), _get(path, document, "when", dict)
    header = RunHeader(
        configuration=_get(path, document, "configuration", dict),
        model=_get(path, document, "model", dict),
        seed=_get(path, document, "seed", int),
        period_ns=_get(path, document, "period_ns", int),
        lockstep=_get(path, document, "lockstep", bool),
        title=_get(path, document, "title", str),
        axes=_axes(path, document.get("axes", list(AXES))),
        command_line=tuple(map(str, who.get("command") or ())),
    )
    if header.period_ns <= 0:
        raise BadInputError(f"{path}: period_ns", f"is {header.period_ns}", "nanoseconds above zero")
    hashes = _get(path, document, "hashes", dict)
    end = None
    if document.get("exit_status") is not None:
        status, log = _get(path, document, "exit_status", dict), _get(path, document, "log", dict)
        end = RunEnd(
            _get(path, status, "code", int, "exit_status."),
            _get(path, status, "reason", str, "exit_status."),
            {part: _get(path, log, part, int, "log.") for part in LOG_PARTS},
            {part: _get(path, hashes, part, str, "hashes.") for part in LOG_PARTS},
        )
    return RunRecord(header, who, str(when.get("started_utc")), when.get("ended_utc"), _get(path, document, "software", dict), hashes, end)


def _axes(path: Path, names: object) -> tuple[str, str]:
    if not isinstance(names, list) or len(names) != 2 or not all(isinstance(name, str) for name in names):
        raise BadInputError(f"{path}: axes", f"is {names!r}", "the names of two axes, the carrying one first")
    return names[0], names[1]


def _get(path: Path, table: dict[str, Any], key: str, kind: type, prefix: str = "") -> Any:
    value = table.get(key)
    if not isinstance(value, kind) or (kind is int and isinstance(value, bool)):
        problem = f"is {value!r}" if key in table else "is missing"
        raise BadInputError(f"{path}: {prefix}{key}", problem, _KINDS[kind])
    return value


def _plain(content: Mapping[str, Any]) -> dict[str, Any]:
    plain: dict[str, Any] = json.loads(json.dumps(content))
    return plain


def _user() -> str:
    try:
        return getpass.getuser()
    except (KeyError, OSError):
        return str(os.getuid())
