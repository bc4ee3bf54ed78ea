"""`gimbal-hil improve`: experiment, diagnose and correct until the model is at the noise floor or has to give up."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def command(
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for the runs, a report a round, model.yaml and improve.json.")],
    config: Annotated[Path | None, typer.Option(help="Configuration that names the antenna; without it the shipped virtual one.")] = None,
    model: Annotated[Path | None, typer.Option(help="Model to start from; without it the shipped thesis model.")] = None,
    rounds: Annotated[int, typer.Option(help="Rounds at most.", min=1)] = 4,
    budget: Annotated[float, typer.Option(help="Antenna time at most, s.", min=1.0)] = 600.0,
    short: Annotated[bool, typer.Option("--short", help="Short survey motions.")] = False,
    workers: Annotated[int, typer.Option(help="Processes that score candidates.", min=1)] = 2,
    dask: Annotated[str | None, typer.Option(metavar="ADDRESS", help="Score candidates on a Dask cluster instead.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as one JSON object.")] = False,
    force: Annotated[bool, typer.Option("--force", help="Overwrite what is in the folder.")] = False,
) -> int:
    """Run experiments on the antenna itself until the model is at the noise floor, or say what is left; 1 when it is not reached."""
    import json

    from firmware_protocol.errors import EXIT_DONE, EXIT_NO, BadInputError
    from gimbal_hil.cli.progress import ProgressBar
    from gimbal_hil.improvement import Ending, improve
    from gimbal_hil.settings import load_settings, shipped_settings
    from sim_backend.model import load_model, shipped_model

    if (out / "improve.json").exists() and not force:
        raise BadInputError(str(out / "improve.json"), "already exists", "a new folder, or --force to overwrite it")
    settings = load_settings(config) if config else shipped_settings()
    start = load_model(model) if model else shipped_model()
    with ProgressBar(not as_json) as progress:
        say = (lambda line: None) if as_json else print
        done = improve(
            settings, start, out, rounds=rounds, budget_s=budget, short=short, workers=workers, dask=dask, progress=progress, say=say
        )
    record = {"ending": done.ending.name.lower(), "text": done.ending.value, "antenna_s": done.antenna_s, "rounds": list(done.verdicts)}
    (out / "improve.json").write_text(json.dumps(record, indent=2) + "\n", encoding="utf-8")
    (out / "model.yaml").write_text(done.model.to_yaml(), encoding="utf-8")
    print(json.dumps(record) if as_json else f"{done.ending.value}; {done.antenna_s:.0f} s of antenna time; model: {out / 'model.yaml'}")
    return EXIT_DONE if done.ending is Ending.AT_THE_FLOOR else EXIT_NO
