"""Which columns of a stranger's file are likely to be position and torque of which axis, with their units."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gimbal_hil.data.tables import unit_in_name, unit_size

#: words in a name -> points for a signal; the more special the word, the more it counts
_WORDS: Mapping[str, Mapping[str, int]] = {
    "position": {
        "position": 4,
        "pos": 4,
        "angle": 4,
        "theta": 4,
        "q": 3,
        "enc": 3,
        "encoder": 3,
        "qm": 3,
        "y": 3,
        "winkel": 4,
        "lage": 3,
    },
    "torque": {
        "torque": 5,
        "tau": 5,
        "effort": 5,
        "force": 4,
        "u": 3,
        "load": 3,
        "trq": 5,
        "m": 1,
        "moment": 4,
        "drehmoment": 5,
    },
    "current": {"current": 4, "iq": 5, "cur": 4, "amps": 4, "amp": 3, "curr": 4, "strom": 4},
}
#: words that say that it is another thing, and what is asked of a loop rather than measured
_AGAINST = frozenset(
    [
        "velocity",
        "vel",
        "speed",
        "rate",
        "acc",
        "acceleration",
        "error",
        "err",
        "temp",
        "id",
        "volt",
        "voltage",
        "mode",
        "fault",
        "index",
        "limit",
    ]
)
_WANTED = frozenset(
    ["ref", "set", "setpoint", "cmd", "command", "commanded", "target", "goal", "desired", "des", "action"]
)
#: signals -> SI units that they may be in
_UNITS: Mapping[str, tuple[str, ...]] = {"position": ("rad", "m"), "torque": ("N m", "N"), "current": ("A",)}
_SI = tuple(si for units in _UNITS.values() for si in units)
_OTHER_UNIT = re.compile(r"/s|rpm|dps|°c|degc|volt|^v$|hz", re.IGNORECASE)
_LEAST = 3


@dataclass(frozen=True)
class Found:
    """A column of a file, the unit that the file states for it, and whether its numbers ever change."""

    column: str
    unit: str = ""
    moves: bool = True

    @classmethod
    def of(cls, column: str, unit: str, values: NDArray[np.float64]) -> Found:
        """With what its values (n,) do."""
        good = values[np.isfinite(values)]
        return cls(column, unit, bool(len(good) and np.ptp(good) > 0.0))


def guessed(columns: Sequence[Found], axes: Sequence[str], taken: Sequence[str] = ()) -> tuple[str, ...]:
    """Words for `--column`, position and torque (else current) of each axis, as far as names and units tell.

    A column whose name has an axis' name in it goes to that axis, others in their order, those that never change last.
    """
    words: list[str] = []
    for signals in (("position",), ("torque", "current")):
        best = _best(columns, signals)
        for place, axis in enumerate(axes):
            if f"{axis}.{signals[0]}" in taken:
                continue
            own = [one for one in best if axis.lower() in one[1].column.lower()]
            # of /joint_states.position[base] and [joint] only the second is of an axis that is called joint
            own.sort(key=lambda one: f"[{axis.lower()}]" not in one[1].column.lower())
            rest = [one for one in best if not any(name.lower() in one[1].column.lower() for name in axes)]
            rest.sort(key=lambda one: not one[1].moves)
            for signal, found, unit in own[:1] or rest[place : place + 1]:
                unit = unit or (_unit_of_drive(found.column, columns) if signal == "position" else "")
                words.append(f"{axis}.{signal}={found.column}" + (f":{unit}" if unit else ""))
    return tuple(words)


def command_line(words: Sequence[str]) -> str:
    """The option as a shell takes it."""
    quoted = [f'"{word}"' if re.search(r"[^\w.=:/@%+,-]", word) else word for word in words]
    return "--column " + " ".join(quoted)


def _best(columns: Sequence[Found], signals: Sequence[str]) -> list[tuple[str, Found, str]]:
    """Columns by how likely they are one of the signals, the likeliest first."""
    scored = []
    for place, found in enumerate(columns):
        for signal in signals:
            points, unit = _points(found, signal)
            if points >= _LEAST:
                scored.append((-points, place, signal, found, unit))
    scored.sort(key=lambda one: one[:2])
    most = -scored[0][0] if scored else 0
    return [(signal, found, unit) for points, _, signal, found, unit in scored if -points == most]


def _points(found: Found, signal: str) -> tuple[int, str]:
    tokens = list(_tokens(found.column))
    if found.unit and _OTHER_UNIT.search(found.unit):
        return 0, ""
    points = max((_WORDS[signal].get(token, 0) for token in tokens), default=0)
    stated = found.unit.strip() or next((unit for si in _SI if (unit := unit_in_name(found.column, si))), "")
    fits = any(unit_size(stated, si) is not None for si in _UNITS[signal]) if stated else False
    of_another = not fits and any(unit_size(stated, si) is not None for units in _UNITS.values() for si in units)
    points += 3 if fits else -2 if of_another else 0
    points -= 4 if _AGAINST & set(tokens) else 0
    points -= 2 if _WANTED & set(tokens) and signal == "position" else 0
    is_si = fits and any(unit_size(stated, si) == (1.0, 0.0) for si in _UNITS[signal])
    return points, "" if is_si else stated if fits else "" if of_another else found.unit


def _unit_of_drive(column: str, columns: Sequence[Found]) -> str:
    """Turns where a name without a unit is of a drive that logs them: ODrive's pos_estimate, and the POSITION of
    moteus beside its MODE.
    """
    prefix, _, last = column.rpartition(".")
    beside = {one.column.rpartition(".")[2] for one in columns if one.column.rpartition(".")[0] == prefix}
    return "turn" if last == "pos_estimate" or (last == "POSITION" and "MODE" in beside) else ""


def _tokens(name: str) -> Iterator[str]:
    """Words of a name: parted by marks, digits and changes to capitals."""
    apart = re.sub(r"([a-z])([A-Z])", r"\1 \2", name)
    yield from (word.lower() for word in re.split(r"[^A-Za-z°]+", apart) if word)
