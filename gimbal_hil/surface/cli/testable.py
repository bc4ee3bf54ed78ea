"""`gimbal-hil testable`: what a run could show, before any data."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gimbal_hil.surface.cli.option_types import AskedModel

if TYPE_CHECKING:
    from gimbal_hil.knowledge.discrepancy import Foreseen

#: pairs that are printed
_MOST_PAIRS = 20


def command(
    plan: Annotated[str, typer.Option(metavar="PLAN", help="A plan file, or a sequence of `gimbal-hil experiment`.")],
    model: AskedModel = None,
    config: Annotated[
        Path | None, typer.Option(help="Configuration file: loops and rate; without it the shipped one.")
    ] = None,
    short: Annotated[bool, typer.Option("--short", help="The short variant of a sequence.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print it as one JSON object.")] = False,
) -> int:
    """Which effects a run could show and from which size, and which pairs it cannot tell apart.

    The run is rehearsed on the virtual antenna that the model describes, in lockstep. A size is the smallest at which
    `discrepancy` would see a gap: beside the noise, and after known numbers have moved within their uncertainty.
    """
    import json

    from firmware_protocol.errors import EXIT_DONE
    from gimbal_hil.surface.cli.following_logs import after_testable
    from gimbal_hil.surface.cli.next_line import print_next
    from gimbal_hil.surface.library import foresee

    found = foresee(plan, model, config, short=short)
    if as_json:
        print(json.dumps(as_document(found), allow_nan=False))
        return EXIT_DONE
    print("\n".join(_lines(found)))
    print_next(after_testable(plan, model, config, short))
    return EXIT_DONE


def as_document(found: Foreseen) -> dict[str, object]:
    """What was foreseen, for other tools."""
    return {
        "schema": 1,
        "band_hz": found.band_hz,
        "noise_floors": [{"channel": name, "rms": rms, "unit": unit} for name, rms, unit in found.floors],
        "shows": [vars(one) for one in found.shows],
        "does_not_show": [{"name": name, "axis": axis, "reason": reason} for name, axis, reason in found.hidden],
        "not_told_apart": [
            {"one": list(pair.one), "other": list(pair.other), "from_times": pair.from_times} for pair in found.confused
        ],
    }


def _lines(found: Foreseen) -> list[str]:
    from gimbal_hil.knowledge.discrepancy import ORDER

    lines = [f"scored up to {found.band_hz:g} Hz; noise there:"]
    lines += [f"  {name:<24} {rms:.3g} {unit}" for name, rms, unit in found.floors]
    lines.append(f"\nshows, from a change of (ripples at {ORDER:g} periods a turn or along the travel):")
    for one in found.shows:
        size = f"{one.parameter} {one.size:.3g} {one.unit}".removesuffix(" 1")
        of = f" of {one.nominal:.4g}" if one.nominal is not None else ""
        tried = " (smallest tried)" if one.as_tried else ""
        lines.append(f"  {one.name:<28} {one.axis:<10} {size}{of}{tried}, in {one.channel}")
    lines.append("\ndoes not show:" if found.hidden else "\neverything in the catalogue shows")
    lines += [f"  {name:<28} {axis:<10} {reason}" for name, axis, reason in found.hidden]
    lines.append("\ncannot be told apart at these sizes:" if found.confused else "\nall that shows can be told apart")
    for pair in found.confused[:_MOST_PAIRS]:
        names = " and ".join(f"{name} of {axis}" for name, axis in (pair.one, pair.other))
        lines.append(f"  {names}: " + (f"from {pair.from_times:.1f} times" if pair.from_times else "at no size"))
    if len(found.confused) > _MOST_PAIRS:
        lines.append(f"  and {len(found.confused) - _MOST_PAIRS} more, from less (--json has all)")
    return lines
