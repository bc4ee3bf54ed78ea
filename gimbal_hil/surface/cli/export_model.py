"""`gimbal-hil export-model`: a model for other people's simulators."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gimbal_hil.knowledge.model_exports import ModelFormat

if TYPE_CHECKING:
    from gimbal_hil.knowledge.model_exports import ExportedModel, Item


def command(
    model: Annotated[Path, typer.Argument(help="Model file, e.g. the model.yaml of `discrepancy`.")],
    to: Annotated[
        ModelFormat,
        typer.Option(
            "--to",
            help="mjcf: MuJoCo; urdf: bodies, damping, Coulomb friction; isaac: actuators for Isaac Lab; "
            "bam: parameters of BAM; csv: plain curves; fmu: the virtual antenna for co-simulation (FMI 3.0).",
        ),
    ],
    out: Annotated[Path, typer.Option(metavar="FILE", help="File to write.")],
    force: Annotated[bool, typer.Option("--force", help="Overwrite the file.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as JSON.")] = False,
) -> int:
    """Write a model in another format. What the format holds only nearly, and what it cannot hold, is listed."""
    from firmware_protocol.errors import EXIT_DONE
    from gimbal_hil.data.signals import replacing
    from gimbal_hil.knowledge.model_exports import export_model
    from gimbal_hil.surface.cli.following import after_export_model
    from gimbal_hil.surface.cli.next_line import print_next
    from sim_backend.model import load_model

    read = load_model(model)
    if to is ModelFormat.FMU:
        _say_that_it_takes_time()
    exported = export_model(read, to)
    with replacing(out, force) as temporary:
        temporary.write_bytes(exported.content)
    if as_json:
        print(json.dumps({"file": str(out), "format": to.value, **_document(exported)}, indent=2))
    else:
        _say(exported, to, out)
        print_next(after_export_model(model, len(read.axes)))
    return EXIT_DONE


def _say_that_it_takes_time() -> None:
    from firmware_protocol.kernel_cache import cache_directory
    from sim_backend.fmu import library_is_kept

    if not library_is_kept():
        text = f"translating the antenna's tick for an FMU: about a minute, once (kept in {cache_directory()})"
        print(text, file=sys.stderr, flush=True)


def _document(exported: ExportedModel) -> dict[str, object]:
    return {
        "held": [vars(item) for item in exported.held],
        "approximated": [{**vars(one.item), "how": one.reason} for one in exported.approximated],
        "left_out": [{**vars(one.item), "reason": one.reason, "effects": one.effects} for one in exported.left_out],
    }


def _say(exported: ExportedModel, to: ModelFormat, out: Path) -> None:
    print(f"{len(exported.held)} numbers and effects held in {out} ({to.value})")
    for title, rows in (("held nearly", exported.approximated), ("left out", exported.left_out)):
        print(f"{title}: {len(rows) or 'nothing'}")
        for reason in dict.fromkeys(one.reason for one in rows):
            items = [one.item for one in rows if one.reason == reason]
            axes = {axis: ", ".join(item.name for item in items if item.axis == axis) for axis in _axes(items)}
            for names in dict.fromkeys(axes.values()):
                who = " and ".join(axis for axis, found in axes.items() if found == names)
                print(f"  {who}: {names}\n    {reason}")


def _axes(items: list[Item]) -> list[str]:
    return list(dict.fromkeys(item.axis for item in items))
