"""Plant and daemon as two processes of the command line, over a link that a machine without hardware has."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO

from firmware_protocol.documents import read_yaml, yaml_text
from firmware_protocol.errors import BadInputError, GimbalHilError
from firmware_protocol.interpreter import apart_from_the_users_folder
from firmware_protocol.json_object import Json
from gimbal_hil.loop.settings import shipped_settings_path

#: a line that carries 2 kHz
_BAUDRATE = 2_000_000


@dataclass
class PlantProcess:
    """The virtual antenna in a process of its own; `served` is what it counted, once it has ended."""

    pid: int
    served: Json = field(default_factory=dict)


def two_process_configuration(folder: Path, link: str, rate_hz: float, changes: dict[str, Json] | None = None) -> Path:
    """The shipped configuration on another link, `changes` laid over its sections; a stall of the machine must not end
    the motion at once.
    """
    port = str(folder / "antenna")
    places: dict[str, Json] = {
        "unix": {"kind": "unix", "path": port},
        "serial": {"kind": "serial", "port": port, "baudrate": _BAUDRATE},
        "slcan": {"kind": "can", "interface": "slcan", "channel": port},
    }
    if link not in places:
        raise BadInputError("--link", f"no link {link!r}", ", ".join(places))
    document = read_yaml(shipped_settings_path(), "the shipped configuration")
    document |= {"link": places[link], "rate_hz": rate_hz}
    document["supervisor"] |= {
        "lost_ticks": 100,
        "set_point_lag_ticks": 200,
        "deadman": {"window_ticks": 250, "reaction": "coast"},
    }
    for section, change in (changes or {}).items():
        document[section] = {**document.get(section, {}), **change}
    path = folder / "daemon.yaml"
    path.write_text(yaml_text(document), encoding="utf-8")
    return path


def begun(words: Sequence[str], said: int | IO[str]) -> subprocess.Popen[str]:
    """A command of this program in a process of its own: its answer through a pipe, what it says into `said`."""
    program = [sys.executable, "-c", "from gimbal_hil.surface.cli import main; main()"]
    with apart_from_the_users_folder():
        return subprocess.Popen([*program, *words], stdout=subprocess.PIPE, stderr=said, text=True)


@contextmanager
def running_plant(configuration: Path) -> Iterator[PlantProcess]:
    """`gimbal-hil plant` until the block ends."""
    process = begun(["plant", "--config", str(configuration), "--json"], subprocess.DEVNULL)
    plant = PlantProcess(process.pid)
    try:
        assert process.stdout is not None
        if not process.stdout.readline():
            raise GimbalHilError(f"the plant did not start on {configuration}")
        yield plant
    finally:
        process.send_signal(signal.SIGTERM)
        said = process.communicate()[0].strip()
        plant.served = json.loads(said.splitlines()[-1]) if said else {}
