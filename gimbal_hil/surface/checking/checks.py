"""Checks files with the loaders that all commands use, and reports every error in each."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TypeAlias

from firmware_protocol.errors import BadInputError, DamagedRunError, GimbalHilError, refused_below
from firmware_protocol.json_object import Json
from firmware_protocol.links import AdapterLinkConfig, require_known_interface
from gimbal_hil.data.containers import Contents, contents_of, guess, survey
from gimbal_hil.data.preflight import likely_units, preflight, questioned
from gimbal_hil.data.runs import damage_of, open_run
from gimbal_hil.data.signals import (
    ColumnMap,
    LogReading,
    contents_of_table,
    guessed_words,
    is_read_by,
    read_signals,
    words_by_motion,
)
from gimbal_hil.data.tables import RawColumns, read_table
from gimbal_hil.knowledge.experiments import embedded_model_of, load_plan
from gimbal_hil.loop.settings import DaemonSettings, EmbeddedAntenna, load_settings
from gimbal_hil.pages.report import counted
from gimbal_hil.surface.checking.kinds import FileKind, kind_of
from sim_backend.carrying import INNER, OUTER
from sim_backend.model import AntennaModel, load_model

#: stands for the axis of a stranger's columns where nobody has said its name
UNNAMED_AXIS = "AXIS"
_BY_MOTION = "  no name tells it, their motion does; other units than s, rad and N m are to be said, as 2:deg or 3:mNm"
#: keys of a plan's segment that hold a table and are no axis
_NO_AXES = ("guards", "meaning")
_AS_IT_IS = LogReading()
#: what says what a file holds: path, document, names of axes
_Look: TypeAlias = Callable[[Path, Json, tuple[str, ...]], "_Seen"]


@dataclass(frozen=True)
class _Seen:
    """Of a file in order: the same fields of `Checked`."""

    text: str
    moves: bool = False
    reads_as: tuple[str, ...] = ()
    is_strange: bool = False
    unmodelled: tuple[str, ...] = ()


@dataclass(frozen=True)
class Checked:
    """What was found out about one file: its kind, what it holds in one line, and everything that is wrong with it."""

    path: Path
    kind: FileKind
    text: str
    faults: tuple[GimbalHilError, ...] = ()
    #: whether an experiment in virtual time takes it: not a link to somewhere else, one axis, or axes nobody has
    moves: bool = False
    #: words for `--column` that would read it, where it has columns of somebody else
    reads_as: tuple[str, ...] = ()
    #: whether some of its columns have to be named before a command can read it
    is_strange: bool = False
    #: axes of a log of which no model is known
    unmodelled: tuple[str, ...] = ()

    def as_dict(self) -> Json:
        """For JSON."""
        return {
            "file": str(self.path),
            "kind": self.kind.value,
            "good": not self.faults,
            "text": self.text,
            **({"columns": list(self.reads_as)} if self.reads_as else {}),
            "faults": [
                {"where": fault.where, "problem": fault.problem, "expected": fault.expected}
                if isinstance(fault, BadInputError)
                else {"where": str(self.path), "problem": str(fault), "expected": ""}
                for fault in self.faults
            ],
        }


def check_files(paths: Sequence[Path], axes: Sequence[str] = (), reading: LogReading = _AS_IT_IS) -> list[Checked]:
    """Check each file; BadInputError only for one that is not there or of no kind that is known.

    Plans and tables call axes by names that they do not declare: those of `axes`, else those of a model or
    configuration among the files, else any. `reading` says how tables are read. With a model beside them, tables
    are asked what the commands that use them ask: rows that no joint can make, wrong units, signs and columns.
    """
    kinds = [kind_of(path) for path in paths]
    named = tuple(axes) or _declared(kinds)
    logs = _Logs(_model_among(paths, kinds, named), reading, [kind for kind, _ in kinds].count(FileKind.SIGNALS) == 1)
    looks = _LOOKS | {FileKind.SIGNALS: partial(_signals, logs=logs)}
    return [
        _checked(looks[kind], path, kind, document, named) for path, (kind, document) in zip(paths, kinds, strict=True)
    ]


def _model_among(
    paths: Sequence[Path], kinds: Sequence[tuple[FileKind, dict[str, object]]], axes: tuple[str, ...]
) -> AntennaModel | None:
    """The first file that is a sound model of these axes: it knows whether they turn and what a current makes."""
    for path, (kind, _) in zip(paths, kinds, strict=True):
        if kind is FileKind.MODEL:
            with suppress(GimbalHilError):
                model = load_model(path)
                if model.axes == axes:
                    return model
    return None


def _declared(kinds: Sequence[tuple[FileKind, dict[str, object]]]) -> tuple[str, ...]:
    for kind, document in kinds:
        section = document.get("axes")
        if kind in (FileKind.MODEL, FileKind.CONFIGURATION) and isinstance(section, dict):
            return _carrying_first(section)
    return ()


def _carrying_first(axes: Json) -> tuple[str, ...]:
    def is_carried(name: str) -> bool:
        return isinstance(axes[name], dict) and "parent" in axes[name]

    return tuple(sorted(axes, key=is_carried))


def _checked(look: _Look, path: Path, kind: FileKind, document: dict[str, object], axes: tuple[str, ...]) -> Checked:
    try:
        seen = look(path, document, axes)
        return Checked(path, kind, **vars(seen))
    except BadInputError as refusal:
        return Checked(path, kind, "", (_alone(refusal), *refusal.others) if refusal.others else (refusal,))
    except GimbalHilError as error:
        return Checked(path, kind, "", (error,))


def _alone(refusal: BadInputError) -> BadInputError:
    """The first of several without the words that count the others."""
    return BadInputError(refusal.where, refusal.problem.rpartition(" (and ")[0], refusal.expected)


def _configuration(path: Path, _document: dict[str, object], _axes: tuple[str, ...]) -> _Seen:
    from gimbal_hil.realtime.observing import observed_model

    settings = load_settings(path)
    with refused_below(str(path)):
        place, settings = _antenna_of(settings)
        observed_model(settings.with_model())
    virtual = isinstance(settings.link, EmbeddedAntenna)
    return _Seen(f"{settings.rate_hz:g} Hz, {place}, axes {' and '.join(settings.axis_names)}", virtual)


def _antenna_of(settings: DaemonSettings) -> tuple[str, DaemonSettings]:
    if isinstance(settings.link, EmbeddedAntenna):
        model, _ = embedded_model_of(settings)
        return f"the virtual antenna {model.name}", settings.for_axes(model.axes, model.where)
    require_known_interface(settings.link)
    if isinstance(settings.link, AdapterLinkConfig):
        return f"two {settings.link.drive} drives", settings
    return f"a {settings.link.kind} link", settings


def _model(path: Path, _document: dict[str, object], _axes: tuple[str, ...]) -> _Seen:
    model = load_model(path)
    effects = ", ".join(f"{entry.effect.name} on {entry.axis}" for entry in model.effects) or "no effects"
    return _Seen(f"{model.name}, {model.kind.value}, axes {' and '.join(model.axes)}, {effects}", len(model.axes) == 2)


def _plan(path: Path, document: dict[str, object], axes: tuple[str, ...]) -> _Seen:
    names = _two(axes or _named_in(document))
    plan = load_plan(path, names)
    # what only shows when the plan is made into what the host follows: shapes that are too long, targets that are none
    plan.host_segments(1000.0)
    said = f"{plan.name}, {counted(plan.laps * len(plan.segments), 'segment')}, {plan.longest_s:g} s at most"
    if axes:
        return _Seen(said, True)
    return _Seen(f"{said}; axes {' and '.join(names)}, which the antenna must have", names == (OUTER, INNER))


def _two(axes: Sequence[str]) -> tuple[str, str]:
    first, second = (*axes, *(name for name in (OUTER, INNER) if name not in axes))[:2]
    return first, second


def _named_in(document: dict[str, object]) -> tuple[str, ...]:
    """The tables in a plan's segments that are no key of a segment: its axes, in the order in which they appear."""
    segments = document.get("segments")
    names = [
        key
        for segment in (segments if isinstance(segments, list) else ())
        if isinstance(segment, dict)
        for key, value in segment.items()
        if isinstance(value, dict) and key not in _NO_AXES
    ]
    found = tuple(dict.fromkeys(names))
    return (OUTER, INNER) if set(found) <= {OUTER, INNER} or len(found) > 2 else found


@dataclass(frozen=True)
class _Logs:
    """How logs are read: with the model beside them, if any, which says what no joint of it can make, and whether there
    is only one of them.
    """

    model: AntennaModel | None
    reading: LogReading
    one: bool


def _signals(path: Path, _document: dict[str, object], axes: tuple[str, ...], logs: _Logs) -> _Seen:
    named, reading = axes or (UNNAMED_AXIS,), logs.reading
    columns = reading.columns
    contents = None if columns.sources else contents_of(path)
    if contents is not None and not _is_ours(contents, axes):
        words = guess(contents, named)
        whole = is_read_by(("time_s=", *words), named)
        words, open_words = _as_torques(words, logs.model)
        lines = survey(contents, words, whole) + open_words
        return _Seen("\n".join(lines), reads_as=words, is_strange=not whole)
    if contents is None and not columns.sources:
        raw = read_table(path)
        if _is_a_strangers(raw, axes):
            words = guessed_words(raw, named)
            moved = _by_motion(path, raw, named, logs.model) if not words else ()
            whole = is_read_by((*(("time_s=",) if reading.rate_hz else ()), *(words or moved)), named)
            words, open_words = _as_torques(words or moved, logs.model)
            lines = survey(contents_of_table(raw), words, whole) + open_words
            if moved:
                lines.append(_BY_MOTION)
            return _Seen("\n".join(lines), reads_as=words, is_strange=not whole)
        axes = axes or _axes_in(raw.values)
    axes = axes or _axes_in(columns.sources)
    if not axes:
        raise BadInputError(str(path), "axes are not known", "--axes NAME,NAME, or the model file beside it")
    resample, drop_invalid, rate_hz = reading.resample, reading.drop_invalid, reading.rate_hz
    table = read_signals(
        path, logs.model or axes, resample=resample, drop_invalid=drop_invalid, rate_hz=rate_hz, columns=columns
    )
    if logs.model is not None:
        (table,) = questioned(logs.model, (table,), reading.repair, among_others=not logs.one)
        preflight(logs.model, (table,))
    notes = "".join(f"; {note}" for note in table.notes)
    if logs.model is None:
        notes += "; its rows are questioned only with a model beside it"
    unmodelled = axes if logs.model is None and axes != (OUTER, INNER) else ()
    text = f"{len(table)} rows at {1.0 / table.period_s:g} Hz, axes {' and '.join(axes)}{notes}"
    return _Seen(text, unmodelled=unmodelled)


def _by_motion(path: Path, raw: RawColumns, axes: Sequence[str], model: AntennaModel | None) -> tuple[str, ...]:
    """Words for `--column` of the columns that move as position and torque of an axis do, in the units in which they
    fit its model.
    """
    words = words_by_motion(raw.values, axes[0]) if len(axes) == 1 else ()
    if words and model is not None:
        with suppress(GimbalHilError):
            units = likely_units(model, read_signals(path, model, columns=ColumnMap.of_words(words)))
            told = [(word, units.get(word.partition("=")[0])) for word in words]
            return tuple(f"{word}:{unit}" if unit else word for word, unit in told)
    return words


def _as_torques(words: Sequence[str], model: AntennaModel | None) -> tuple[tuple[str, ...], list[str]]:
    """The words with each current that the model makes no torque of as a torque, and what has to be put into them."""
    named, notes = list(words), []
    for place, word in enumerate(words):
        name, _, column = word.partition("=")
        axis, _, signal = name.rpartition(".")
        if model is None or signal != "current" or model.number(axis, "actuator.torque_constant"):
            continue
        named[place] = f"{axis}.torque={column}:KT*N m"
        notes.append(
            f"  {column} is a current, and the model does not say what torque it makes: put the N m of one ampere for "
            f"KT (8.27 / KV of a motor of KV rpm/V), or axes.{axis}.actuator.torque_constant into the model, as "
            f"gimbal-hil init --torque-constant {axis}=NUMBER does"
        )
    return tuple(named), notes


def _is_a_strangers(raw: RawColumns, axes: tuple[str, ...]) -> bool:
    """Whether a table has rows and none of the columns of a signals table."""
    ours = {"time_s", *(f"{axis}.{signal}" for axis in axes for signal in ("position", "torque", "current"))}
    named = ours & {*raw.values, *raw.doubts} if axes else {name for name in raw.values if name.endswith(".position")}
    return not named and any(len(values) for values in raw.values.values())


def _axes_in(names: Iterable[str]) -> tuple[str, ...]:
    """Axes of which columns of a signals table hold a position, in their order."""
    return tuple(name.removesuffix(".position") for name in names if name.endswith(".position"))


def _is_ours(contents: Contents, axes: tuple[str, ...]) -> bool:
    """Whether a container has the columns of a signals table under their names."""
    present = {name for group in contents.groups for name in group.columns}
    return bool(axes) and all(f"{axis}.position" in present for axis in axes)


def _run(path: Path, _document: dict[str, object], _axes: tuple[str, ...]) -> _Seen:
    run = open_run(path)
    damage = "; ".join(found.in_words() for found in damage_of(run))
    if damage:
        raise DamagedRunError(f"{path}: is not what was recorded: {damage}")
    header = run.record.header
    rate_hz, axes = 1e9 / header.period_ns, " and ".join(header.axes)
    return _Seen(f"{header.title or 'run'}, {len(run.ticks)} ticks at {rate_hz:g} Hz, axes {axes}")


_LOOKS: dict[FileKind, _Look] = {
    FileKind.CONFIGURATION: _configuration,
    FileKind.MODEL: _model,
    FileKind.PLAN: _plan,
    FileKind.RUN: _run,
}
