"""What one mostly runs next: every command ends with one whole command line, made here.

Each function answers that line for one command; `print_next` is the one place that says it.
"""

from __future__ import annotations

import os
import re
import shlex
from collections.abc import Collection, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from firmware_protocol.json_object import Json
from gimbal_hil.surface.cli.origin import LogOrigin, option_in, origin_of

if TYPE_CHECKING:
    from gimbal_hil.surface.checking import Checked

#: word in the regime that holds most of the gap -> sequence that dwells there
_DWELLS = (
    ("temperature", "warm_and_cool"),
    ("warmer", "warm_and_cool"),
    ("position", "full_turn"),
    ("rate <", "creep"),
    ("revers", "reversals"),
    ("rate", "plateaus"),
)
#: flights of a certificate
_CERTIFICATE = 10_000
_COMMAND_IN_WORDS = re.compile(r"\(gimbal-hil experiment (\w+)\)")


def print_next(line: str) -> None:
    """Say what to run next."""
    print(f"next: {line}")


def command_line(*words: object, **options: object) -> str:
    """A command line that a shell takes: words, then options that are neither None nor empty; several values repeat,
    and True is an option without a value.
    """
    found = [str(word) for word in words]
    for name, value in options.items():
        values = value if isinstance(value, list | tuple) else [] if value in (None, "", False) else [value]
        for one in values:
            found += [f"--{name.replace('_', '-')}", *([] if one is True else [str(one)])]
    return shlex.join(["gimbal-hil", *found])


def _new(path: Path) -> Path:
    """This path, or the next number of it that is not there yet: no command writes over what stands there."""
    tried, number = path, 1
    while tried.exists():
        number += 1
        tried = path.with_name(f"{path.stem}_{number}{path.suffix}")
    return tried


def _experiment(name: str, origin: LogOrigin, model: object, out: Path, short: bool = False) -> str:
    """An experiment on the antenna of `origin`; where that is on a link, the daemon that drives it comes first."""
    if origin.config is not None and not _is_embedded(origin.config):
        return command_line("daemon", config=origin.config)
    words = ("experiment", name, *(["--short"] if short else []))
    return command_line(*words, config=origin.config, run=origin.run, model=model, out=_new(out))


def _with_model(model: object, origin: LogOrigin, folder: Path) -> str:
    """The first use of a model that explains its logs: a step beside it, or gains for it where the antenna is on a link
    that no daemon drives any more.
    """
    if origin.config is not None and not _is_embedded(origin.config):
        return command_line(
            "tune", config=origin.config, model=model, out=_new(origin.config.with_suffix(".tuned.yaml"))
        )
    return _experiment("step", origin, model, folder / "step_with_model")


def _is_embedded(config: Path) -> bool:
    from firmware_protocol.errors import BadInputError
    from gimbal_hil.loop.settings import EmbeddedAntenna, load_settings

    with suppress(BadInputError):
        return isinstance(load_settings(config).link, EmbeddedAntenna)
    return True


def after_demo() -> str:
    """An antenna of one's own."""
    return command_line("init", "mine")


def after_export_model(model: Path) -> str:
    """What a run with this model would show, so that the other simulator's log can be asked the same."""
    return command_line("testable", model=model)


def after_drive_tables(model: Path, config: Path, out: Path, rehearsed: bool) -> str:
    """What the tables are worth on simulated drives; after that the antenna that has them."""
    if rehearsed:
        return command_line("daemon", config=config)
    return command_line("drive-tables", model, "--rehearse", config=config, out=_new(out))


def after_check(
    given: Sequence[Path],
    checked: Sequence[Checked],
    columns: Sequence[str] = (),
    repairs: Mapping[str, object] | None = None,
) -> str:
    """Where something is wrong the same check again, else the first use of what was checked; for columns of a joint
    that nobody has named, a model of it. `repairs` are options without which the logs are not read.
    """
    from gimbal_hil.surface.checking import UNNAMED_AXIS

    repairs = repairs or {}
    if any(one.faults for one in checked):
        return command_line("check", *given, column=columns, **repairs)
    first: dict[str, Path] = {}
    # what an experiment in virtual time takes comes before what it does not
    for one in sorted(checked, key=lambda one: not one.moves):
        first.setdefault(one.kind.value, one.path)
    moved = [one.path for one in checked if one.moves]
    if any(word.startswith(f"{UNNAMED_AXIS}.") for word in columns):
        # the columns are known, and nothing yet of the joint that they belong to
        return command_line("init", _new(Path("mine")), "--yes", kind="rotary", axes="joint")
    configuration, model, plan = first.get("configuration"), first.get("model"), first.get("plan")
    nobodys = next((one.unmodelled for one in checked if one.unmodelled), ())
    if nobodys and model is None:
        kind = "rotary" if len(nobodys) == 1 else "gimbal"
        return command_line("init", _new(Path("mine")), "--yes", kind=kind, axes=",".join(nobodys))
    tables = [one.path for one in checked if one.kind.value == "signals table"]
    if model is not None and len(tables) > 1 and "run folder" not in first:
        # the last one judges what the others suggest, as everywhere
        files = {"measured": tables[:-1], "holdout": tables[-1:]}
        return command_line("discrepancy", model=model, **files, column=columns, out=_new(Path("verdict")), **repairs)
    for kind in ("run folder", "signals table"):
        if kind in first:
            return command_line("identify", first[kind], model=model, column=columns, out="identified", **repairs)
    if configuration is not None and configuration not in moved:
        return command_line("doctor", config=configuration)
    if configuration is None and model is not None and model not in moved:
        return command_line("effects")
    if configuration is None:
        # loops that fit this model, or have the axes of this plan, are those beside it
        alone = model or plan
        if alone is not None and _has_configuration(alone.parent):
            return command_line("check", alone.parent)
        if model is None and plan is not None and plan not in moved:
            return after_demo()
    return command_line("experiment", plan or "step", config=configuration, model=None if configuration else model)


def _has_configuration(folder: Path) -> bool:
    """Whether one of the YAML files there is a configuration."""
    from firmware_protocol.errors import BadInputError
    from gimbal_hil.surface.checking import FileKind, kind_of

    for path in sorted(folder.glob("*.yaml")):
        with suppress(BadInputError):
            if kind_of(path)[0] is FileKind.CONFIGURATION:
                return True
    return False


def after_experiment(
    name: str, folder: Path, config: Path | None, model: str | None, run: Path | None, short: bool = False
) -> str:
    """From friction to an identification; from any other to the two logs of a search, then to that."""
    beside = folder.parent
    known = model or _model_in(config or (None if run is None else _configuration_of(run)))
    if name in ("sliding", "presliding"):
        return command_line("identify", folder, model=known, out=_new(beside / "identified"))
    if name == "survey_holdout" and (survey := _survey_in(beside)) is not None:
        return command_line("discrepancy", model=known, measured=survey, holdout=folder, out=_new(beside / "verdict"))
    log = "survey_holdout" if name == "survey" else "survey"
    return _experiment(log, LogOrigin(config, run), model, beside / log, short)


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


def _survey_in(folder: Path) -> Path | None:
    """The newest run of a survey there."""
    from firmware_protocol.errors import BadInputError
    from gimbal_hil.data.runs import read_header

    found = []
    for place in folder.iterdir() if folder.is_dir() else ():
        with suppress(BadInputError):
            record = read_header(place)
            found += [(record.started_utc, place)] if record.header.title == "survey" else []
    return max(found)[1] if found else None


def after_daemon(run: Path, exit_code: int) -> str:
    """A look at what happened where a safety stop ended it, else the proof that the log is what it says."""
    return command_line("runs", "show", run) if exit_code == 3 else command_line("replay", run)


def after_conformance(config: Path | None, evidence: Path | None) -> str:
    """What was recorded of the first requirement that failed; else the daemon on the same antenna."""
    return (
        command_line("daemon", config=config, duration=10)
        if evidence is None
        else command_line("runs", "show", evidence)
    )


def after_plant(config: Path | None, kind: str, path: str) -> str:
    """The daemon for the antenna that is served, or the files of one: the daemon's link stands in its configuration."""
    if config is not None:
        return command_line("daemon", config=config)
    return command_line("init", "mine", "--yes", link=f"{kind}:{path}")


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
    """A log to judge the identified model on: a survey, or on a single axis the logs at hand. Where positions of some
    axes seem to be `in_turns`, the same again with that said, from the model that was `given`. `repairs` are options
    without which the logs are not read.
    """
    repairs = repairs or {}
    model = out / "model.yaml"
    if in_turns:
        said = columns_in_turns(columns, in_turns)
        return command_line("identify", *runs, model=given, column=said, out=_new(out), **repairs)
    if axes == 1:
        logs = [str(run) for run in runs]
        out = _new(out.parent / "verdict")
        return command_line("discrepancy", model=model, measured=logs, column=columns, out=out, **repairs)
    if not found:
        return _experiment("sliding", origin_of(runs), None, runs[0].parent / "sliding_again")
    return _experiment("survey", origin_of(runs), model, out.parent / "survey")


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
    """The run that decides what is open, `made` for it where that is there, else the first use of the model as it is
    now; where nothing can be judged because numbers (names of effects) are `assumed`, friction or the model file; on a
    single axis, which no experiment moves, what the catalogue says of the cause.
    """
    from gimbal_hil.knowledge.discrepancy import Kind

    if axes == 1:
        names = [entry["name"] for entry in (*verdict["effects"], *verdict.get("alternatives", []))]
        return command_line("effects", *names[:1])
    found = Kind(verdict["verdict"])
    recalibrated = out / "model_recalibrated.yaml" if verdict.get("recalibrated") else None
    if found in (Kind.AMBIGUOUS, Kind.CANNOT_JUDGE) and made is not None and made.exists():
        return _experiment(str(made), origin_of(logs), model, out.parent / made.stem)
    if found in (Kind.AMBIGUOUS, Kind.UNEXPLAINED):
        name = _deciding(verdict)
        return _experiment(name, origin_of(logs), model, out.parent / name)
    if found is Kind.CANNOT_JUDGE:
        if assumed and model is not None and not FRICTIONS & set(assumed):
            # motion is there; what is missing is how well somebody knows these numbers
            return command_line("check", recalibrated or model)
        name = "sliding" if assumed else "survey"
        return _experiment(name, origin_of(logs), model, out.parent / name)
    use = out / "model.yaml" if found in (Kind.NAMED, Kind.DESCRIBED) else recalibrated or model
    return _with_model(use, origin_of(logs), out.parent)


def after_joint(joint: str, inertia: float, out: Path) -> str:
    """A model of that joint alone."""
    folder = _new(out.with_suffix(""))
    return command_line("init", folder, kind="rotary", axes=joint, inertia=f"{joint}={inertia:.4g}")


def after_changed(document: Json, out: Path) -> str:
    """What the catalogue says of the cause that changed, else what the model of the machine before holds."""
    names = [entry["name"] for entry in document["effects"]]
    return command_line("effects", *names[:1]) if names else command_line("check", out / "model_before.yaml")


def _deciding(verdict: Json) -> str:
    """The sequence that the verdict proposes, else the one that dwells where most of the gap is."""
    planned = verdict.get("next_experiment") or {}
    told = _COMMAND_IN_WORDS.search(str(planned.get("plan", "")))
    if told is not None:
        return told.group(1)
    regimes = " ".join(str(where["regime"]) for where in verdict.get("where", [])[:1])
    return next((name for word, name in _DWELLS if word in regimes), "reversals")


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
    return command_line("improve", config=config, run=run, model=model, out=_new(out.with_name(f"{out.name}_on")))


def after_tune(config: Path, tuned: Path, model: str, axes: int) -> str:
    """Both configurations beside each other on the antenna that the model describes; for one axis the file."""
    if axes < 2:
        return command_line("check", tuned)
    return command_line("bench", "pointing", controller=[str(config), str(tuned)], antenna=model, scenario="aircraft")


def after_replay(run: Path, identical: bool) -> str:
    """The run for other tools; where the replay differs, what the run says of itself."""
    if identical:
        return command_line("export", run, format="csv", out=_new(Path(f"{run.name or 'run'}.csv")))
    return command_line("runs", "show", run)


def after_export(run: Path, out: Path, is_table: bool, axes: Sequence[str]) -> str:
    """What reads a table of these axes; for frames, what the run holds."""
    return command_line("check", out, axes=",".join(axes)) if is_table else command_line("runs", "show", run)


def after_effects(shown: str | None, sequence: str | None) -> str:
    """One effect in full, or the run that shows it."""
    if shown is None:
        return command_line("effects", "cogging")
    return command_line("experiment", sequence or "survey")


def after_point(folder: Path, run: Path | None) -> str:
    """The proof that the log is what it says; a daemon's goes on, and is looked at."""
    return command_line("replay", folder) if run is None else command_line("watch", run)


def after_certificate(flights: int, folder: Path, config: Path | None, asked: Mapping[str, object]) -> str:
    """Ten times as many flights, with those that were flown, up to what a certificate has; then whether this machine
    can hold the rate.
    """
    if flights < _CERTIFICATE:
        more = min(10 * flights, _CERTIFICATE)
        return command_line("point", "--certify", more, "--resume", **asked, out=folder)
    return command_line("doctor", config=config)


def after_stow(run: Path) -> str:
    """The daemon is not needed any more."""
    return command_line("shut-down", run=run)


def after_doctor(config: Path | None, holds: bool, drives_of_others: bool = False) -> str:
    """The daemon, in virtual time where this machine cannot hold real time; drives of another make have clocks of their
    own, so for them it is looked again.
    """
    if drives_of_others and not holds:
        return command_line("doctor", config=config)
    return command_line("daemon", *([] if holds else ["--lockstep"]), config=config, duration=10)
