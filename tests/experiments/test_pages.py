"""What the pages of experiments draw and say, from signals whose answer is known."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest

from gimbal_hil.knowledge.experiments import OPEN_STARTS_DEG, phase_deg
from gimbal_hil.knowledge.experiments.planned import DRAWN_S, _drawn, experiment_of_file
from gimbal_hil.knowledge.experiments.sequences import SequenceOptions, build_experiment
from gimbal_hil.knowledge.experiments.sequences.gravity_map import GravityFit, told
from gimbal_hil.pages.report import Callout, Details, Plot, Table, plots_in
from sim_backend.shipped import shipped_file


def lag(frequency_hz: np.ndarray) -> np.ndarray:
    """An integrator with a delay of 8 ms: -90 degrees at the start, -700 at the end."""
    return np.exp(-2j * np.pi * frequency_hz * 8e-3) / (2j * np.pi * frequency_hz)


def test_the_phase_of_an_open_loop_starts_at_minus_ninety_whatever_noise_stands_before_it() -> None:
    frequency = np.geomspace(0.5, 200.0, 100)
    loop, coherence = lag(frequency), np.ones(100)
    truth = -90.0 - 360.0 * frequency * 8e-3
    # bands that the sweep did not reach say anything: each would have shifted all behind it by a turn
    for noisy in itertools.product((1.0, -1.0, 1j), repeat=3):
        loop[:3], coherence[:3] = noisy, 0.01
        assert phase_deg(loop, coherence, OPEN_STARTS_DEG)[3:] == pytest.approx(truth[3:], abs=1e-6)
    loop[50], coherence[50] = 1.0, 0.05
    assert phase_deg(loop, coherence, OPEN_STARTS_DEG)[51:] == pytest.approx(truth[51:], abs=1e-6)


def stepped(target: float, start: float) -> dict[str, np.ndarray]:
    """A second-order response with 16 % of overshoot, and an axis that rests."""
    time = np.arange(2500) * 1e-3 + 7.0
    t = time - 7.0
    progress = 1.0 - np.exp(-6.0 * t) * (np.cos(10.4 * t) + 6.0 / 10.4 * np.sin(10.4 * t))
    position = start + (target - start) * progress
    still = np.zeros_like(t)
    return {
        "time_s": time,
        **{f"outer.{name}": still for name in ("rate", "torque")},
        "outer.position": position,
        "outer.position_ref": np.full_like(t, target),
        **{f"inner.{name}": still for name in ("position", "rate", "torque", "position_ref")},
    }


def test_the_page_of_steps_draws_every_step_with_its_peak_band_and_settling_marked() -> None:
    experiment = build_experiment("step", SequenceOptions(1000.0, ("outer",)))
    measured = [step for step in experiment.steps if step.measured]
    rows, drawn = [], {}
    for step in measured:
        drawn[step.name] = stepped(step.meaning["to_rad"], step.meaning["from_rad"])
        rows.append({"step": step.name, **step.meaning, **(experiment.measure(step, drawn[step.name]) or {})})
    assert {step.name for step in measured} == set(experiment.drawn) == set(drawn)
    plots = list(plots_in(experiment.conclude(rows, drawn)))
    assert [plot.figure.layout["title"]["text"] for plot in plots] == [step.name for step in measured]
    for plot, row in zip(plots, rows, strict=True):
        (peak,) = (trace for trace in plot.figure.data if trace.get("name") == "peak")
        assert (peak["y"][0] - row["from_rad"]) / (row["to_rad"] - row["from_rad"]) == pytest.approx(
            1.0 + 0.01 * row["overshoot_percent"]
        )
        assert row["overshoot_percent"] == pytest.approx(16.3, abs=0.2) and "16.3" in peak["text"][0]
        lines = [shape for shape in plot.figure.layout["shapes"] if shape["x0"] == shape["x1"]]
        assert [line["x0"] for line in lines] == [row["settling_s"]]
        assert f"{row['settling_s']:.3f} s" in plot.caption


def test_the_slowest_step_stands_open_and_the_others_are_folded() -> None:
    experiment = build_experiment("step", SequenceOptions(1000.0, ("outer",)))
    measured = [step for step in experiment.steps if step.measured]
    drawn = {step.name: stepped(step.meaning["to_rad"], step.meaning["from_rad"]) for step in measured}
    rows = [{"step": one.name, **one.meaning, **(experiment.measure(one, drawn[one.name]) or {})} for one in measured]
    rows[2]["settling_s"] = None
    blocks = experiment.conclude(rows, drawn)
    assert isinstance(blocks[0], Callout) and blocks[0].tone == "warning"
    assert isinstance(blocks[1], Plot) and blocks[1].figure.layout["title"]["text"] == rows[2]["step"]
    folded = [block for block in blocks if isinstance(block, Details)]
    assert [fold.summary for fold in folded] == [f"Step {rows[k]['step']}" for k in (0, 1, 3)]


def test_a_step_that_does_not_settle_has_no_line_and_says_so() -> None:
    experiment = build_experiment("step", SequenceOptions(1000.0, ("outer",)))
    step = next(step for step in experiment.steps if step.measured)
    signals = stepped(step.meaning["to_rad"] * 0.9, step.meaning["from_rad"])
    row = {"step": step.name, **step.meaning, **(experiment.measure(step, signals) or {})}
    (plot,) = plots_in(experiment.conclude([row], {step.name: signals}))
    assert "not settled" in plot.caption
    assert not [shape for shape in plot.figure.layout["shapes"] if shape["x0"] == shape["x1"]]


def test_a_plan_of_ones_own_gets_an_answer_a_plot_of_each_axis_and_then_its_table() -> None:
    experiment = experiment_of_file(shipped_file("plans", "two_speeds.yaml"), 1000.0)
    names = [step.name for step in experiment.steps if step.measured]
    assert set(names) == set(experiment.drawn)
    drawn = {name: stepped(1.0, 0.0) for name in names}
    rows = [
        {"step": step.name} | (experiment.measure(step, drawn[step.name]) or {})
        for step in experiment.steps
        if step.measured
    ]
    blocks = experiment.conclude(rows, drawn)
    assert [type(block) for block in blocks] == [Callout, Plot, Plot, Table]
    assert blocks[0].text.startswith("4 segments measured. Outer: 0 to 1 rad")
    assert [plot.figure.layout["title"]["text"] for plot in plots_in(blocks)] == ["The outer axis", "The inner axis"]
    # a gap stands between segments, so that no line leads from one to the next
    (position,) = (t for t in blocks[1].figure.data if t["name"] == "measured" and t["yaxis"] == "y")
    assert int(np.isnan(position["y"]).sum()) == len(names)


def test_a_plan_that_measures_nothing_is_drawn_all_the_same(tmp_path: Path) -> None:
    text = shipped_file("plans", "two_speeds.yaml").read_text(encoding="utf-8")
    path = tmp_path / "own.yaml"
    path.write_text(text.replace("measure: true", "measure: false"))
    experiment = experiment_of_file(path, 1000.0)
    assert experiment.drawn
    blocks = experiment.conclude([], {name: stepped(1.0, 0.0) for name in experiment.drawn})
    assert len(list(plots_in(blocks))) == 2


def test_a_long_plan_is_drawn_as_far_as_memory_goes() -> None:
    experiment = experiment_of_file(shipped_file("plans", "two_speeds.yaml"), 1000.0)
    measured = [step for step in experiment.steps if step.measured]
    seconds = sum(step.segment.duration_ticks for step in measured if step.name in experiment.drawn) / 1000.0
    assert 0.0 < seconds <= DRAWN_S
    # at a lower rate the same ticks take longer
    whole = sum(step.segment.duration_ticks for step in measured) / 1000.0
    drawn = _drawn(experiment.steps, 1000.0 * whole / (4.0 * DRAWN_S))
    assert 0 < len(drawn) < len(measured)


@pytest.mark.parametrize(
    ("fit", "words"),
    [
        (GravityFit(0.0, 0.0, 0.0, 2e-4, (3e-5, 4e-5, 5e-5)), "No holding torque that depends on position"),
        (GravityFit(1e-9, -1e-9, 0.0, 0.0), "No holding torque that depends on position"),
        (GravityFit(1e-5, 0.0123, -2e-5, 2e-4, (3e-5, 4e-5, 5e-5)), "Holding torque 12.30 cos q mN m"),
        (GravityFit(0.0, -1.03856, -0.38647, 2e-6, (1e-6,) * 3), "Holding torque -1.0386 cos q - 0.3865 sin q N m"),
        (
            GravityFit(-0.0012, 0.0123, 0.0005, 2e-4, (3e-5, 4e-5, 5e-5)),
            "Holding torque -1.20 + 12.30 cos q + 0.50 sin q mN m",
        ),
    ],
)
def test_gravity_is_told_with_the_terms_that_are_there(fit: GravityFit, words: str) -> None:
    said = told(fit)
    assert said.startswith(words)
    assert "0.00 cos" not in said and "0.0000" not in said
