"""`gimbal-hil export`: a run for other people's tools."""

from __future__ import annotations

import json
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from gimbal_hil.runs import Progress, Run


class Format(StrEnum):
    """What is written: the signals table (parquet, csv), decoded frames and ticks (mcap, mf4) or frames as they were
    (blf).
    """

    PARQUET = "parquet"
    CSV = "csv"
    MCAP = "mcap"
    BLF = "blf"
    MF4 = "mf4"


def command(
    run: Annotated[Path, typer.Argument(help="Run folder.")],
    kind: Annotated[
        Format,
        typer.Option("--format", help="parquet, csv: signals table; blf: raw frames; mcap, mf4: decoded frames."),
    ],
    out: Annotated[Path, typer.Option(metavar="FILE", help="File to write.")],
    resample: Annotated[bool, typer.Option("--resample", help="Signals table: bridge missing rows.")] = False,
    drop_invalid: Annotated[
        bool, typer.Option("--drop-invalid", help="Signals table: keep the longest stretch without missing rows.")
    ] = False,
    force: Annotated[bool, typer.Option("--force", help="Overwrite the file.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as JSON.")] = False,
) -> int:
    """Write a run as a signals table (CSV, Parquet), raw frames (BLF) or decoded signals (MCAP, MF4)."""
    from rich.console import Console
    from rich.progress import Progress as Bar

    from firmware_protocol.errors import EXIT_DONE, EXIT_NO
    from gimbal_hil.runs import damage_of, open_run

    log = open_run(run)
    # a table of signals is refused by its own rules
    damage = [f"the log is damaged {found.in_words()}" for found in damage_of(log)]
    console = Console(stderr=True)
    with Bar(console=console, transient=True, disable=as_json or not console.is_terminal) as bar:
        task = bar.add_task(f"writing {kind.value}", total=None)

        def show(done: int, of: int) -> None:
            bar.update(task, completed=done, total=of)

        if kind in (Format.CSV, Format.PARQUET):
            answer = _write_table(log, out, kind, resample=resample, drop_invalid=drop_invalid, force=force)
        else:
            answer = _write_frames(log, out, kind, show, force=force)
    answer = {"file": str(out), "format": kind.value, **answer, "notes": [*answer["notes"], *damage]}
    if as_json:
        print(json.dumps(answer, indent=2))
    else:
        print("\n".join([f"{answer['content']} in {out}", *answer["notes"]]))
    return EXIT_NO if damage else EXIT_DONE


def _write_table(
    log: Run, out: Path, kind: Format, *, resample: bool, drop_invalid: bool, force: bool
) -> dict[str, Any]:
    from gimbal_hil.signals import TableKind, signals_of_run, write_signals

    table = signals_of_run(log, resample=resample, drop_invalid=drop_invalid)
    write_signals(table, out, TableKind(kind.value), force=force)
    content = f"{len(table)} rows of {len(table.columns)} signals at {table.period_s * 1e3:.6g} ms"
    return {"content": content, "rows": len(table), "columns": list(table.columns), "notes": list(table.notes)}


def _write_frames(log: Run, out: Path, kind: Format, show: Progress, *, force: bool) -> dict[str, Any]:
    from gimbal_hil.runs import export_blf, export_mcap, export_mf4
    from gimbal_hil.signals import replacing

    write = {Format.BLF: export_blf, Format.MCAP: export_mcap, Format.MF4: export_mf4}[kind]
    word = {Format.BLF: "frames", Format.MCAP: "records", Format.MF4: "channels"}[kind]
    with replacing(out, force) as temporary:
        count = write(log, temporary, show)
        if not temporary.exists():
            # asammdf gives every file its own ending
            temporary.with_suffix(f".{kind.value}").replace(temporary)
    return {"content": f"{count} {word}", word: count, "notes": list(log.notes)}
