"""The validation as text: what the command prints and `report.txt` keeps."""

from __future__ import annotations

import math
from collections.abc import Sequence
from textwrap import wrap

from gimbal_hil.proof.thesis.closed_loop import LOOP_RATE_HZ
from gimbal_hil.proof.thesis.controller_tables import REGRESSION_BOUND, TableResult
from gimbal_hil.proof.thesis.friction_curves import FrictionCurves
from gimbal_hil.proof.thesis.inferred import STEP_TIME_S, TILTED
from gimbal_hil.proof.thesis.printed import Loop
from gimbal_hil.proof.thesis.recovery import Recovered
from gimbal_hil.proof.thesis.slip_effects import SlipEffect
from gimbal_hil.proof.thesis.thesis_report import ThesisReport
from gimbal_hil.proof.thesis.unbalance import Unbalance, UnbalanceRun

#: what the tables were run with, and what of it was fitted to them
INFERRED = (
    "The thesis names no motor, gyro or limits. The configuration here was inferred by fitting every table at once: a "
    f"base tilted by roll {math.degrees(TILTED.roll_rad):.1f} and pitch {math.degrees(TILTED.pitch_rad):.1f} deg; a "
    f"drive of {TILTED.outer.per_unit_nm:g} N m per controller unit limited at {TILTED.outer.limit_nm:g} N m (outer), "
    f"{TILTED.inner.per_unit_nm:g} and {TILTED.inner.limit_nm:g} N m (inner); a loop at {LOOP_RATE_HZ / 1e3:g} kHz, an "
    "ideal gyro and no anti-windup."
)
FITTED = (
    f"The time of the step was fitted too: {STEP_TIME_S[Loop.RATE, 'outer']:.2f} s in the rate loops, "
    f"{STEP_TIME_S[Loop.POSITION, 'outer']:.2f} s and {STEP_TIME_S[Loop.POSITION, 'inner']:.2f} s in the outer and "
    "inner position loops. Settling counts from t = 0, so it contains that time. The fixed tilt of the base replaces "
    "the moving base of section 5.3.1, where the thesis tuned on the cases of tables 3.1 and 3.2 and does not say "
    "which belongs to which table."
)


def as_text(report: ThesisReport) -> str:
    """The whole report as plain text, one section a chapter."""
    return "\n".join(
        [
            *_summary(report),
            "",
            *(line for table in report.tables for line in (*_table(table), "")),
            *_unbalance(report),
            "",
            *_slips(report),
            "",
            *_friction(report.friction),
            "",
            "Tables 4.7 to 4.10: friction found again, by the thesis and here (95 % interval)",
            *columns(RECOVERY_HEADER, recovery_rows(report.recovered)),
            "",
            *_temperature(report),
            "",
            "Step size: position error of the whole antenna on a moving base after a second with reversals",
            *columns(CONVERGENCE_HEADER, convergence_rows(report)),
            "",
            f"wall time of the whole validation: {report.wall_time_s:.1f} s",
        ]
    )


def summary_rows(report: ThesisReport) -> list[list[str]]:
    """Per table: number, loop, axis, overshoot rms and regression bound, settling rms and bound, the same on a level
    base, agreement.
    """
    level = {table.table.number: table for table in report.level_tables}
    rows = []
    for result in report.tables:
        number = result.table.number
        bound, flat = REGRESSION_BOUND.get(number), level.get(number)
        rows.append(
            [
                number,
                result.table.loop.value,
                result.table.axis,
                points(result.overshoot_rms),
                f"{bound.overshoot_points:g}" if bound else "-",
                seconds(result.settling_rms_s),
                f"{bound.settling_s:g}" if bound and bound.settling_s else "-",
                f"{points(flat.overshoot_rms)} / {seconds(flat.settling_rms_s)}" if flat else "-",
                result.agreement.value,
            ]
        )
    return rows


SUMMARY_HEADER = (
    "table",
    "loop",
    "axis",
    "overshoot rms",
    "regression bound",
    "settling rms s",
    "regression bound",
    "level base",
    "agreement",
)
TABLE_HEADER = ("swept", "overshoot thesis %", "here %", "settling thesis s", "here s")


def table_rows(result: TableResult) -> list[list[str]]:
    """Row by row: swept number, overshoot printed and here, settling printed and here."""
    return [
        [
            f"{row.printed.swept:g}",
            f"{row.printed.overshoot_percent:.2f}",
            points(row.overshoot_percent),
            f"{row.printed.settling_s:.2f}",
            seconds(row.settling_s),
        ]
        for row in result.rows
    ]


def points(value: float) -> str:
    """An overshoot in points; of a response that ran away only that it did."""
    return f"{value:.2f}" if value < 100.0 else "> 100"


def seconds(value: float) -> str:
    """A settling time; a dash where the response never stays in the band."""
    return f"{value:.3f}" if math.isfinite(value) else "-"


def columns(header: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """A header and rows as lines with aligned columns."""
    widths = [max(len(row[i]) for row in (header, *rows)) for i in range(len(header))]
    return [
        "  " + "  ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True)) for row in (header, *rows)
    ]


def _summary(report: ThesisReport) -> list[str]:
    return [
        "Controller tables of chapter 5: rms over the rows, thesis against here",
        *wrap(f"{INFERRED} {FITTED}", 120),
        *columns(SUMMARY_HEADER, summary_rows(report)),
    ]


def _table(result: TableResult) -> list[str]:
    table = result.table
    fixed = (
        "prefilter of table 5.11"
        if table.prefilter
        else (f"Kp = {table.kp:g}" if table.kp is not None else f"Ki = {table.ki:g}")
    )
    heavier = f", every inertia times {table.inertia_factor:g}" if table.inertia_factor != 1.0 else ""
    lines = [
        f"Table {table.number}: {table.loop.value} loop, {table.axis} axis, {fixed}{heavier}; swept: {table.swept}"
    ]
    lines += columns(TABLE_HEADER, table_rows(result))
    lines.append(
        f"  rms: overshoot {points(result.overshoot_rms)} points, settling {seconds(result.settling_rms_s)} s: "
        f"{result.agreement.value}"
    )
    return lines + ([f"  why: {result.reason}"] if result.reason else [])


def unbalance_rows(runs: Sequence[UnbalanceRun]) -> list[list[str]]:
    """Per kind, axis and reference: relative swing of the rate in percent for every case."""
    rows: list[list[str]] = []
    for run in runs:
        key = [run.unbalance.value, run.axis, f"{run.reference_rad_s:g}"]
        if not rows or rows[-1][:3] != key:
            rows.append(key)
        rows[-1].append(f"{run.ripple_percent:.2f}")
    return [row + ["-"] * (8 - len(row)) for row in rows]


UNBALANCE_HEADER = ("unbalance", "axis", "rad/s", "case 1", "2", "3", "4", "5")


def _unbalance(report: ThesisReport) -> list[str]:
    lines = [
        "Chapter 3: steady swing of the rate, percent of the reference (none and dynamic: table 3.1, static: table 3.2)"
    ]
    lines += columns(UNBALANCE_HEADER, unbalance_rows(report.unbalance))
    lines += ["  The thesis' claims:"]
    return lines + [
        f"    {'holds        ' if c.holds else 'does not hold'}  {c.text} ({c.evidence})" for c in report.claims
    ]


SLIP_HEADER = (
    "slip",
    "error median",
    "largest",
    "outer dynamic %",
    "inner dynamic %",
    "outer static %",
    "inner static %",
)


def slip_rows(slips: Sequence[SlipEffect], runs: Sequence[UnbalanceRun]) -> list[list[str]]:
    """Per slip: error of the acceleration, and the swing (percent) of chapter 3's hardest cases; first row without any
    slip.
    """
    at = {(r.unbalance, r.axis, r.case): r for r in runs if r.reference_rad_s == 0.1}
    right = [at[Unbalance.DYNAMIC, a, 5] for a in ("outer", "inner")] + [
        at[Unbalance.STATIC, a, 4] for a in ("outer", "inner")
    ]
    rows = [["none", "0", "0", *(f"{run.ripple_percent:.2f}" for run in right)]]
    for effect in slips:
        swings = [f"{run.ripple_percent:.2f}" for run in (*effect.dynamic, *effect.static)]
        name = str(effect.slip.name).lower()
        rows.append([name, f"{effect.median_error:.1%}", f"{effect.largest_error:.0%}", *swings])
    return rows


def _slips(report: ThesisReport) -> list[str]:
    lines = [
        "Slips of the thesis: relative error of the acceleration at random states on a moving base; swing (percent) "
        "of chapter 3's hardest"
    ]
    lines += [
        "cases at 0.1 rad/s with the slip on (chapter 3 has no friction, so the two friction slips change nothing "
        "there)"
    ]
    lines += columns(SLIP_HEADER, slip_rows(report.slips, report.unbalance))
    return lines + [f"  {str(effect.slip.name).lower()}: {effect.where}" for effect in report.slips]


def _friction(curves: Sequence[FrictionCurves]) -> list[str]:
    lines = ["Chapter 4: friction"]
    for c in curves:
        secants = ", ".join(f"{part:.2f} at {share:g} Ts" for share, part in c.secants)
        lines += [
            f"  {c.axis}: minimum of the steady curve at {c.minimum_rad_s:.3f} rad/s",
            f"    eq. 4.3 as printed gives {c.printed_at_fastest_nm:.3g} N m at 0.1 rad/s; damping ratio of sigma1 "
            f"{c.damping_ratio:.3f}",
            f"    stiffness N m/rad: table 4.4 gives {c.stiffness_of_table_4_4:.1f}, the angle of table 4.3 "
            f"{c.stiffness_of_table_4_3:.1f}",
            f"    a secant (eq. 4.11) over sigma0: {secants}",
        ]
    return lines


RECOVERY_HEADER = ("axis", "number", "unit", "true", "thesis", "error %", "here", "error %", "interval")


def recovery_rows(recovered: Sequence[Recovered]) -> list[list[str]]:
    """Per axis and friction number: the true one, what the thesis' fit found again, and what this project found."""
    return [
        [
            found.axis,
            found.symbol,
            found.unit,
            f"{found.true:.5g}",
            f"{found.thesis:.5g}",
            f"{found.thesis_error_percent:+.1f}",
            f"{found.here:.5g}",
            f"{found.error_percent:+.2f}",
            _interval(found.low, found.high),
        ]
        for found in recovered
    ]


def _interval(low: float, high: float) -> str:
    """Both ends with as many digits as their distance has two of."""
    digits = max(0, 1 - math.floor(math.log10(high - low)))
    return f"{low:.{digits}f} to {high:.{digits}f}"


TEMPERATURE_HEADER = ("axis", "degC", "0.001 rad/s", "0.01", "0.1", "lowest N m", "at rad/s")


def temperature_rows(report: ThesisReport) -> list[list[str]]:
    """Per axis and temperature: friction (N m) at three speeds, and the minimum of the curve."""
    rows = []
    for sweeps in report.sweeps:
        for sweep in sweeps:
            lowest = int(sweep.friction_nm.argmin())
            at = [f"{sweep.friction_nm[abs(sweep.rate_rad_s - speed).argmin()]:.4f}" for speed in (0.001, 0.01, 0.1)]
            rows.append(
                [
                    sweep.axis,
                    f"{sweep.temperature_degc:g}",
                    *at,
                    f"{sweep.friction_nm[lowest]:.4f}",
                    f"{sweep.rate_rad_s[lowest]:.4f}",
                ]
            )
    return rows


def _temperature(report: ThesisReport) -> list[str]:
    simulated = sum(sweep.simulated_s for sweeps in report.sweeps for sweep in sweeps)
    lines = [f"Sliding sweeps over temperature (assumed scaling, thesis-temperature.yaml): {simulated:.0f} s simulated"]
    return lines + columns(TEMPERATURE_HEADER, temperature_rows(report))


CONVERGENCE_HEADER = ("plant step ms", "error µrad", "order")


def convergence_rows(report: ThesisReport) -> list[list[str]]:
    """Per step: position error, and the order from the step before."""
    orders = ["-", *(f"{order:.2f}" for order in report.convergence.orders)]
    pairs = zip(report.convergence.step_s, report.convergence.error_rad, orders, strict=True)
    return [[f"{1e3 * step:g}", f"{1e6 * error:.2g}", order] for step, error, order in pairs]
