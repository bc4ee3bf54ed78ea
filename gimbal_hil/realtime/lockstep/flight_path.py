"""Host and virtual antenna on a base that moves by a table, with a navigation that errs; the truth is kept."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gimbal_hil.loop.settings import DaemonSettings
from gimbal_hil.realtime.lockstep.flight_run import FRACTIONS, TRUE_COLUMNS, run_flight
from gimbal_hil.realtime.lockstep.paths import CompiledPath
from sim_backend.layout import BASE_KIND, BASE_ROW_S, BASE_ROWS, BASE_TABLE, INS_AGE_S, BaseKind
from sim_backend.model import AntennaModel, base_rows

Table = NDArray[np.float64]


@dataclass(frozen=True)
class FlownBase:
    """The base's motion, a row every `row_s` seconds: `attitude` (n, 3), rad, and `pivot` (n, 3), m/s^2."""

    attitude: Table
    pivot: Table
    row_s: float


@dataclass(frozen=True)
class ErringNavigation:
    """Errors (m, ERROR_COLUMNS) of a navigation at `told_hz`, whose attitudes are `hidden_s` older than they say."""

    errors: NDArray[np.int64]
    hidden_s: float
    told_hz: float


class FlightPath(CompiledPath):
    """Host and virtual antenna on such a base, with such a navigation."""

    def __init__(
        self,
        settings: DaemonSettings,
        model: AntennaModel,
        seed: int,
        base: FlownBase,
        navigation: ErringNavigation,
    ) -> None:
        super().__init__(settings, model, seed)
        device, rows, row_s = self.device, base_rows(base.attitude, base.pivot, base.row_s), base.row_s
        hidden_s = navigation.hidden_s
        device.K[BASE_KIND], device.K[BASE_ROWS] = BaseKind.RECORDED, len(rows)
        device.K[BASE_TABLE], device.P[BASE_ROW_S] = len(device.P), row_s
        # older by that, and said to be as old as the model says
        device.P[INS_AGE_S] += hidden_s
        device.P = np.concatenate([device.P, rows.ravel()])
        self._errors = navigation.errors
        self._each = round(settings.rate_hz / navigation.told_hz)
        self._late = round(hidden_s * settings.rate_hz * FRACTIONS)
        self._truth = np.zeros((round(len(rows) * row_s * settings.rate_hz), TRUE_COLUMNS))

    def fly(self, ticks: int, until_done: bool = True) -> None:
        """Go on by `ticks` ticks, or to the end of the program."""
        device = self.device
        self.tick += run_flight(
            self.host.memory.words,
            self.host.plan,
            device.P,
            device.K,
            device.X,
            device.drive_words,
            self._errors,
            self._truth,
            self._each,
            self._late,
            self.tick,
            min(ticks, len(self._truth) - self.tick),
            until_done,
        )

    def truth(self, first: int) -> Table:
        """Rows (n, TRUE_COLUMNS) of the ticks from `first` to this one: joints and base's attitude (rad), muted."""
        return self._truth[first : self.tick]
