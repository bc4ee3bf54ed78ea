"""Signals of a run folder, finished or still being written."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.runs import AXES, GrowingLog, columns_of
from gimbal_hil.surface.testing.assertions import Signal

#: signal -> message and field that carry it
_CARRIED = {
    "position": ("feedback_{}", "position"),
    "rate": ("feedback_{}", "rate"),
    "torque": ("set_point", "torque_{}"),
    "temperature": ("motor_status_{}", "temperature"),
    "torque_measured": ("motor_status_{}", "torque"),
}
_REFERENCES = ("position_ref", "rate_ref")


class RecordedSignals:
    """A run folder, from which signals are taken by the names of the signals table."""

    def __init__(self, folder: Path) -> None:
        self.folder = Path(folder)
        self._log = GrowingLog(self.folder)

    @property
    def axes(self) -> tuple[str, str]:
        """Names of the axes, the carrying one first."""
        return self._log.record.header.axes

    def signal(self, name: str) -> Signal:
        """A signal as far as it is recorded by now, as in `outer.position`; BadInputError where there is none."""
        axis, _, what = name.partition(".")
        if axis not in self.axes or what not in (*_CARRIED, *_REFERENCES):
            names = [f"{axis}.{what}" for axis in self.axes for what in (*_CARRIED, *_REFERENCES)]
            raise BadInputError(str(self.folder), f"has no signal {name!r}", ", ".join(names))
        run = self._log.look(0)
        own = AXES[self.axes.index(axis)]
        period_s = self._log.record.header.period_ns * 1e-9
        if what in _REFERENCES:
            # an axis that no loop controls has none
            rows = run.ticks[run.ticks[f"{what}_{own}"] == run.ticks[f"{what}_{own}"]]
            return Signal(
                name, np.asarray(rows["tick"] * period_s, np.float64), np.asarray(rows[f"{what}_{own}"], np.float64)
            )
        message, field = (word.format(own) for word in _CARRIED[what])
        columns = columns_of(run.frames, message)
        return Signal(name, np.asarray(columns.tick * period_s, np.float64), columns.physical(field))
