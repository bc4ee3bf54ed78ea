"""`gimbal-hil export`: a run for other people's tools."""

from __future__ import annotations

import json
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from firmware_protocol.json_object import Json

if TYPE_CHECKING:
    from gimbal_hil.data.exports import Group, Progress
    from gimbal_hil.data.runs import RecordedRun
    from gimbal_hil.data.signals import SignalsTable


class Format(StrEnum):
    """What is written: the signals table (parquet, csv, mat), all that is known by name (mcap, mf4), frames as they
    were (blf), or messages of ROS 2 (ros2).
    """

    PARQUET = "parquet"
    CSV = "csv"
    MAT = "mat"
    MCAP = "mcap"
    BLF = "blf"
    MF4 = "mf4"
    ROS2 = "ros2"


_TABLES = (Format.CSV, Format.PARQUET, Format.MAT)


def command(
    run: Annotated[Path, typer.Argument(help="Run folder.")],
    kind: Annotated[
        Format,
        typer.Option(
            "--format",
            help="parquet, csv, mat: signals table; mcap, mf4: that and frames; blf: raw frames; ros2: a bag.",
        ),
    ],
    out: Annotated[Path, typer.Option(metavar="FILE", help="File to write; for ros2 a folder.")],
    layouts: Annotated[
        bool, typer.Option("--layouts", help="mcap: layouts for Foxglove and PlotJuggler beside the file.")
    ] = False,
    resample: Annotated[bool, typer.Option("--resample", help="Signals table: bridge missing rows.")] = False,
    drop_invalid: Annotated[
        bool, typer.Option("--drop-invalid", help="Signals table: keep the longest stretch without missing rows.")
    ] = False,
    force: Annotated[bool, typer.Option("--force", help="Overwrite the file.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as JSON.")] = False,
) -> int:
    """Write a run as a signals table (CSV, Parquet, MAT), as signals and decoded frames (MCAP, MF4), as raw frames
    (BLF), or as messages of ROS 2. A signal has the same name in all of them but the last, which has ROS's own.
    """
    from rich.progress import Progress as Bar

    from firmware_protocol.errors import EXIT_DONE, EXIT_NO, BadInputError
    from gimbal_hil.data.runs import damage_of, open_run
    from gimbal_hil.surface.cli.following import after_export
    from gimbal_hil.surface.cli.next_line import print_next
    from gimbal_hil.surface.cli.progress import error_console

    if layouts and kind is not Format.MCAP:
        raise BadInputError("--layouts", f"are for mcap, not for {kind.value}", "--format mcap")
    log = open_run(run)
    # a table of signals is refused by its own rules
    damage = [f"the log is damaged: {found.in_words()}" for found in damage_of(log)]
    console = error_console()
    with Bar(console=console, transient=True, disable=as_json or not console.is_terminal) as bar:
        task = bar.add_task(f"writing {kind.value}", total=None)

        def show(done: int, of: int) -> None:
            bar.update(task, completed=done, total=of)

        if kind in _TABLES:
            answer = _write_table(log, out, kind, resample=resample, drop_invalid=drop_invalid, force=force)
        elif kind is Format.ROS2:
            answer = _write_bag(log, out, show, resample=resample, drop_invalid=drop_invalid, force=force)
        else:
            answer = _write_frames(log, out, kind, show, layouts=layouts, force=force)
    answer = {"file": str(out), "format": kind.value, **answer, "notes": [*answer["notes"], *damage]}
    if as_json:
        print(json.dumps(answer, indent=2))
    else:
        print("\n".join([f"{answer['content']} in {out}", *answer["notes"]]))
        print_next(after_export(run, out, kind in (Format.CSV, Format.PARQUET), log.record.header.axes))
    return EXIT_NO if damage else EXIT_DONE


def _write_table(log: RecordedRun, out: Path, kind: Format, *, resample: bool, drop_invalid: bool, force: bool) -> Json:
    from gimbal_hil.data.exports import export_mat
    from gimbal_hil.data.signals import TableKind, csv_metadata, replacing, signals_of_run, write_signals

    table = signals_of_run(log, resample=resample, drop_invalid=drop_invalid)
    if kind is Format.MAT:
        with replacing(out, force) as temporary:
            export_mat(table, temporary)
    elif kind is Format.CSV:
        with replacing(out.with_name(f"{out.name}-metadata.json"), force) as beside:
            write_signals(table, out, TableKind.CSV, force=force)
            beside.write_text(csv_metadata(table, out.name), encoding="utf-8")
    else:
        write_signals(table, out, TableKind(kind.value), force=force)
    content = f"{len(table)} rows of {len(table.columns)} signals at {table.period_s * 1e3:.6g} ms"
    return {"content": content, "rows": len(table), "columns": list(table.columns), "notes": list(table.notes)}


def _write_bag(log: RecordedRun, out: Path, show: Progress, *, resample: bool, drop_invalid: bool, force: bool) -> Json:
    from gimbal_hil.data.exports import export_ros2
    from gimbal_hil.data.signals import signals_of_run

    table = signals_of_run(log, resample=resample, drop_invalid=drop_invalid)
    count = export_ros2(log, table, out, force, show)
    return {"content": f"{count} messages", "messages": count, "notes": list(table.notes)}


def _write_frames(log: RecordedRun, out: Path, kind: Format, show: Progress, *, layouts: bool, force: bool) -> Json:
    from gimbal_hil.data.exports import export_blf, export_mcap, export_mf4, groups_of
    from gimbal_hil.data.signals import replacing

    word = {Format.BLF: "frames", Format.MCAP: "records", Format.MF4: "channels"}[kind]
    notes = list(log.notes)
    with replacing(out, force) as temporary:
        if kind is Format.BLF:
            count = export_blf(log, temporary, show)
        else:
            table, missing = _table_of(log)
            notes += missing
            groups = groups_of(log, table)
            count = (export_mcap if kind is Format.MCAP else export_mf4)(log, groups, temporary, show)
            if layouts:
                _write_layouts(log, groups, out, force)
        if not temporary.exists():
            # asammdf gives every file its own ending
            temporary.with_suffix(f".{kind.value}").replace(temporary)
    return {"content": f"{count} {word}", word: count, "notes": notes}


def _table_of(log: RecordedRun) -> tuple[SignalsTable | None, list[str]]:
    """The signals table for the same file, or why there is none: frames are worth having without it."""
    from firmware_protocol.errors import GimbalHilError
    from gimbal_hil.data.signals import signals_of_run

    try:
        return signals_of_run(log), []
    except GimbalHilError as error:
        return None, [f"frames and ticks only, because the run makes no table of signals: {error}"]


def _write_layouts(log: RecordedRun, groups: tuple[Group, ...], out: Path, force: bool) -> None:
    from gimbal_hil.data.exports import foxglove_layout, plotjuggler_layout
    from gimbal_hil.data.signals import replacing

    axes = log.record.header.axes
    for ending, layout in ((".foxglove.json", foxglove_layout), (".plotjuggler.xml", plotjuggler_layout)):
        with replacing(out.with_name(out.stem + ending), force) as temporary:
            temporary.write_text(layout(groups, axes), encoding="utf-8")
