"""What one mostly runs next where logs are recorded and searched: the antenna of the logs moves again, and the model
that is known of it goes along.
"""

from __future__ import annotations

import os
import re
from collections.abc import Collection, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from firmware_protocol.json_object import Json
from gimbal_hil.surface.cli.next_line import command_line, free_path
from gimbal_hil.surface.cli.origin import LogOrigin, option_in, origin_of

if TYPE_CHECKING:
    from gimbal_hil.surface.cli.changed import ComparedLogs
    from gimbal_hil.surface.cli.log_options import LogOptions, SearchOptions

#: word in the regime that holds most of the gap -> sequence that dwells there
_DWELLS = (
    ("temperature", "warm_and_cool"),
    ("warmer", "warm_and_cool"),
    ("position", "full_turn"),
    ("rate <", "creep"),
    ("revers", "reversals"),
    ("rate", "plateaus"),
)
_COMMAND_IN_WORDS = re.compile(r"\(gimbal-hil experiment (\w+)\)")


def _experiment(name: str, origin: LogOrigin, known: object, out: Path, short: bool = False) -> str:
    """An experiment on the antenna of `origin`, `known` being the model that is asked about it; where that is on a
    link, the daemon that drives it comes first, and where nothing here moves it, what the experiment would show.
    """
    if origin.elsewhere:
        return command_line("testable", plan=name, model=known)
    if origin.config is not None and not _is_embedded(origin.config):
        return command_line("daemon", config=origin.config)
    words = ("experiment", name, *(["--short"] if short else []))
    return command_line(
        *words, config=origin.config, run=origin.run, model=origin.model, known=known, out=free_path(out)
    )


def _with_model(model: object, origin: LogOrigin, folder: Path) -> str:
    """The first use of a model that explains its logs: a step beside it where a daemon runs, gains for it where there
    is a configuration, else other simulators.
    """
    if origin.run is not None:
        return _experiment("step", origin, model, folder / "step_with_model")
    if origin.config is not None:
        return command_line(
            "tune", config=origin.config, model=model, out=free_path(origin.config.with_suffix(".tuned.yaml"))
        )
    if model is None:
        # the shipped model explains the shipped antenna, and has no file
        return command_line("init", "mine")
    return command_line("export-model", model, to="mjcf", out=free_path(folder / "model.xml"))


def _is_embedded(config: Path) -> bool:
    from firmware_protocol.errors import BadInputError
    from gimbal_hil.loop.settings import EmbeddedAntenna, load_settings

    with suppress(BadInputError):
        return isinstance(load_settings(config).link, EmbeddedAntenna)
    return True


def after_experiment(name: str, folder: Path, origin: LogOrigin, known: str | None = None, short: bool = False) -> str:
    """From friction to an identification; from any other to the two logs of a search, then to that, with the log that
    was recorded after them to settle it. `known` is the model that is asked about the antenna, which is not the antenna
    itself.
    """
    beside = folder.parent
    about = known or _model_of(origin)
    if name in ("sliding", "presliding"):
        return command_line("identify", folder, model=about, out=free_path(beside / "identified"))
    survey, holdout = (folder if name == log else _newest(log, beside, folder) for log in _SEARCHED)
    if survey is not None and holdout is not None:
        more = [folder] if name not in ("step", *_SEARCHED) and _has_rate_of(folder, survey) else []
        return _search(about, [survey, *more], holdout)
    log = _SEARCHED[0] if survey is None else _SEARCHED[1]
    return _experiment(log, origin, known, beside / log, short)


#: sequences whose logs a search takes: one to look into, one to judge on
_SEARCHED = ("survey", "survey_holdout")


def _search(model: object, measured: Sequence[Path], holdout: Path) -> str:
    return command_line(
        "discrepancy", model=model, measured=list(measured), holdout=holdout, out=free_path(holdout.parent / "verdict")
    )


def _model_of(origin: LogOrigin) -> str | None:
    """What is known of an antenna before anything was measured: the model that its configuration names; of a virtual
    one the shipped model, or where that has other axes the one that it is made of.
    """
    from firmware_protocol.errors import BadInputError
    from sim_backend.model import model_named, shipped_model

    config = origin.config or (None if origin.run is None else _configuration_of(origin.run))
    if origin.model is None or config is not None:
        return _model_in(config)
    with suppress(BadInputError):
        if model_named(origin.model).axes == shipped_model().axes:
            return None
    return origin.model


def _configuration_of(run: Path) -> Path | None:
    """The configuration file that a daemon was started with."""
    from firmware_protocol.errors import BadInputError
    from gimbal_hil.data.runs import read_header

    with suppress(BadInputError):
        return option_in(read_header(run).who.get("command", ()), "--config")
    return None


def _model_in(config: Path | None) -> str | None:
    """The model that a configuration names, of its virtual antenna or beside a real one."""
    from firmware_protocol.errors import BadInputError
    from gimbal_hil.loop.settings import EmbeddedAntenna, load_settings

    if config is None:
        return None
    try:
        settings = load_settings(config)
    except BadInputError:
        return None
    link = settings.link
    model = link.embedded.model if isinstance(link, EmbeddedAntenna) else settings.observer.model
    return os.path.relpath(model) if model and Path(model).is_relative_to(Path.cwd()) else model


def _newest(log: str, folder: Path, like: Path) -> Path | None:
    """The newest run of a sequence there that was recorded on the antenna of the run `like`."""
    from firmware_protocol.errors import BadInputError
    from gimbal_hil.data.runs import read_header

    same = _antenna(like)
    found = []
    for place in folder.iterdir() if folder.is_dir() else ():
        with suppress(BadInputError):
            record = read_header(place)
            if record.header.title == log and same in (None, _antenna(place)):
                found.append((record.started_utc, place))
    return max(found)[1] if found else None


def _antenna(run: Path) -> object:
    """What tells the antenna of a run from others; None where it is no run."""
    from firmware_protocol.errors import BadInputError
    from gimbal_hil.data.runs import read_header

    with suppress(BadInputError):
        header = read_header(run).header
        return header.axes, header.model, header.configuration.get("link")
    return None


def _has_rate_of(run: Path, other: Path) -> bool:
    """Whether two runs have rows at the same rate, and can be searched together."""
    from firmware_protocol.errors import BadInputError
    from gimbal_hil.data.runs import read_header

    with suppress(BadInputError):
        one, two = (read_header(place) for place in (run, other))
        return one.every_ticks * one.header.period_ns == two.every_ticks * two.header.period_ns
    return False


def after_identify(
    out: Path,
    runs: Sequence[Path],
    axes: int,
    found: bool,
    columns: Sequence[str] = (),
    in_turns: Collection[str] = (),
    given: str | None = None,
    repairs: Mapping[str, object] | None = None,
) -> str:
    """What the identified model lacks, in a survey: the search where its logs are there, else the next of them; on a
    single axis, or where nothing here moves the antenna, the logs at hand. Where positions of some
    axes seem to be `in_turns`, the same again with that said, from the model that was `given`. `repairs` are options
    without which the logs are not read.
    """
    repairs = repairs or {}
    model = out / "model.yaml"
    if in_turns:
        said = columns_in_turns(columns, in_turns)
        return command_line("identify", *runs, model=given, column=said, out=free_path(out), **repairs)
    origin = origin_of(runs)
    if axes == 1 or (found and origin.elsewhere):
        logs = [str(run) for run in runs]
        out = free_path(out.parent / "verdict")
        return command_line("discrepancy", model=model, measured=logs, column=columns, out=out, **repairs)
    beside = runs[0].parent
    if not found:
        return _experiment("sliding", origin, given, beside / "sliding_again")
    survey, holdout = (_newest(log, beside, runs[0]) for log in _SEARCHED)
    if survey is not None and holdout is not None:
        return _search(model, [survey], holdout)
    log = _SEARCHED[0] if survey is None else _SEARCHED[1]
    return _experiment(log, origin, model, beside / log)


#: what a position that seems to be in turns may have been said to be in
_ANGLES = ("rad", "deg")


def columns_in_turns(columns: Sequence[str], axes: Collection[str]) -> list[str]:
    """Words for `--column` with the positions of these axes in turns."""
    names = [f"{axis}.position" for axis in axes]
    said = [word for word in columns if word.partition("=")[0] not in names]
    own = {word.partition("=")[0]: word.partition("=")[2] for word in columns}
    for name in names:
        source = own.get(name, name)
        column, colon, unit = source.rpartition(":")
        # a colon may belong to the column's own name
        is_unit = bool(colon) and unit.removeprefix("-") in _ANGLES
        mirrored = "-" if unit.startswith("-") else ""
        said.append(f"{name}={column}:{mirrored}turn" if is_unit else f"{name}={source}:turn")
    return said


#: what the experiment `sliding` measures
FRICTIONS = {"coulomb", "viscous", "stribeck"}


def after_discrepancy(
    verdict: Json,
    model: str | None,
    axes: int,
    out: Path,
    logs: Sequence[Path] = (),
    made: Path | None = None,
    assumed: Collection[str] = (),
) -> str:
    """The command that the verdict has; else the run that decides what is open, `made` for it where that is there, or
    the first use of the model as it is now; where nothing can be judged because numbers (names of effects) are
    `assumed`, friction or the model file; on a single axis, which no experiment moves, what the catalogue says of the
    cause.
    """
    from gimbal_hil.knowledge.discrepancy import Kind

    if command := (verdict.get("next_experiment") or {}).get("command"):
        return str(command)
    found = Kind(verdict["verdict"])
    recalibrated = out / "model_recalibrated.yaml" if verdict.get("recalibrated") else None
    use = out / "model.yaml" if found in (Kind.NAMED, Kind.DESCRIBED) else recalibrated or model
    if axes == 1:
        names = [entry["name"] for entry in (*verdict["effects"], *verdict.get("alternatives", []))]
        is_open = found in (Kind.AMBIGUOUS, Kind.UNEXPLAINED)
        return command_line("effects", *names[:1]) if names or is_open else command_line("check", use)
    if found in (Kind.AMBIGUOUS, Kind.CANNOT_JUDGE) and made is not None and made.exists():
        return _experiment(str(made), origin_of(logs), model, out.parent / made.stem)
    if found in (Kind.AMBIGUOUS, Kind.UNEXPLAINED):
        name = _deciding(verdict, logs)
        return _experiment(name, origin_of(logs), model, out.parent / name)
    if found is Kind.CANNOT_JUDGE:
        if assumed and model is not None and not FRICTIONS & set(assumed):
            # motion is there; what is missing is how well somebody knows these numbers
            return command_line("check", recalibrated or model)
        name = "sliding" if assumed else "survey"
        return _experiment(name, origin_of(logs), model, out.parent / name)
    return _with_model(use, origin_of(logs), out.parent)


def after_changed(document: Json, asked: ComparedLogs, reading: LogOptions, search: SearchOptions, axes: int) -> str:
    """What the catalogue says of the cause that changed, else what the model of the machine before holds. Where nothing
    has a name: the same with all effects, then what the machine of the logs after lacks; where nothing can be judged, a
    survey, or the logs before on a single axis and where nothing here moves the antenna.
    """
    from gimbal_hil.knowledge.change import ChangeKind

    out, read = asked.out, {"column": reading.column, **reading.repairs}
    names, kind = [entry["name"] for entry in document["effects"]], ChangeKind(document["verdict"])
    if names:
        return command_line("effects", *names[:1])
    if kind is ChangeKind.NO_CHANGE:
        return command_line("check", out / "model_before.yaml")
    if search.limited:
        whole = free_path(out.with_name(f"{out.name}_of_all"))
        logs = {"before": asked.before, "after": asked.after}
        return command_line("changed", model=asked.model, **logs, **read, **search.of_all, out=whole)
    verdict = free_path(out.with_name("verdict"))
    if kind is ChangeKind.AMBIGUOUS:
        return command_line("discrepancy", model=out / "model_before.yaml", measured=asked.after, **read, out=verdict)
    origin = origin_of(asked.after)
    if axes == 1 or origin.elsewhere:
        return command_line("discrepancy", model=asked.model, measured=asked.before, **read, out=verdict)
    return _experiment("survey", origin, asked.model, out.with_name("survey"))


def after_compare(first: Path, second: Path, out: Path, sound: bool) -> str:
    """Which number or effect it is that differs; of two motions of one antenna what a model lacks for them. Where a run
    is not what was recorded, or has other axes, what that run was.
    """
    from firmware_protocol.errors import BadInputError
    from gimbal_hil.data.runs import read_header

    if not sound or read_header(first).header.axes != read_header(second).header.axes:
        return command_line("runs", "show", second)
    model = None
    with suppress(BadInputError):
        model = _model_of(origin_of([first]))
    if [_title(log) for log in (first, second)] == list(_SEARCHED) and _antenna(first) == _antenna(second):
        return command_line(
            "discrepancy", model=model, measured=first, holdout=second, out=free_path(out.with_name("verdict"))
        )
    return command_line("changed", model=model, before=first, after=second, out=free_path(out.with_name("changed")))


def _deciding(verdict: Json, logs: Sequence[Path]) -> str:
    """The sequence that the verdict proposes, else the one that dwells where most of the gap is; of those the first
    that the logs have not got already.
    """
    planned = verdict.get("next_experiment") or {}
    told = _COMMAND_IN_WORDS.search(str(planned.get("plan", "")))
    regimes = " ".join(str(where["regime"]) for where in verdict.get("where", [])[:1])
    proposed = [told.group(1)] if told is not None else []
    proposed += [name for word, name in _DWELLS if word in regimes]
    # where nothing is known of the place, speeds over a decade are what the verdict proposes
    rest = ("reversals", "plateaus") if regimes else ("plateaus", "reversals")
    proposed += [name for name in (*rest, "full_turn", "creep") if name not in proposed]
    recorded = {_title(log) for log in logs}
    return next((name for name in proposed if name not in recorded), proposed[0])


def _title(log: Path) -> str:
    """The sequence that a run is of; none for a table."""
    from firmware_protocol.errors import BadInputError
    from gimbal_hil.data.runs import read_header

    with suppress(BadInputError):
        return read_header(log).header.title
    return ""


def after_testable(plan: str, model: str | None, config: Path | None, short: bool) -> str:
    """That run: on the antenna of the configuration, else on the one that the model describes."""
    origin = LogOrigin(config, model=model if config is None else None)
    return _experiment(plan, origin, model if config is not None else None, Path("runs") / Path(plan).stem, short)


def after_improve(
    out: Path, config: Path | None, at_the_floor: bool, run: Path | None = None, hidden: Collection[str] = ()
) -> str:
    """The first use of the improved model, the run that shows what its logs would not have (`hidden`: names of
    numbers), or another improvement from where this one ended.
    """
    model = out / "model.yaml"
    if at_the_floor and hidden:
        name = "sliding" if FRICTIONS & set(hidden) else "survey"
        return _experiment(name, LogOrigin(None if run else config, run), model, out / name)
    if at_the_floor:
        return _with_model(model, LogOrigin(None if run else config, run), out)
    if not model.exists():
        return command_line("doctor", config=config)
    return command_line("improve", config=config, run=run, model=model, out=free_path(out.with_name(f"{out.name}_on")))
