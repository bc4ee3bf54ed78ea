"""`gimbal-hil campaign`: an experiment on many virtual antennas, each drawn from what is not known of its numbers."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gimbal_hil.surface.cli.completion import model_names

if TYPE_CHECKING:
    from gimbal_hil.proof.campaign import Campaign

#: pieces of work under way at once on a cluster, whose workers nobody counts here
_AHEAD_ON_A_CLUSTER = 64


@dataclass(frozen=True)
class CampaignOptions:
    """What is done on each antenna, and how they differ."""

    spread: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NUMBER[=AMOUNT]",
            help="A number that differs, as friction.coulomb=10% (one standard deviation; of one axis with its name "
            "before); without an amount by its stated uncertainty; all: every number that has one. Repeatable.",
        ),
    ] = None
    config: Annotated[Path | None, typer.Option(help="Configuration file; without it the shipped virtual antenna.")] = (
        None
    )
    model: Annotated[
        str | None,
        typer.Option(metavar="MODEL", autocompletion=model_names, help="Nominal model, not the configuration's."),
    ] = None
    axis: Annotated[list[str] | None, typer.Option(help="Only this axis; may be repeated.")] = None
    short: Annotated[bool, typer.Option("--short", help="The short variant of the sequence.")] = False
    seed: Annotated[int, typer.Option(help="Of what is drawn, noise included.", min=0)] = 0


@dataclass(frozen=True)
class CampaignEffort:
    """Where the antennas are simulated."""

    workers: Annotated[int, typer.Option(help="Processes.", min=1)] = 1
    dask: Annotated[str | None, typer.Option(metavar="ADDRESS", help="On a Dask cluster instead.")] = None

    @property
    def ahead(self) -> int:
        """Pieces of work under way at once."""
        return _AHEAD_ON_A_CLUSTER if self.dask else 2 * self.workers


def command(
    name: Annotated[str, typer.Argument(help="A plan file or a sequence, as of gimbal-hil experiment.")],
    out: Annotated[Path, typer.Option(help="Folder for antennas.csv, campaign.json and report.html.")],
    *,
    antennas: Annotated[int, typer.Option(help="How many, besides the model's own (antenna 0).", min=1)] = 100,
    asked: CampaignOptions,
    effort: CampaignEffort,
    resume: Annotated[
        bool, typer.Option("--resume", help="Go on in --out; --antennas may be more than before.")
    ] = False,
    force: Annotated[bool, typer.Option("--force", help="Overwrite what is in the folder.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as one JSON object.")] = False,
) -> int:
    """Run an experiment on many virtual antennas: one row an antenna, the same however many processes there are."""
    import json
    import sys

    from firmware_protocol.errors import EXIT_INTERRUPTED
    from gimbal_hil.knowledge.executor import open_executor
    from gimbal_hil.pages.report import Callout
    from gimbal_hil.proof.campaign import campaign_page, run_campaign
    from gimbal_hil.surface.cli.following import after_campaign
    from gimbal_hil.surface.cli.next_line import print_next
    from gimbal_hil.surface.cli.progress import ProgressBar

    campaign = _campaign(name, asked)
    try:
        with open_executor(effort.workers, effort.dask) as executor, ProgressBar(not as_json) as bar:
            bar.begin("campaign", antennas + 1, 0.0)
            done = run_campaign(
                campaign,
                antennas,
                out,
                executor,
                ahead=effort.ahead,
                resume=resume,
                force=force,
                tell=lambda count, now: bar.at(f"antenna {count}", now),
            )
    except KeyboardInterrupt:
        print("interrupted; the same command with --resume goes on", file=sys.stderr)
        return EXIT_INTERRUPTED
    spread = ", ".join(asked.spread or ["all"])
    where = f"{done.antennas - 1} antennas about {campaign.model.name}, spread {spread}, seed {asked.seed}"
    found = campaign_page(done.table, campaign.experiment.text, where)
    page = found.write(out / "report.html")
    if as_json:
        print(json.dumps({"antennas": done.antennas - 1, "table": str(done.table), "report": str(page)}))
    else:
        print(f"{campaign.experiment.text}: {where}")
        print("\n".join(f"  {block.text}\n  {block.more}" for block in found.blocks if isinstance(block, Callout)))
        print(f"  table   {done.table}\n  report  {page}")
        print_next(after_campaign(name, done.antennas - 1, out, {**vars(asked), **vars(effort)}))
    return 0


def _campaign(name: str, asked: CampaignOptions) -> Campaign:
    """What is asked for; BadInputError where it makes no sense."""
    from firmware_protocol.errors import BadInputError
    from gimbal_hil.knowledge.experiments import antenna_for, embedded_model_of
    from gimbal_hil.knowledge.experiments.sequences import SequenceOptions, breakaway_torques, build_experiment
    from gimbal_hil.loop.settings import load_settings, shipped_settings
    from gimbal_hil.proof.campaign import Campaign, spreads_of
    from gimbal_hil.surface.cli.experiment import axes_named
    from sim_backend.model import model_named

    settings = load_settings(asked.config) if asked.config else shipped_settings()
    nominal = model_named(asked.model) if asked.model is not None else embedded_model_of(settings)[0]
    names = settings.for_axes(nominal.axes, nominal.where).axis_names
    options = SequenceOptions(
        settings.rate_hz, axes_named(asked.axis, names), asked.short, None, breakaway_torques(nominal), None, names
    )
    experiment = build_experiment(name, options)
    if not any(step.measured for step in experiment.steps):
        raise BadInputError(name, "measures nothing", "an experiment with a step to be measured")
    settings, nominal = antenna_for(experiment, settings, nominal)
    return Campaign(experiment, settings, nominal, spreads_of(nominal, asked.spread or ["all"]), asked.seed)
