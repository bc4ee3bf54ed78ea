"""`gimbal-hil tune`: gains, observers, prefilters and feed-forward of a configuration for a model."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from firmware_protocol.places import require_new
from gimbal_hil.surface.cli.completion import model_names

if TYPE_CHECKING:
    from gimbal_hil.knowledge.tuning import Aim, LoopFigures, Tuning
    from gimbal_hil.loop.settings import DaemonSettings
    from sim_backend.model import AntennaModel


@dataclass(frozen=True)
class ReportOptions:
    """Whose model, and what page it ends with."""

    improved: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR", help="Folder of an improvement: its model is used; where there is none, improve runs first."
        ),
    ] = None
    report: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR", help="Page: before and after in the arena; with --improved also the causes of the gain."
        ),
    ] = None
    seeds: Annotated[int, typer.Option(help="Runs of each scenario in the report.", min=1)] = 2


def command(
    *,
    config: Annotated[Path, typer.Option(help="Configuration to tune; it stays as it is.")],
    model: Annotated[
        str | None,
        typer.Option(
            metavar="MODEL",
            autocompletion=model_names,
            help="Model file or shipped name; without it the one that the configuration names.",
        ),
    ] = None,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Tuned configuration; without it NAME.tuned.yaml beside it.")
    ] = None,
    margin: Annotated[
        float, typer.Option(help="Least disk margin of the loops; 0.4 is 1.5 in gain, 23 degrees in phase.")
    ] = 0.4,
    aim: Annotated[
        str, typer.Option("--for", metavar="AIM", help="pointing: gusts count first; tracking: friction; both.")
    ] = "tracking",
    page: ReportOptions,
    force: Annotated[bool, typer.Option("--force", help="Overwrite the tuned configuration.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the figures as one JSON object.")] = False,
) -> int:
    """Find the loops of least error that keep a disk margin on the antenna that a model describes; ends with 1 where
    none do.

    The tuned file differs in the keys that change; comments stay. Nothing is moved.
    """
    import json
    from dataclasses import asdict

    from firmware_protocol.errors import EXIT_DONE, EXIT_NO, BadInputError
    from gimbal_hil.knowledge.tuning import Aim, NoMarginError, assumed_numbers, caution, tuned
    from gimbal_hil.loop.settings import load_settings
    from gimbal_hil.surface.cli.following import after_tune
    from gimbal_hil.surface.cli.next_line import print_next
    from sim_backend.model import ModelKind, model_named

    _require_asked(margin, aim)
    path = out or config.with_name(f"{config.stem}.tuned.yaml")
    require_new(path.parent, force, path.name, instead="another --out")
    settings = load_settings(config)
    first = None
    if page.improved is not None:
        from gimbal_hil.surface.cli.tune_report import improved_in

        file, first = improved_in(page.improved, config, model)
        model = str(file)
    name = model or _named_in(settings)
    about = model_named(name)
    if page.report is not None and about.kind is not ModelKind.GIMBAL:
        raise BadInputError("--report", f"has no scenarios for a {about.kind.value} axis", "a gimbal")
    settings = settings.for_axes(about.axes, about.where)
    try:
        found = tuned(settings, about, _as_seen_from(path.parent, name), margin, Aim(aim))
    except NoMarginError as error:
        print(f"{error}: ask for less with --margin, or look at delay, gyro and modes in {name}")
        return EXIT_NO
    written = _write(config, path, found, settings)
    told = _reported(page, config, written, first, found, about, margin, Aim(aim))
    numbers = assumed_numbers(about)
    if as_json:
        assumed = [asdict(one) for one in numbers]
        print(json.dumps({"out": str(path), "model": name, **_as_dict(found), "assumed": assumed}))
    else:
        print("\n".join([*_lines(found, name, aim), *([caution(numbers)] if numbers else [])]))
        print(f"written: {path}")
        if told:
            print(f"\n{told}\nreport: {page.report}/report.html")
        print_next(after_tune(config, path, name, len(about.axes)))
    return EXIT_DONE


def _reported(
    page: ReportOptions,
    config: Path,
    written: DaemonSettings,
    first: AntennaModel | None,
    found: Tuning,
    model: AntennaModel,
    margin: float,
    aim: Aim,
) -> str:
    """The page where one is asked for, and its text for the terminal."""
    from gimbal_hil.loop.settings import load_settings
    from gimbal_hil.surface.cli.tune_report import TuningAsked, gain_report, report

    if page.report is None:
        return ""
    before = load_settings(config)
    if first is not None:
        return report(page.report, before, written, first, TuningAsked(margin, aim, page.seeds))
    return gain_report(page.report, before, written, found, model, page.seeds)


def _require_asked(margin: float, aim: str) -> None:
    """BadInputError for options that cannot be."""
    from firmware_protocol.errors import BadInputError
    from gimbal_hil.knowledge.tuning import Aim

    if not 0.0 < margin < 2.0:
        raise BadInputError("--margin", f"is {margin:g}", "above 0 and below 2")
    if aim not in tuple(Aim):
        raise BadInputError("--for", f"is {aim!r}", ", ".join(Aim))


def _named_in(settings: DaemonSettings) -> str:
    from firmware_protocol.errors import BadInputError

    name = settings.model_control.model if settings.model_control else settings.observed_model
    if name is None:
        raise BadInputError("--model", "is missing, and the configuration names no model", "a model file or name")
    return name


def _as_seen_from(folder: Path, name: str) -> str:
    """How a file in `folder` names a model."""
    import os

    is_file = name.endswith((".yaml", ".yml")) or "/" in name
    return os.path.relpath(Path(name).resolve(), folder.resolve()) if is_file else name


def _write(config: Path, path: Path, found: Tuning, settings: DaemonSettings) -> DaemonSettings:
    """Write the configuration with what changes, once it is checked; what was written."""
    from firmware_protocol.documents import yaml_edited, yaml_mapping
    from firmware_protocol.errors import BadInputError
    from gimbal_hil.loop.settings import load_settings, settings_from_document

    text = config.read_text(encoding="utf-8")
    before = load_settings(config)
    names = dict(zip(settings.axes, before.axes, strict=True))
    changes = {}
    for key, value in found.changes.items():
        words = key.split(".")
        if words[0] == "axes":
            words[1] = names[words[1]]
        changes[".".join(words)] = value
    edited = yaml_edited(text, changes, str(config))
    written = settings_from_document(yaml_mapping(edited, str(path), "a configuration"), str(path), path.parent)
    if written.link != before.link or written.observer != before.observer:
        raise BadInputError("--out", "is in another folder, and the configuration names files", f"{config.parent}")
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(edited, encoding="utf-8")
    return written


def _lines(found: Tuning, name: str, aim: str) -> list[str]:
    from gimbal_hil.knowledge.tuning import margins

    def line(what: str, figures: LoopFigures) -> str:
        if figures.margin == 0.0:
            return f"  {what:<16} not stable on this model"
        gain, phase = margins(figures.margin)
        wrong = "stable" if figures.stable_when_wrong else "not stable"
        return (
            f"  {what:<16} crosses at {figures.crossing_rad_s:.0f} rad/s, disk margin {figures.margin:.2f} "
            f"(gain {gain:.2f}, phase {phase:.0f} deg), error {1e6 * figures.error_rad:.1f} µrad rms, of it noise "
            f"{1e6 * figures.noise_rad:.2f}; {wrong} with the model 30 % off"
        )

    lines = [
        f"model {name}, for {aim}: loops of the least error under friction that changes as a random walk"
        f"{'' if aim == 'tracking' else ', gusts'}, sensor noise and drift of the navigation"
    ]
    for one in found.axes:
        lines += [f"{one.axis}:", line("before", one.before), line("cascade", one.cascade)]
        if one.observed is not None:
            lines.append(line("with observer", one.observed))
        for key, value in one.changes.items():
            lines.append(f"    {key.removeprefix(f'axes.{one.axis}.')}: {_shown(value)}")
    if "model_control" in found.changes:
        lines.append(f"model_control: {_shown(found.changes['model_control'])}")
    return lines + [f"{part} stays off: {why}" for part, why in found.left_off.items()]


def _shown(value: object) -> str:
    if isinstance(value, dict):
        return ", ".join(f"{key} {_shown(one)}" for key, one in value.items())
    if isinstance(value, bool):
        return "on" if value else "off"
    return f"{value:g}" if isinstance(value, float) else str(value)


def _as_dict(found: Tuning) -> dict[str, object]:
    from dataclasses import asdict

    return {
        "axes": {
            one.axis: {
                "before": asdict(one.before),
                "cascade": asdict(one.cascade),
                "observed": None if one.observed is None else asdict(one.observed),
            }
            for one in found.axes
        },
        "changes": dict(found.changes),
        "left_off": dict(found.left_off),
    }
