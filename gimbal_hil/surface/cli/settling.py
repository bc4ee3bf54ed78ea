"""`gimbal-hil discrepancy --settle`: the plan of a motion that settles what a verdict leaves open."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from gimbal_hil.loop.settings import DaemonSettings
    from gimbal_hil.surface.library import Finding

SETTLE_FILE = "settle.yaml"


def limits_in(logs: Sequence[Path]) -> DaemonSettings:
    """The configuration that the first run among the logs was recorded with: loops and limits of the antenna.

    BadInputError where no log is a run: a table does not say what its antenna may do.
    """
    from firmware_protocol.errors import BadInputError
    from gimbal_hil.data.runs import RUN_FILE, read_header
    from gimbal_hil.loop.settings import settings_from_document

    folder = next((log for log in logs if (log / RUN_FILE).exists()), None)
    if folder is None:
        expected = "a run folder among the logs, which says the limits of its antenna"
        raise BadInputError("--settle", "no log is a run", expected)
    header = read_header(folder).header
    where = f"{folder / RUN_FILE}: configuration"
    return settings_from_document(dict(header.configuration), where).for_axes(header.axes, str(folder))


def write_settling(
    path: Path, finding: Finding, settings: DaemonSettings, workers: int, tell: Callable[[str], None]
) -> str:
    """The plan in a file, of a motion that settles an ambiguous verdict or shows what the logs said nothing of; answers
    what to say of it.
    """
    from gimbal_hil.knowledge.discrepancy import Kind
    from gimbal_hil.knowledge.executor import open_executor
    from gimbal_hil.knowledge.improvement import settling_run, showing_run

    if finding.kind is Kind.CANNOT_JUDGE:
        with open_executor(workers) as executor:
            showing = showing_run(finding.result, settings, path, executor, tell)
        if showing is None:
            return "  no motion inside the limits of the antenna shows any of it"
        worked_out = {*showing.shows, *showing.not_shown}
        allowed = [label for label in finding.result.hidden if label not in worked_out]
        reasons = (
            (showing.not_shown, "which no motion inside the limits shows beside the rest"),
            (allowed, "of which the model file itself allows half or twice"),
        )
        stays = "".join(f"; it does not show {_listed(labels)}, {why}" for labels, why in reasons if labels)
        seconds = showing.option.duration_s
        return f"  a motion that shows it: {path}, {seconds:.0f} s; run it, its log is the --holdout{stays}"
    with open_executor(workers) as executor:
        found = settling_run(finding.result, settings, path, executor, tell)
    if found is None:
        return "no motion of the antenna's own would settle it"
    pair, made = found
    # as `improve` does: two causes are told apart by what is fitted, a cause from chance by what is held out
    log = "--holdout" if pair.against_chance else "--measured"
    worth = f"{made.expected:.3g} squared floors expected in {made.duration_s:.0f} s"
    return f"to settle it: {path}, {worth}; give its log as a further {log}"


def _listed(labels: Sequence[tuple[str, str]]) -> str:
    return ", ".join(f"{name} on {axis}" for name, axis in labels)


__all__ = ["SETTLE_FILE", "limits_in", "write_settling"]
