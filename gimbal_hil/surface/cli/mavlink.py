"""`gimbal-hil mavlink`: a running daemon as a gimbal for autopilots and ground stations that speak MAVLink."""

from __future__ import annotations

from typing import Annotated

import typer

from gimbal_hil.surface.cli.option_types import DaemonRun, EndAfter

_STATUS_S = 1.0


def command(
    run: DaemonRun = None,
    link: Annotated[
        str,
        typer.Option(
            metavar="ADDRESS", help="udpin:HOST:PORT (waits), udpout:HOST:PORT, tcp:HOST:PORT or a serial port."
        ),
    ] = "udpin:127.0.0.1:14550",
    baud: Annotated[int, typer.Option(metavar="BIT/S", help="Of a serial port.", min=1)] = 57600,
    system: Annotated[int, typer.Option(help="MAVLink system id: that of the vehicle.", min=1, max=255)] = 1,
    component: Annotated[int, typer.Option(help="MAVLink component id.", min=1, max=255)] = 154,
    seconds: EndAfter = 0.0,
) -> int:
    """Be a gimbal of MAVLink's gimbal protocol v2 for a running daemon: attitude, rates, limits, faults.

    MAVLink does not say who may command: keep the link to a vehicle's own. The daemon's checks and guards stand
    behind it; a controller that falls silent, and the end of this command, brake the joints to rest.
    """
    import time

    from firmware_protocol.errors import EXIT_DONE
    from gimbal_hil.realtime.mavlink import Gimbal, open_link, reach_of, serve
    from gimbal_hil.realtime.operator import OperatorClient
    from gimbal_hil.surface.cli.next_line import command_line, print_next
    from gimbal_hil.surface.cli.operate import daemon_run

    folder = daemon_run(run)
    reach = reach_of(folder)
    opened, dialect = open_link(link, baud, system, component)
    ends_s = time.monotonic() + seconds if seconds else float("inf")
    with OperatorClient(folder) as client:
        print(f"gimbal {system}/{component} on {link}; Ctrl-C ends it and brakes what it moves", flush=True)
        serve(
            client,
            opened,
            Gimbal(dialect, reach, system, component, folder.name),
            lambda said: print(said, flush=True),
            lambda: time.monotonic() < ends_s,
        )
    print_next(command_line("watch", folder))
    return EXIT_DONE
