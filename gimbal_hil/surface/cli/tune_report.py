"""From an improved model to the report of what tuning with it gave, and which named part paid for it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from gimbal_hil.knowledge.tuning import Aim, Tuning
    from gimbal_hil.loop.settings import DaemonSettings
    from sim_backend.model import AntennaModel

#: scenarios of the report: a direction and joints on a moving base, reversals, slow tracking
_SCENARIOS = ("direction held in moderate", "table 3.1, case 5", "5 deg/s at 1 Hz", "0.02 rad at 0.2 Hz", "0.003 rad/s")
MODEL_FILE = "model.yaml"


def improved_in(folder: Path, config: Path, start: str | None) -> tuple[Path, AntennaModel]:
    """The improved model's file in the folder of an improvement, and the model that it began with; without the folder
    `improve --short` makes it first.
    """
    from firmware_protocol.errors import BadInputError
    from gimbal_hil.knowledge.improvement import JOURNAL_FILE, Journal, Started
    from gimbal_hil.surface.cli.app import run
    from sim_backend.model import model_from_document

    if not folder.exists():
        words = ["--out", str(folder), "--config", str(config), "--short"]
        run("improve", words + (["--model", start] if start else []))
    journal = folder / JOURNAL_FILE
    if not (folder / MODEL_FILE).exists() or not journal.exists():
        raise BadInputError(
            "--improved", f"{folder} holds no {MODEL_FILE} and {JOURNAL_FILE}", "the --out folder of gimbal-hil improve"
        )
    first = Journal(journal, resume=True)
    try:
        began = first.entries[0]
    finally:
        first.close()
    if not isinstance(began, Started):
        raise BadInputError(
            str(journal), "has no entry for the start of the improvement", "the --out folder of gimbal-hil improve"
        )
    return folder / MODEL_FILE, model_from_document(began.session["model"], f"{journal}: model")


def gain_report(
    out: Path, before: DaemonSettings, after: DaemonSettings, found: Tuning, model: AntennaModel, seeds: int
) -> str:
    """Before and after in the arena on the configuration's antenna (the model, where that is a real one), and the page;
    the text for the terminal.
    """
    from gimbal_hil.knowledge.tuning import assumed_numbers
    from gimbal_hil.loop.settings import EmbeddedAntenna
    from gimbal_hil.pages.report import Page
    from gimbal_hil.pointing.arena import chosen, gained_blocks, gained_text, shipped_scenarios, what_tuning_gave

    assert after.model_control is not None, "a tuned gimbal has it"
    antenna = before.link.embedded.model if isinstance(before.link, EmbeddedAntenna) else after.model_control.model
    scenarios = [chosen(shipped_scenarios(), words)[0] for words in _SCENARIOS]
    ran = what_tuning_gave(scenarios, antenna, before, after, seeds)
    cautions = [one.text for one in assumed_numbers(model)]
    out.mkdir(parents=True, exist_ok=True)
    Page("Tuning", "What it gave to the pointing", gained_blocks(ran, found, cautions)).write(out / "report.html")
    return gained_text(ran)


@dataclass(frozen=True)
class TuningAsked:
    """What the loops were tuned for, with the improved model and so with the first one."""

    margin: float
    aim: Aim
    seeds: int


def report(out: Path, before: DaemonSettings, after: DaemonSettings, first: AntennaModel, asked: TuningAsked) -> str:
    """Run the arena on the configuration's antenna (the improved model, where that is a real one) and write the page;
    the text for the terminal.
    """
    from gimbal_hil.knowledge.tuning import tuned
    from gimbal_hil.loop.settings import EmbeddedAntenna, with_changes
    from gimbal_hil.pages.report import Page
    from gimbal_hil.pointing.arena import (
        BEFORE,
        FIRST,
        IMPROVED,
        changed_parts,
        chosen,
        paid_blocks,
        paid_text,
        shipped_scenarios,
        what_paid,
    )
    from sim_backend.model import model_named

    assert after.model_control is not None, "a tuned gimbal has it"
    improved = model_named(after.model_control.model)
    antenna = before.link.embedded.model if isinstance(before.link, EmbeddedAntenna) else after.model_control.model
    models = out / "models"
    models.mkdir(parents=True, exist_ok=True)
    (models / "first.yaml").write_text(first.to_yaml(), encoding="utf-8")
    with_first = with_changes(before, tuned(before, first, str(models / "first.yaml"), asked.margin, asked.aim).changes)
    paid = what_paid(
        [chosen(shipped_scenarios(), words)[0] for words in _SCENARIOS],
        antenna,
        {BEFORE: before, FIRST: with_first, IMPROVED: after},
        changed_parts(first, improved),
        models,
        asked.seeds,
    )
    Page("Tuning", "What the improved model gains in pointing", paid_blocks(paid)).write(out / "report.html")
    return paid_text(paid)
