"""What two runs were set to otherwise: configuration, model, seed, software."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TypeAlias

from gimbal_hil.data.runs import RecordedRun
from gimbal_hil.pages.report import counted

#: (what, of the first run, of the second)
Rows: TypeAlias = tuple[tuple[str, str, str], ...]
_Effects: TypeAlias = dict[tuple[str, str, int], object]

ABSENT = "-"
#: key of the effects that only one of the models has
EFFECTS = "model.effects"
#: what says where a number comes from, and nothing of the antenna
_REMARKS = ("text", "source")


def keys_that_differ(first: RecordedRun, second: RecordedRun) -> Rows:
    """Every key as the files have it."""
    return _rows(_flat(_told(first)), _flat(_told(second)))


def differences(first: RecordedRun, second: RecordedRun) -> Rows:
    """What differs with numbers beside their units and without remarks; effects that only one model has in one row, and
    others by name and axis.
    """
    ours, theirs = (_effects_of(run.record.header.model) for run in (first, second))
    only = [[key for key in mine if key not in others] for mine, others in ((ours, theirs), (theirs, ours))]
    flat = []
    for run, effects in ((first, ours), (second, theirs)):
        model = dict(run.record.header.model) | {
            "effects": {_in_words(key): effects[key] for key in effects if key in ours and key in theirs}
        }
        flat.append(_flat(_without_remarks(_told(run) | {"model": model})))
    more = ((EFFECTS, _effects_in_words(only[0]), _effects_in_words(only[1])),) if any(only) else ()
    return more + _rows(flat[0], flat[1])


def _rows(ours: Mapping[str, str], theirs: Mapping[str, str]) -> Rows:
    keys = sorted(set(ours) | set(theirs))
    rows = ((key, ours.get(key, ABSENT), theirs.get(key, ABSENT)) for key in keys)
    return tuple(row for row in rows if row[1] != row[2])


def _effects_of(model: Mapping[str, object]) -> _Effects:
    """Effects of a model by name, axis, and which of the same it is."""
    found: _Effects = {}
    effects = model.get("effects")
    for effect in effects if isinstance(effects, list) else []:
        if isinstance(effect, Mapping):
            name, axis = str(effect.get("name")), str(effect.get("axis"))
            number = sum(key[:2] == (name, axis) for key in found)
            found[name, axis, number] = {key: effect[key] for key in effect if key not in ("name", "axis")}
    return found


def _in_words(key: tuple[str, str, int]) -> str:
    name, axis, number = key
    return f"{name} of {axis}" + (f" ({number + 1})" if number else "")


def _effects_in_words(keys: Sequence[tuple[str, str, int]]) -> str:
    axes: dict[str, list[str]] = {}
    for name, axis, _ in keys:
        axes.setdefault(name, []).append(axis)
    said = ", ".join(f"{name} ({', '.join(on)})" for name, on in axes.items())
    return f"{counted(len(keys), 'effect')} more: {said}" if said else ABSENT


def _without_remarks(content: object) -> object:
    """The same without what is said about numbers: a number is its value and unit."""
    if not isinstance(content, Mapping):
        return content
    value, unit = content.get("value"), content.get("unit", "1")
    if isinstance(value, int | float):
        return value if unit == "1" else f"{value:.6g} {unit}"
    return {key: _without_remarks(one) for key, one in content.items() if key not in _REMARKS}


def _told(run: RecordedRun) -> dict[str, object]:
    header = run.record.header
    return {
        "configuration": header.configuration,
        "model": header.model,
        "seed": header.seed,
        "lockstep": header.lockstep,
        "period_ns": header.period_ns,
        "axes": list(header.axes),
        "title": header.title,
        "software": run.record.software.get("gimbal_hil"),
    }


def _flat(content: object, prefix: str = "") -> dict[str, str]:
    """Every number and word by its dotted key; lists by their places."""
    if isinstance(content, Mapping) and content:
        pairs = content.items()
    elif isinstance(content, list) and any(isinstance(one, Mapping | list) for one in content):
        pairs = {str(place): one for place, one in enumerate(content)}.items()
    else:
        return {prefix: f"{content:.9g}" if isinstance(content, float) else str(content)}
    found: dict[str, str] = {}
    for key, value in pairs:
        found |= _flat(value, f"{prefix}.{key}" if prefix else str(key))
    return found
