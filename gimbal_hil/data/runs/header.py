"""`run.yaml`: who recorded what, when and with which software, configuration, model and seed; and how it ended."""

from __future__ import annotations

import contextlib
import getpass
import json
import os
import platform
import socket
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from firmware_protocol.documents import printable, read_yaml, yaml_text
from firmware_protocol.errors import BadInputError
from firmware_protocol.json_object import Json
from firmware_protocol.schema import PROTOCOL_VERSION
from firmware_protocol.version import __version__
from gimbal_hil.data.runs.chain import plain_hash, sealed_with
from gimbal_hil.data.runs.schema import AXES
from gimbal_hil.loop.timing import wall_clock_utc

RUN_FILE = "run.yaml"
SCHEMA = 1
LOG_PARTS = ("ticks", "frames", "events")
#: what does not change after the start, though another process goes on with the run
_FIXED = ("schema", "title", "period_ns", "lockstep", "seed", "axes", "configuration", "model")
_AT_THE_END = ("who", "when", "software", "exit_status", "log")
#: parts whose hash stands in the file one by one, so that a change can be named
_HASHED = (*_FIXED, *_AT_THE_END)
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
    """How a run ended: the exit code of the command, why, how many rows of each kind the log then held, and their
    hashes.

    `counts` and `hashes` have the keys `ticks`, `frames` and `events`.
    """

    exit_code: int
    reason: str
    counts: Mapping[str, int]
    hashes: Mapping[str, str]
    #: hash of the last block of the chain (see `chain`); empty in a run that was recorded before there was one
    last_block: str = ""
    #: gains and limits that an operator changed and that were in force at the end, by axis and number; the
    #: configuration is what the run began with
    adjusted: Mapping[str, Mapping[str, float]] = field(default_factory=dict)


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
    #: hash of what is fixed when a run starts: where its chain begins
    genesis: str = ""
    #: the hash that seals a finished run, as it stands in the file and as its content gives it
    seal: str = ""
    expected_seal: str = ""
    #: hash of each part of the file as it is, to compare with `hashes`
    found_hashes: Mapping[str, str] = field(default_factory=dict)
    #: version of the wire that the frames are of; a run that does not say so is of the first
    protocol: int = 1

    @property
    def every_ticks(self) -> int:
        """One tick in so many is in the log."""
        recording = self.header.configuration.get("recording")
        every = recording.get("every_ticks") if isinstance(recording, Mapping) else None
        return every if isinstance(every, int) and every > 0 else 1


def genesis_of(document: Mapping[str, Any]) -> str:
    """Hash of all in `run.yaml` that is fixed when the run starts."""
    started = {"started_utc": document["when"].get("started_utc")}
    protocol = {"protocol": document["protocol"]} if "protocol" in document else {}
    return plain_hash({key: document.get(key) for key in _FIXED} | started | protocol)


def _ending(document: Mapping[str, object]) -> Json:
    """What the seal binds besides the log."""
    return {key: document.get(key) for key in _AT_THE_END}


def write_header(folder: Path, header: RunHeader, started_utc: str, end: RunEnd | None) -> str:
    """Write `run.yaml` so that at every moment it is whole: the old one or the new one; answers its genesis hash.
    Raises OSError.
    """
    document: dict[str, object] = {
        "schema": SCHEMA,
        "title": header.title,
        "who": {"user": _user(), "host": socket.gethostname(), "command": list(header.command_line)},
        "when": {"started_utc": started_utc, "ended_utc": wall_clock_utc() if end else None},
        "software": {
            "gimbal_hil": __version__,
            "python": platform.python_version(),
            "machine": f"{platform.system()} {platform.release()} {platform.machine()}",
        },
        "protocol": PROTOCOL_VERSION,
        "period_ns": header.period_ns,
        "lockstep": header.lockstep,
        "seed": header.seed,
        "axes": list(header.axes),
        "exit_status": _exit_status(end) if end else None,
        "log": dict(end.counts) if end else None,
        "configuration": dict(header.configuration),
        "model": dict(header.model),
    }
    document = _plain(document)
    document["hashes"] = {part: plain_hash(document[part]) for part in _HASHED} | _end_hashes(end)
    document["seal"] = sealed_with(end.last_block, _ending(document)) if end and end.last_block else None
    temporary = folder / f".{RUN_FILE}.{os.getpid()}"
    try:
        temporary.write_text(yaml_text(document), encoding="utf-8")
        temporary.replace(folder / RUN_FILE)
    except OSError:
        with contextlib.suppress(OSError):
            temporary.unlink(missing_ok=True)
        raise
    return genesis_of(document)


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


def _parse(path: Path, document: dict[str, object]) -> RunRecord:
    if document.get("schema") != SCHEMA:
        raise BadInputError(
            f"{path}: schema", f"is {document.get('schema')!r}", f"{SCHEMA}: this version reads no other"
        )
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
    # the first version did not say so
    protocol = _get(path, document, "protocol", int) if "protocol" in document else 1
    end = None
    if document.get("exit_status") is not None:
        status, log = _get(path, document, "exit_status", dict), _get(path, document, "log", dict)
        end = RunEnd(
            _get(path, status, "code", int, "exit_status."),
            _get(path, status, "reason", str, "exit_status."),
            {part: _get(path, log, part, int, "log.") for part in LOG_PARTS},
            {part: _get(path, hashes, part, str, "hashes.") for part in LOG_PARTS},
            _get(path, hashes, "last_block", str, "hashes.") if "last_block" in hashes else "",
            _get(path, status, "adjusted", dict, "exit_status.") if "adjusted" in status else {},
        )
    software = _get(path, document, "software", dict)
    seal = document.get("seal") or ""
    return RunRecord(
        header,
        who,
        str(when.get("started_utc")),
        when.get("ended_utc"),
        software,
        hashes,
        end,
        genesis_of(document),
        str(seal),
        sealed_with(end.last_block, _ending(document)) if end and end.last_block else "",
        {part: plain_hash(document.get(part)) for part in _HASHED},
        protocol,
    )


def _exit_status(end: RunEnd) -> Json:
    status: dict[str, object] = {"code": end.exit_code, "reason": end.reason}
    return status | ({"adjusted": end.adjusted} if end.adjusted else {})


def _end_hashes(end: RunEnd | None) -> dict[str, str]:
    return {} if end is None else dict(end.hashes) | ({"last_block": end.last_block} if end.last_block else {})


def _axes(path: Path, names: object) -> tuple[str, str]:
    if not isinstance(names, list) or len(names) != 2 or not all(isinstance(name, str) for name in names):
        raise BadInputError(f"{path}: axes", f"is {names!r}", "the names of two axes, the carrying one first")
    return names[0], names[1]


def _get(path: Path, table: Json, key: str, kind: type, prefix: str = "") -> Any:
    value = table.get(key)
    if not isinstance(value, kind) or (kind is int and isinstance(value, bool)):
        problem = f"is {value!r}" if key in table else "is missing"
        raise BadInputError(f"{path}: {prefix}{key}", problem, _KINDS[kind])
    return value


def _plain(content: Mapping[str, object]) -> Json:
    plain: dict[str, object] = json.loads(json.dumps(printable(content)))
    return plain


def _user() -> str:
    try:
        return getpass.getuser()
    except (KeyError, OSError):
        return str(os.getuid())
