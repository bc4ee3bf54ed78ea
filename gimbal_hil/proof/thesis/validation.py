"""The whole validation against the thesis: run everything, keep it in one report."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

from firmware_protocol.errors import BadInputError
from gimbal_hil.proof.thesis.controller_tables import run_table
from gimbal_hil.proof.thesis.friction_curves import friction_curves
from gimbal_hil.proof.thesis.inferred import LEVEL, TILTED
from gimbal_hil.proof.thesis.page import write_report
from gimbal_hil.proof.thesis.printed import GAIN_TABLES, PREFILTER_TABLES
from gimbal_hil.proof.thesis.recovery import recover
from gimbal_hil.proof.thesis.sliding import TEMPERATURES_DEGC, sliding_sweep, warm_antenna
from gimbal_hil.proof.thesis.slip_effects import slip_effects
from gimbal_hil.proof.thesis.step_size import step_convergence
from gimbal_hil.proof.thesis.thesis_report import AXES, ThesisReport
from gimbal_hil.proof.thesis.unbalance import Unbalance, claims, run_all_cases, run_unbalance
from sim_backend.model import shipped_model
from sim_backend.thesis_slips import Slip

#: what is being done, and the share that is done
Progress = Callable[[str, float], None]


def run_thesis(out: Path | None = None, force: bool = False, progress: Progress | None = None) -> ThesisReport:
    """Run the validation (about a minute); with `out` also write `report.html`, `report.txt` and `report.json`
    there.

    BadInputError when `out` already holds a report and `force` is not given.
    """
    if out is not None and (out / "report.html").exists() and not force:
        raise BadInputError(str(out / "report.html"), "exists already", "another --out, or --force")
    told = progress or (lambda what, share: None)
    begun = time.perf_counter()
    every_table = GAIN_TABLES + PREFILTER_TABLES
    tables = []
    for i, table in enumerate(every_table):
        told(f"table {table.number}", 0.25 * i / len(every_table))
        tables.append(run_table(table, TILTED))
    told("tables on a level base", 0.25)
    level = tuple(run_table(table, LEVEL) for table in GAIN_TABLES)
    told("chapter 3: unbalance on a moving base", 0.35)
    runs = run_all_cases()
    stated = claims(runs, run_unbalance(Unbalance.STATIC, "outer", 0.1, 1, Slip.GRAVITY_ROW))
    told("slips of the thesis", 0.45)
    slips = slip_effects()
    told("chapter 4: friction", 0.5)
    friction = tuple(friction_curves(shipped_model(), axis) for axis in AXES)
    told("friction identified from runs of this project's own", 0.52)
    recovered = tuple(number for axis in AXES for number in recover(axis))
    told("sliding sweeps from -40 to 85 degC", 0.85)
    sweeps = tuple(tuple(sliding_sweep(warm_antenna(degc), axis, degc) for degc in TEMPERATURES_DEGC) for axis in AXES)
    told("step size of the plant", 0.96)
    convergence = step_convergence()
    report = ThesisReport(
        tuple(tables),
        level,
        runs,
        stated,
        slips,
        friction,
        recovered,
        sweeps,
        convergence,
        time.perf_counter() - begun,
    )
    told("report", 0.98)
    if out is None:
        return report
    return write_report(report, out)
