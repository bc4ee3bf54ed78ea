"""`gimbal-hil demo`: the whole workflow on the virtual antenna."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from firmware_protocol.places import require_new

#: what there is to look at before anything is computed
MEANWHILE_FILE = "meanwhile.html"


def command(
    out: Annotated[
        Path | None, typer.Option(help="Folder for runs and report; without it a new one below ./runs.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as one JSON object.")] = False,
    force: Annotated[bool, typer.Option("--force", help="Overwrite what is in the folder.")] = False,
) -> int:
    """The whole workflow on the virtual antenna in under two minutes; ends with the path of one HTML report.

    The first time it also compiles the plant for this machine, which takes most of that time; later runs find it on
    disk.
    """
    import json
    import sys
    import time

    from firmware_protocol.kernel_cache import is_kept
    from gimbal_hil.loop.timing import wall_clock_utc
    from gimbal_hil.surface.cli.following import after_demo
    from gimbal_hil.surface.cli.next_line import print_next
    from gimbal_hil.surface.cli.progress import ProgressBar

    folder = out or Path("runs") / f"demo-{wall_clock_utc()[:19].replace(':', '').replace('-', '')}"
    require_new(folder, force, "report.html", MEANWHILE_FILE)
    began = time.monotonic()
    if not as_json:
        from gimbal_hil.pages.report import earlier_demo

        folder.mkdir(parents=True, exist_ok=True)
        page = earlier_demo("report.html beside this page").write(folder / MEANWHILE_FILE)
        print(f"[{time.monotonic() - began:5.1f} s] meanwhile    {page.resolve()}: the antenna, recorded earlier")
        print(
            "gimbal-hil demo: loading the virtual antenna",
            file=sys.stderr,
        )
    from gimbal_hil.surface.warming import ask_elsewhere

    if not is_kept("gimbal_hil.knowledge.discrepancy.twin.kernel"):
        # what later stages need; the host is half of the first one's kernel and would be translated twice
        ask_elsewhere("rigid_body", "friction_fit", "search")
    # the other core compiles while this one is still reading what the stages are made of
    from gimbal_hil.loop.settings import shipped_settings
    from gimbal_hil.surface.demo import tell

    found: dict[str, str] = {}

    def say(stage: str, line: str) -> None:
        found[stage] = line
        if not as_json:
            print(f"[{time.monotonic() - began:5.1f} s] {stage:<12} {line}")

    with ProgressBar(not as_json) as progress:
        report = tell(shipped_settings(), folder, progress, say)
    if as_json:
        print(
            json.dumps({"stages": found, "report": str(report.resolve()), "took_s": round(time.monotonic() - began, 1)})
        )
    else:
        print_next(after_demo())
        print(f"report: {report.resolve()}")
    return 0
