"""What the scope caught, as run folders inside the run: `scope/0001`, `scope/0002`, ...

An excerpt holds every tick and frame of its stretch whatever the run itself keeps, and is read, exported and drawn like
any run. It cannot be replayed: how the host stood at its first tick is not in it.
"""

from __future__ import annotations

from collections import deque
from dataclasses import replace
from pathlib import Path

import numpy as np

from firmware_protocol.errors import GimbalHilError
from firmware_protocol.json_object import Json
from gimbal_hil.data.runs import SCOPE_FOLDER, TICK_ROW, EventKind, RunHeader, RunWriter
from gimbal_hil.realtime.telemetry import Capture

#: excerpts that one run keeps: an automatic scope over a night must not fill the disk
MOST = 50


class Excerpts:
    """Writes captures below the folder of a run."""

    def __init__(self, run: Path, header: RunHeader) -> None:
        configuration: Json = dict(header.configuration)
        configuration["recording"] = dict(configuration.get("recording", {})) | {"frames": True, "every_ticks": 1}
        self._run, self._header = run, replace(header, configuration=configuration)
        self.written: deque[str] = deque(maxlen=MOST)
        self.failure: str | None = None

    def write(self, capture: Capture) -> Path | None:
        """Leave one capture; None where the run has enough of them, or the disk refuses (`failure` says why)."""
        if capture.number > MOST or not capture.exchanges:
            return None
        wanted, folder = capture.settings, self._run / SCOPE_FOLDER / f"{capture.number:04d}"
        title = f"scope {capture.number}: {wanted.kind.value} of {wanted.signal}"
        rows = np.frombuffer(b"".join(exchange.row for exchange in capture.exchanges), TICK_ROW).copy()
        try:
            with RunWriter(folder, replace(self._header, title=title), force=True) as writer:
                for exchange in capture.exchanges:
                    writer.append_exchange(exchange.tick, exchange.received, exchange.sent)
                writer.append_ticks(rows)
                if capture.trigger_tick is not None:
                    at = int(np.searchsorted(rows["tick"], capture.trigger_tick))
                    data = {"signal": wanted.signal, "kind": wanted.kind.value, "level": wanted.level}
                    time_ns = int(rows["time_ns"][at])
                    writer.event(capture.trigger_tick, time_ns, EventKind.NOTE, "the scope triggered", data)
        except (OSError, ValueError, GimbalHilError) as error:
            self.failure = str(error)
            return None
        self.written.append(f"{SCOPE_FOLDER}/{folder.name}")
        return folder
