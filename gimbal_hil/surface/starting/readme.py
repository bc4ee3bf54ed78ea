"""The page of next commands that `init` leaves beside the files."""

from __future__ import annotations

from pathlib import Path

from gimbal_hil.surface.starting.description import ASSUMED, STATED, AntennaDescription
from sim_backend.model import ModelKind


def first_commands(antenna: AntennaDescription, folder: Path) -> list[tuple[str, str]]:
    """(what it is for, command), in the order in which one runs them."""
    model = f"--model {folder}/model.yaml"
    if antenna.kind is not ModelKind.GIMBAL:
        return [
            ("check the files after a change", f"gimbal-hil check {folder}"),
            ("friction from logs of your own", f"gimbal-hil identify LOG.csv {model} --out {folder}/friction"),
            (
                "what the model lacks, from two logs of your own",
                f"gimbal-hil discrepancy {model} --measured LOG.csv --holdout OTHER.csv --out {folder}/verdict",
            ),
        ]
    virtual = f"--config {folder}/{'antenna' if antenna.link.is_virtual else 'rehearsal'}.yaml"
    commands = [
        ("check the files after a change", f"gimbal-hil check {folder}"),
        ("steps of both axes", f"gimbal-hil experiment step {virtual} --out {folder}/runs/step"),
        ("your own plan", f"gimbal-hil experiment {folder}/plan.yaml {virtual} --out {folder}/runs/plan"),
        ("friction, which is assumed so far", f"gimbal-hil experiment sliding {virtual} --out {folder}/runs/sliding"),
        (
            "a model with it",
            f"gimbal-hil identify {folder}/runs/sliding {model} --out {folder}/friction",
        ),
        ("two logs to look for what the model lacks",
         f"gimbal-hil experiment survey {virtual} --out {folder}/runs/survey"),
        ("the second, to judge on", f"gimbal-hil experiment survey_holdout {virtual} --out {folder}/runs/holdout"),
        (
            "what the model lacks",
            f"gimbal-hil discrepancy --model {folder}/friction/model.yaml --measured {folder}/runs/survey "
            f"--holdout {folder}/runs/holdout --out {folder}/verdict",
        ),
    ]  # fmt: skip
    return commands


def first_command(antenna: AntennaDescription, folder: Path) -> str:
    """What one runs right after `init`."""
    return first_commands(antenna, folder)[1][1]


def link_commands(antenna: AntennaDescription, folder: Path) -> list[tuple[str, str]]:
    """The same for the antenna behind the link; none where it is virtual."""
    if antenna.link.is_virtual or antenna.kind is not ModelKind.GIMBAL:
        return []
    real = f"--config {folder}/antenna.yaml"
    plant = f"gimbal-hil plant {real} --model {folder}/model.yaml"
    can_be_served = antenna.link.word in ("unix", "serial", "slcan") or antenna.link.section.get("interface") == "unix"
    what = "simulated drives" if antenna.link.is_drives else "a virtual antenna"
    serve = [(f"{what} at the other end, in another terminal", plant)] if can_be_served else []
    run = f"{folder}/runs/daemon"
    return [
        *serve,
        ("does the antenna answer, can this machine hold the rate", f"gimbal-hil doctor {real}"),
        ("control it", f"gimbal-hil daemon {real} --out {run}"),
        (
            "an experiment through that daemon, from another terminal",
            f"gimbal-hil experiment step --run {run} --model {folder}/model.yaml --out {folder}/runs/real_step",
        ),
    ]


def readme_text(antenna: AntennaDescription, folder: Path) -> str:
    """The whole page."""
    place = Path(folder)
    names = " and ".join(axis.name for axis in antenna.axes)
    lines = [
        f"# {antenna.name}",
        "",
        f"Written by `gimbal-hil init`: a {antenna.kind.value} with the axes {names}, link: {antenna.link.word}.",
        "",
        "| file | holds |",
        "|---|---|",
        "| `model.yaml` | masses, friction, sensors; nobody has told or measured what says `assumed` |",
    ]
    if antenna.kind is ModelKind.GIMBAL:
        where = "on the virtual antenna" if antenna.link.is_virtual else "of the antenna behind the link"
        lines.append(f"| `antenna.yaml` | loops, limits and link {where} |")
        if not antenna.link.is_virtual:
            lines.append("| `rehearsal.yaml` | the same loops and limits on the virtual antenna of `model.yaml` |")
        lines.append("| `plan.yaml` | a first experiment of your own |")
    else:
        way = "tilt from the vertical" if antenna.kind is ModelKind.ROTARY else "slope"
        source = STATED if antenna.tilt_told else ASSUMED
        lies = f"The axis has a {way} of {antenna.tilt_deg:g} degrees ({source})"
        lines += ["", f"{lies}, by which a weight acts (`incline_sine` is its sine); `init --tilt` says another."]
    lines += ["", "## First, without hardware" if not antenna.link.is_virtual else "## Next", ""]
    lines += _listed(first_commands(antenna, place))
    real = link_commands(antenna, place)
    if real:
        lines += ["", "## Then, on the link", "", *_listed(real)]
    if antenna.link.is_simulated:
        ticks, window, rate_hz = 100, 250, antenna.rate_hz
        lines += [
            "",
            f"The other end of this link is a process, so stalls of this machine are survived: {ticks / rate_hz:g} s "
            f"without feedback (`lost_ticks`: {ticks}), {window / rate_hz:g} s without a set-point (`window_ticks`: "
            f"{window}). For hardware write 5 and 20: within these times the last torque acts on.",
        ]
    return "\n".join(lines) + "\n"


def _listed(commands: list[tuple[str, str]]) -> list[str]:
    return ["```sh", *(line for text, command in commands for line in (f"# {text}", command)), "```"]
