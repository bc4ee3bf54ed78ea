"""`gimbal-hil adjust`: gains and limits of a running daemon, within the bounds that its configuration gives."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from firmware_protocol.json_object import Json


def command(
    values: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="AXIS.KEY=VALUE...", help="As in outer.rate_loop.kp_s_per_rad=50; none: show what may be changed."
        ),
    ] = None,
    back: Annotated[bool, typer.Option("--back", help="All numbers to what the configuration says.")] = False,
    run: Annotated[
        Path | None,
        typer.Option(metavar="RUN", help="Run folder of the daemon; without it the newest one below ./runs."),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="The numbers afterwards, as one JSON object.")] = False,
) -> int:
    """Change gains and limits while the daemon runs; each change acts with one tick, is in the log and is replayed.

    Only what the configuration lists under axes.NAME.adjustable can be changed, and only within the bounds there.
    """
    import json

    from firmware_protocol.errors import EXIT_DONE, BadInputError
    from gimbal_hil.realtime.operator import OperatorClient
    from gimbal_hil.surface.cli.next_line import command_line, print_next
    from gimbal_hil.surface.cli.operate import daemon_run

    if back and values:
        raise BadInputError("--back", "cannot be combined with values", "one of them")
    changes = _changes(values or [])
    folder = daemon_run(run)
    with OperatorClient(folder) as client:
        tick = None
        if back:
            tick = client.request("adjust_back")["tick"]
        elif changes:
            tick = client.request("adjust", **changes)["tick"]
        numbers: list[Json] = client.request("adjustable")["numbers"]
    if as_json:
        print(json.dumps({"tick": tick, "numbers": numbers}))
        return EXIT_DONE
    print("\n".join(_table(numbers)))
    if tick is not None:
        print(f"in force from tick {tick}")
    changed = any(one["value"] != one["configured"] for one in numbers)
    print_next(command_line("adjust", "--back", run=folder) if changed else command_line("watch", folder))
    return EXIT_DONE


def _changes(words: list[str]) -> dict[str, dict[str, float]]:
    import math

    from firmware_protocol.errors import BadInputError

    found: dict[str, dict[str, float]] = {}
    for word in words:
        name, _, text = word.partition("=")
        axis, _, key = name.partition(".")
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not (axis and key and math.isfinite(value)):
            raise BadInputError(word, "is no change of a number", "AXIS.KEY=VALUE, outer.rate_loop.kp_s_per_rad=50")
        found.setdefault(axis, {})[key] = value
    return found


def _table(numbers: list[Json]) -> list[str]:
    if not numbers:
        return ["nothing may be changed: the configuration has no axes.NAME.adjustable"]
    rows = [("number", "in force", "configured", "bounds")]
    for one in numbers:
        mark = "" if one["value"] == one["configured"] else " *"
        bounds = f"{one['low']:g} to {one['high']:g}"
        rows.append((f"{one['axis']}.{one['key']}", f"{one['value']:g}{mark}", f"{one['configured']:g}", bounds))
    widths = [max(len(row[column]) for row in rows) for column in range(4)]
    return ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows]
