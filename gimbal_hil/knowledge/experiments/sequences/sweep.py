"""Sweep: the frequency response of each rate loop, open and closed, with margins and coherence.

The joint slides at a bias speed while the sweep goes on, faster than the sweep's amplitude: it never reverses, so that
friction stays smooth and the response is that of the loop and not of stiction. Laps go up and down the travel in turn.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from gimbal_hil.knowledge.experiments import (
    CLOSED_STARTS_DEG,
    OPEN_STARTS_DEG,
    Experiment,
    FrequencyResponse,
    Lap,
    Margins,
    Row,
    Signals,
    Step,
    frequency_response,
    margins_of,
    move_to,
    phase_deg,
    position_hold,
    step_of,
)
from gimbal_hil.knowledge.experiments.sequences.options import SequenceOptions
from gimbal_hil.loop.host import AxisCommand, Mode, Shape
from gimbal_hil.pages.plots import Drawing
from gimbal_hil.pages.report import Block, Callout, Heading, Plot, Table, Text

FIRST_HZ, LAST_HZ = 0.5, 300.0
#: amplitude such that the torque limits are not reached at the last frequency
AMPLITUDE_RAD_S, BIAS_RAD_S = (0.06, 0.06), 0.08
LAP_S, LAPS, SHORT_LAPS = 20.0, 8, 2
RUN_UP_S = 1.0


def build(options: SequenceOptions) -> Experiment:
    """Laps of an exponential chirp on the rate reference of each axis asked for."""
    steps: list[Step] = []
    growth = math.log(LAST_HZ / FIRST_HZ) / LAP_S
    for axis in options.axes:
        start = -0.5 * BIAS_RAD_S * (LAP_S + RUN_UP_S)
        steps.append(
            step_of(
                f"{axis} to its start",
                options.rate_hz,
                4.0,
                options.on_axis(axis, move_to(start, 3.0), move_to(0.0, 3.0)),
            )
        )
        for lap in range(SHORT_LAPS if options.short else LAPS):
            bias = BIAS_RAD_S if lap % 2 == 0 else -BIAS_RAD_S
            run_up = options.on_axis(axis, AxisCommand(Mode.RATE, Shape.HOLD, (bias,)), position_hold(0.0))
            steps.append(step_of(f"{axis} runs up to lap {lap + 1}", options.rate_hz, RUN_UP_S, run_up))
            chirp = AxisCommand(
                Mode.RATE, Shape.CHIRP, (bias, options.by_axis(AMPLITUDE_RAD_S)[axis], FIRST_HZ, growth, LAP_S)
            )
            meaning = {"axis": axis, "lap": lap, "bias_rad_s": bias}
            commands = options.on_axis(axis, chirp, position_hold(0.0))
            steps.append(step_of(f"{axis} lap {lap + 1}", options.rate_hz, LAP_S, commands, meaning, measured=True))
        steps.append(
            step_of(f"{axis} back to the middle", options.rate_hz, 4.0, (move_to(0.0, 3.0), move_to(0.0, 3.0)))
        )
    drawn = frozenset(step.name for step in steps if step.measured)
    return Experiment(
        "sweep", "Frequency response of the rate loops", tuple(steps), measure, conclude, drawn, options.every or 1
    )


def _lap(axis: str, signals: Signals) -> Lap:
    return Lap(float(signals["time_s"][1] - signals["time_s"][0]), signals[f"{axis}.rate_ref"], signals[f"{axis}.rate"])


def measure(step: Step, signals: Signals) -> Row:
    """Margins as one lap alone says them, and the largest torque."""
    axis = step.meaning["axis"]
    lap = _lap(axis, signals)
    response = frequency_response([lap], FIRST_HZ, min(LAST_HZ, 0.4 / lap.period_s))
    return _as_row(margins_of(response)) | {
        "least_coherence": float(np.min(response.coherence)),
        "torque_nm": float(np.max(np.abs(signals[f"{axis}.torque"]))),
    }


def _as_row(margins: Margins) -> Row:
    return {
        "crossover_hz": margins.crossover_hz,
        "phase_margin_deg": margins.phase_margin_deg,
        "phase_crossover_hz": margins.phase_crossover_hz,
        "gain_margin_db": margins.gain_margin_db,
        "bandwidth_hz": margins.bandwidth_hz,
    }


def response_of(axis: str, drawn: Mapping[str, Signals]) -> FrequencyResponse | None:
    """The response that all laps of an axis give together."""
    laps = [_lap(axis, signals) for name, signals in drawn.items() if name.startswith(f"{axis} lap")]
    return frequency_response(laps, FIRST_HZ, min(LAST_HZ, 0.4 / laps[0].period_s)) if laps else None


def conclude(rows: Sequence[Row], drawn: Mapping[str, Signals]) -> list[Block]:
    """For each axis: Bode plots, margins from all laps, their scatter over laps."""
    blocks: list[Block] = []
    for place, axis in enumerate(dict.fromkeys(row["axis"] for row in rows)):
        response = response_of(axis, drawn)
        if response is None:
            continue
        margins = margins_of(response)
        blocks += [Heading(f"Rate loop of the {axis} axis"), _said(margins)]
        blocks.append(
            Plot(
                _figure(place, axis, response),
                "Open loop from the reference and the loop's error; gain, phase, coherence.",
            )
        )
        blocks.append(_table([row for row in rows if row["axis"] == axis], margins))
    blocks.append(
        Text("Each lap is averaged into the spectra; the scatter over laps tells how well a margin is known.")
    )
    return blocks


def _said(margins: Margins) -> Callout:
    if margins.phase_margin_deg is None or margins.crossover_hz is None:
        return Callout("The loop does not cross unit gain where the sweep could measure it.", "warning")
    gain = (
        "no -180 degrees below the last frequency"
        if margins.gain_margin_db is None
        else f"{margins.gain_margin_db:.1f} dB of gain margin"
    )
    return Callout(
        f"Crosses at {margins.crossover_hz:.1f} Hz with {margins.phase_margin_deg:.1f} degrees of phase margin; "
        f"{gain}.",
        "good",
    )


def _table(rows: Sequence[Row], pooled: Margins) -> Table:
    header = (
        "Lap",
        "Crossover [Hz]",
        "Phase margin [deg]",
        "-180 deg at [Hz]",
        "Gain margin [dB]",
        "Bandwidth [Hz]",
        "Torque [N m]",
    )
    columns = ("crossover_hz", "phase_margin_deg", "phase_crossover_hz", "gain_margin_db", "bandwidth_hz", "torque_nm")
    lines = [(f"{row['lap'] + 1}", *(_number(row[name]) for name in columns)) for row in rows]
    together = _as_row(pooled) | {"torque_nm": None}
    return Table(header, [*lines, ("all", *(_number(together[name]) for name in columns))])


def _number(value: float | None) -> str:
    return "–" if value is None else f"{value:.2f}"


def _figure(place: int, axis: str, response: FrequencyResponse) -> Drawing:
    from gimbal_hil.pages.plots import AXIS_COLOURS, REFERENCE, logarithm, stacked

    drawn = stacked(("", "", ""), "frequency [Hz]", ("gain [dB]", "phase [deg]", "coherence"), 190)
    for loop, name, line, start_deg in (
        (response.open, "open", dict(color=AXIS_COLOURS[place]), OPEN_STARTS_DEG),
        (response.closed, "closed", dict(color=REFERENCE, dash="dot"), CLOSED_STARTS_DEG),
    ):
        x = response.frequency_hz
        phase = phase_deg(loop, response.coherence, start_deg)
        drawn.add_scatter(x=x, y=20.0 * np.log10(np.abs(loop)), name=name, line=line, row=1)
        drawn.add_scatter(x=x, y=phase, name=name, line=line, showlegend=False, row=2)
    drawn.add_scatter(
        x=response.frequency_hz,
        y=response.coherence,
        showlegend=False,
        line=dict(color=AXIS_COLOURS[place]),
        row=3,
    )
    drawn.add_hline(y=-180.0, color=REFERENCE, width=1, row=2)
    drawn.update_xaxes(**logarithm(response.frequency_hz))
    return drawn
