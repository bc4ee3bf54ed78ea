"""What `gimbal-hil plant` does for a configuration with drives of another make: both simulated, on its bus."""

from __future__ import annotations

import json
import signal
import sys
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

from firmware_protocol.errors import EXIT_DONE, EXIT_INTERRUPTED

if TYPE_CHECKING:
    from firmware_protocol.adapters import Bus
    from firmware_protocol.links import AdapterLinkConfig
    from sim_backend.model import AntennaModel


def serve_drives(
    link: AdapterLinkConfig, model: AntennaModel, seed: int, duration_s: float | None, as_json: bool
) -> int:
    """Serve until stopped (130) or for a time (0)."""
    from gimbal_hil.loop.timing import control_and_witness_cores, real_time
    from sim_backend.drives import DrivenGimbal, DriveServer

    print("preparing the compiled gimbal", file=sys.stderr, flush=True)
    gimbal = DrivenGimbal.of_link(model, link, seed)
    gimbal.tick()
    bus = _other_end(link)
    server = DriveServer(gimbal, bus, link.rate_hz)
    stopped: list[int] = []

    def stop(number: int, _frame: object) -> None:
        stopped.append(number)
        server.stop()

    before = {number: signal.signal(number, stop) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        ready = f"two {link.drive} drives of {model.name} at {link.rate_hz:g} Hz on {link.interface} {link.channel}"
        print(json.dumps({"event": "ready", "link": ready}) if as_json else f"{ready}; Ctrl-C ends it", flush=True)
        # as the virtual antenna: on the core that a daemon of this machine leaves free, and behind it in priority
        with real_time(priority=55, core=control_and_witness_cores()[1]):
            server.serve(None if duration_s is None else round(duration_s * 1e9))
    finally:
        bus.close()
        for number, handler in before.items():
            signal.signal(number, handler)
    counted = asdict(server.statistics)
    if as_json:
        print(json.dumps({"event": "done", "interrupted": bool(stopped), **counted}))
    else:
        print(", ".join(f"{name.replace('_', ' ')} {number}" for name, number in counted.items()))
    return EXIT_INTERRUPTED if stopped else EXIT_DONE


def _other_end(link: AdapterLinkConfig) -> Bus:
    """The bus as the drives see it: the listening end of a socket, a node of a real one."""
    from firmware_protocol.adapters import UnixCanBus, open_bus

    if link.interface == "unix":
        return UnixCanBus(Path(str(link.channel)), listen=True)
    return open_bus(link.interface, link.channel, link.bitrate, link.data_bitrate, link.options)
