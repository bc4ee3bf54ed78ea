"""`gimbal-hil warm`: every kernel compiled for this machine now, so that nothing waits for one later."""

from __future__ import annotations

from typing import Annotated

import typer


def command(
    as_json: Annotated[bool, typer.Option("--json", help="Print times as one JSON object.")] = False,
) -> int:
    """Compile all kernels that are not on disk yet: once after installation, an update, or a change of an effect.

    They are kept in $GIMBAL_HIL_CACHE, else ~/.cache/gimbal-hil. What is there already is only loaded.
    """
    import json
    import time

    from firmware_protocol.errors import EXIT_DONE
    from firmware_protocol.kernel_cache import cache_directory
    from gimbal_hil.surface.cli.next_line import print_next
    from gimbal_hil.surface.cli.progress import ProgressBar
    from gimbal_hil.surface.warming import KERNELS

    took: dict[str, float] = {}
    with ProgressBar(not as_json) as bar:
        bar.begin("kernels", len(KERNELS), 0.0)
        for kernel in KERNELS:
            began = time.monotonic()
            kernel.ask()
            took[kernel.text] = time.monotonic() - began
            bar.at(kernel.text, 1.0)
    if as_json:
        document = {"cache": str(cache_directory()), "seconds": {name: round(s, 2) for name, s in took.items()}}
        print(json.dumps(document))
        return EXIT_DONE
    for name, seconds in took.items():
        print(f"{seconds:7.1f} s  {name}")
    print(f"kept in {cache_directory()}")
    print_next("gimbal-hil demo")
    return EXIT_DONE
