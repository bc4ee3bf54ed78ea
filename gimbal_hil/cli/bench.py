"""`gimbal-hil bench`: the speed figures as ratios, or the blind bench of the discrepancy workflow."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def command(
    what: Annotated[str, typer.Argument(help="speed, or blind (hidden effects; needs the source checkout).")] = "speed",
    repeats: Annotated[int, typer.Option(help="Pairs per figure.", min=3)] = 9,
    out: Annotated[Path | None, typer.Option(help="Folder for the results page.")] = None,
    force: Annotated[bool, typer.Option("--force", help="Overwrite what is in the folder.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the figures as JSON.")] = False,
    every: Annotated[int, typer.Option(help="blind: take every n-th case only.", min=1)] = 1,
    workers: Annotated[int, typer.Option(help="blind: processes, a case in each.", min=1)] = 2,
    dask: Annotated[str | None, typer.Option(metavar="ADDRESS", help="blind: diagnose on a Dask cluster instead.")] = None,
) -> int:
    """The speed figures, each beside the same work done by a plain reference, as a ratio from one run."""
    import json
    import sys

    from firmware_protocol.errors import BadInputError

    if what == "blind":
        from gimbal_hil.bench.blind import run_blind

        if out is None:
            raise BadInputError("--out", "is missing", "a folder for the blind cases and their verdicts")
        return run_blind(out, every, workers, dask)
    if what != "speed":
        raise BadInputError("bench", f"no bench {what!r}", "speed or blind")
    page = None if out is None else out / "report.html"
    if page is not None and page.exists() and not force:
        raise BadInputError(str(page), "already exists", "a new folder, or --force to overwrite it")
    from dataclasses import asdict

    from gimbal_hil.bench import speed_figures
    from gimbal_hil.bench.results import bench_page, bench_text

    figures = speed_figures(repeats, lambda name: print(f"measuring {name} ...", file=sys.stderr))
    if page is not None:
        bench_page(figures, f"gimbal-hil bench --repeats {repeats}").write(page)
    print(json.dumps([asdict(figure) for figure in figures]) if as_json else bench_text(figures))
    return 0
