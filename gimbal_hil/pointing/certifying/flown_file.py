"""The flights that are done, a JSON line for each, on disk as soon as they are flown: what `--resume` goes on from.

The first line is a digest of what was asked for. A flight is drawn by its seed alone, so flights of one task add up
whenever and in whatever order they were flown.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

from pydantic import Field

from firmware_protocol.documents import Strict, json_line, validated
from firmware_protocol.errors import BadInputError
from firmware_protocol.json_object import Json
from gimbal_hil.pointing.certifying.flight import ERROR_STEPS, FlightTask, FlownFlight

FLOWN_FILE = "flights.jsonl"
_TASK, _EXPECTED = "task", "a line as `point --certify` writes it"
_NotNegative = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]
_Count = Annotated[int, Field(ge=0)]


class _Line(Strict):
    """A `FlownFlight`; `acquired_s` is null where it never transmitted."""

    seed: int
    gust_m_s: _NotNegative
    bank_rad: float
    elevation_rad: float
    acquired_s: _NotNegative | None
    flown_s: _NotNegative
    transmitting_s: _NotNegative
    within_s: _NotNegative
    mutes: _Count
    excursions: _Count
    slowest_mute_s: _NotNegative
    worst_rad: _NotNegative
    silences: _Count
    histogram: Annotated[tuple[_NotNegative, ...], Field(min_length=ERROR_STEPS + 1, max_length=ERROR_STEPS + 1)]
    stops: tuple[str, ...]
    computed_s: _NotNegative

    def flight(self) -> FlownFlight:
        """As it was flown."""
        values = {name: getattr(self, name) for name in type(self).model_fields}
        return FlownFlight(**values | {"acquired_s": math.inf if self.acquired_s is None else self.acquired_s})


class FlownFile:
    """Flights of one task in a folder, kept as they are done."""

    def __init__(self, folder: Path, task: FlightTask, resume: bool) -> None:
        """Begin a new file, or read what is there; BadInputError where that is of another task or no such file."""
        self.path = folder / FLOWN_FILE
        self.kept: tuple[FlownFlight, ...] = ()
        if resume and self.path.exists():
            self.kept = _read(self.path, _digest(task))
            return
        folder.mkdir(parents=True, exist_ok=True)
        self.path.write_text(json.dumps({_TASK: _digest(task)}) + "\n", encoding="utf-8")

    def keep(self, flights: Sequence[FlownFlight]) -> None:
        """Add flights; they are on disk afterwards."""
        with self.path.open("a", encoding="utf-8") as file:
            file.writelines(json.dumps(_plain(one), allow_nan=False) + "\n" for one in flights)
            file.flush()
            os.fsync(file.fileno())


def _plain(one: FlownFlight) -> Json:
    return asdict(one) | {"acquired_s": one.acquired_s if math.isfinite(one.acquired_s) else None}


def _digest(task: FlightTask) -> str:
    """Of everything that a flight follows from beside its seed."""
    asked = {
        "settings": task.settings.model_dump(mode="json", by_alias=True),
        "model": task.model.document,
        "navigation": task.navigation.model_dump(mode="json", by_alias=True),
        "requirement": asdict(task.requirement),
        "duration_s": task.duration_s,
    }
    return hashlib.sha256(json.dumps(asked, sort_keys=True, default=str).encode()).hexdigest()


def _read(path: Path, digest: str) -> tuple[FlownFlight, ...]:
    """Whole lines of a file; one that a kill cut off at its end is left out, and cut off the file."""
    text = path.read_bytes()
    whole = text[: text.rfind(b"\n") + 1]
    lines = whole.decode("utf-8", errors="replace").splitlines()
    where = f"{path}: line 1"
    if not lines or json_line(lines[0], where, _EXPECTED).get(_TASK) != digest:
        raise BadInputError(
            where,
            "belongs to flights of another configuration, model, navigation or duration",
            "--resume with what was asked for then, or a new folder",
        )
    found = {}
    for number, line in enumerate(lines[1:], start=2):
        where = f"{path}: line {number}"
        one = validated(_Line, json_line(line, where, _EXPECTED), where).flight()
        found[one.seed] = one
    if len(whole) < len(text):
        path.write_bytes(whole)
    return tuple(found.values())
