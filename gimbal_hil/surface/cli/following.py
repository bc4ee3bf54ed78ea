"""What one mostly runs next: every command ends with one whole command line, made here.

Each function answers that line for one command; those of logs and models are in `following_logs`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from gimbal_hil.surface.cli.next_line import command_line, free_path

if TYPE_CHECKING:
    from gimbal_hil.surface.checking import Checked

#: what `init` writes beside the configuration of an antenna on a link
REHEARSAL_FILE = "rehearsal.yaml"
#: flights of a certificate
_CERTIFICATE = 10_000
#: antennas of a campaign: fifty of them are beyond a quantile of a twentieth
_MANY_ANTENNAS = 1000
#: pairs of a bench after which noise is no reason any more
_MANY_PAIRS = 27


def after_demo() -> str:
    """An antenna of one's own."""
    return command_line("init", "mine")


def after_export_model(model: Path, axes: int) -> str:
    """What a run with this model would show, so that the other simulator's log can be asked the same; one axis alone is
    not rehearsed.
    """
    if axes == 1:
        return command_line("check", model)
    return command_line("testable", plan="survey", model=model)


def after_drive_tables(model: Path, config: Path, out: Path, rehearsed: bool) -> str:
    """What the tables are worth on simulated drives; after that the antenna that has them."""
    if rehearsed:
        return command_line("daemon", config=config)
    return command_line("drive-tables", model, "--rehearse", config=config, out=free_path(out))


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
        return command_line("init", free_path(Path("mine")), "--yes", kind="rotary", axes="joint")
    configuration, model, plan = first.get("configuration"), first.get("model"), first.get("plan")
    nobodys = next((one.unmodelled for one in checked if one.unmodelled), ())
    if nobodys and model is None:
        kind = "rotary" if len(nobodys) == 1 else "gimbal"
        return command_line("init", free_path(Path("mine")), "--yes", kind=kind, axes=",".join(nobodys))
    tables = [one.path for one in checked if one.kind.value == "signals table"]
    if model is not None and len(tables) > 1 and "run folder" not in first:
        # the last one judges what the others suggest, as everywhere
        files = {"measured": tables[:-1], "holdout": tables[-1:]}
        return command_line(
            "discrepancy", model=model, **files, column=columns, out=free_path(Path("verdict")), **repairs
        )
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


def after_joint(joint: str, inertia: float, out: Path) -> str:
    """A model of that joint alone."""
    folder = free_path(out.with_suffix(""))
    return command_line("init", folder, kind="rotary", axes=joint, inertia=f"{joint}={inertia:.4g}")


def after_tune(config: Path, tuned: Path, model: str, axes: int) -> str:
    """Both configurations beside each other on the antenna that the model describes; for one axis the file."""
    if axes < 2:
        return command_line("check", tuned)
    return command_line("bench", "pointing", controller=[str(config), str(tuned)], antenna=model, scenario="aircraft")


def after_replay(run: Path, identical: bool) -> str:
    """The run for other tools; where the replay differs, what the run says of itself."""
    if identical:
        return command_line("export", run, format="csv", out=free_path(Path(f"{run.name or 'run'}.csv")))
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


def after_campaign(name: str, antennas: int, out: Path, asked: Mapping[str, object]) -> str:
    """Ten times as many antennas that differ as those do, in the same folder, up to what a quantile of a twentieth
    needs; then the experiment on the nominal one.
    """
    if antennas < _MANY_ANTENNAS:
        more = min(10 * antennas, _MANY_ANTENNAS)
        return command_line("campaign", name, antennas=more, **asked, out=out, resume=True)
    nominal = {key: asked.get(key) for key in ("config", "model")}
    return command_line("experiment", name, **nominal, out=free_path(Path("runs") / Path(name).stem))


def after_bench(missed: bool, closer: str, config: Path | None) -> str:
    """What looks `closer` at a target that was missed; else whether this machine can hold the rate."""
    return closer if missed and closer else command_line("doctor", config=config)


def closer_to_speed(repeats: int, out: Path | None) -> str:
    """More pairs, whose page keeps them beside later ones, tell a slow function from a busy machine; after those
    whether deadlines are held.
    """
    if repeats < _MANY_PAIRS:
        # the history lies beside the page that the next one takes the place of
        kept = {"out": out or free_path(Path("bench")), "force": out is not None}
        return command_line("bench", "speed", repeats=3 * repeats, **kept)
    return command_line("bench", "realtime")


def closer_to_faults(firmware: str) -> str:
    """Which requirement the firmware does not keep: one that keeps all leaves the host."""
    return command_line("conformance", link=firmware)


def closer_to_soak(link: str | None) -> str:
    """Whether that link holds the rate where processes met over it; in lockstep each fault by itself, since a soak is
    many of them at once.
    """
    return command_line("bench", "faults") if link is None else command_line("bench", "realtime", link=link)


def closer_to_trip(controller: str, antenna: str, scenario: str) -> str:
    """Loops of that configuration that keep a margin on that antenna; of a controller that is no file the run that
    tripped, by itself.
    """
    if Path(controller).is_file():
        tuned = free_path(Path(controller).with_suffix(".tuned.yaml"))
        return command_line("tune", config=controller, model=antenna, out=tuned)
    words = {"controller": controller, "antenna": antenna, "scenario": scenario}
    return command_line("bench", "pointing", **words, seeds=1, out=free_path(Path("arena")))


def after_stow(run: Path) -> str:
    """The daemon is not needed any more."""
    return command_line("shut-down", run=run)


def after_doctor(config: Path | None, holds: bool, answers: bool = True, drives_of_others: bool = False) -> str:
    """The daemon, in virtual time where this machine cannot hold real time. Where the antenna does not answer, the
    rehearsal beside its configuration, or another look; drives of another make have clocks of their own, so for them it
    is looked again.
    """
    if drives_of_others and not (holds and answers):
        return command_line("doctor", config=config)
    if not answers and config is not None:
        rehearsal = config.with_name(REHEARSAL_FILE)
        if rehearsal.exists():
            return command_line("experiment", "step", config=rehearsal, out=free_path(config.parent / "runs" / "step"))
        return command_line("doctor", config=config)
    return command_line("daemon", *([] if holds else ["--lockstep"]), config=config, duration=10)
