"""`gimbal-hil foxglove`: a running daemon as a live source for Foxglove and PlotJuggler."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from gimbal_hil.surface.cli.option_types import DaemonRun, EndAfter


def command(
    run: DaemonRun = None,
    port: Annotated[int, typer.Option(help="Port on this machine; 0 takes any free one.", min=0, max=65535)] = 8765,
    every: Annotated[float, typer.Option(metavar="SECONDS", help="Time between two messages.", min=0.005)] = 0.02,
    layout: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write a Foxglove layout for this daemon's axes, then serve.")
    ] = None,
    seconds: EndAfter = 0.0,
) -> int:
    """Serve signals, state, events and the antenna in three dimensions to Foxglove, live; nothing is commanded.

    In Foxglove: Open connection, Foxglove WebSocket, the address that is printed.
    """
    import time

    from firmware_protocol.errors import EXIT_DONE, LinkError
    from gimbal_hil.realtime.foxglove import FoxgloveServer, layout_of, serve
    from gimbal_hil.realtime.operator import OperatorClient
    from gimbal_hil.surface.cli.next_line import command_line, print_next
    from gimbal_hil.surface.cli.operate import daemon_run

    folder = daemon_run(run)
    ends_s = time.monotonic() + seconds if seconds else float("inf")
    with OperatorClient(folder) as client:
        first, second = client.request("status")["status"]["position_rad"]
        with FoxgloveServer((first, second), port) as server:
            if layout is not None:
                layout.write_text(layout_of((first, second)) + "\n", encoding="utf-8")
                print(f"layout: {layout}")
            print(f"Foxglove: ws://127.0.0.1:{server.port}; Ctrl-C ends it", flush=True)
            try:
                serve(client, server, every, lambda: time.monotonic() < ends_s)
            except LinkError:
                print("the daemon has ended")
    print_next(command_line("watch", folder))
    return EXIT_DONE
