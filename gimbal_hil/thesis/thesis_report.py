"""What the validation against the thesis found, as one record: filled by `validation`, shown by `page` and `text`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from gimbal_hil.thesis.controller_tables import ACCEPTED, Agreement, TableResult
from gimbal_hil.thesis.friction_curves import FrictionCurves
from gimbal_hil.thesis.sliding import SlidingSweep
from gimbal_hil.thesis.slip_effects import SlipEffect
from gimbal_hil.thesis.step_size import Convergence
from gimbal_hil.thesis.unbalance import Claim, UnbalanceRun

AXES = ("outer", "inner")


@dataclass(frozen=True)
class ThesisReport:
    """Everything that `gimbal-hil experiment thesis` found."""

    #: tables 5.2 to 5.15 in the configuration that carries them all, and 5.2 to 5.9 on a level base
    tables: tuple[TableResult, ...]
    level_tables: tuple[TableResult, ...]
    unbalance: tuple[UnbalanceRun, ...]
    claims: tuple[Claim, ...]
    slips: tuple[SlipEffect, ...]
    friction: tuple[FrictionCurves, ...]
    #: per axis, then per temperature; 20 degC is the thesis' own antenna
    sweeps: tuple[tuple[SlidingSweep, ...], ...]
    convergence: Convergence
    wall_time_s: float
    page: Path | None = None

    @property
    def reproduced(self) -> bool:
        """Whether every table that can be reproduced was."""
        return all(table.verdict is not Agreement.NOT_REPRODUCIBLE for table in self.tables if table.table.number in ACCEPTED)
