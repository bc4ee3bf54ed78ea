"""What the validation against the thesis found, as one record: filled by `validation`, shown by `page` and `text`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from gimbal_hil.proof.thesis.controller_tables import REGRESSION_BOUND, Agreement, TableResult
from gimbal_hil.proof.thesis.friction_curves import FrictionCurves
from gimbal_hil.proof.thesis.recovery import Recovered
from gimbal_hil.proof.thesis.sliding import SlidingSweep
from gimbal_hil.proof.thesis.slip_effects import SlipEffect
from gimbal_hil.proof.thesis.step_size import Convergence
from gimbal_hil.proof.thesis.unbalance import Claim, UnbalanceRun

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
    #: tables 4.7 to 4.10 beside this project's own identification
    recovered: tuple[Recovered, ...]
    #: per axis, then per temperature; 20 degC is the thesis' own antenna
    sweeps: tuple[tuple[SlidingSweep, ...], ...]
    convergence: Convergence
    wall_time_s: float
    page: Path | None = None

    @property
    def within_bounds(self) -> bool:
        """Whether every table that has a regression bound keeps it: whether this is as good as it was."""
        bounded = (table for table in self.tables if table.table.number in REGRESSION_BOUND)
        return all(table.agreement is not Agreement.NOT_REPRODUCIBLE for table in bounded)

    def numbers_of(self, *kinds: Agreement) -> list[str]:
        """Numbers of the tables that agree in one of these ways."""
        return [table.table.number for table in self.tables if table.agreement in kinds]
