"""The sequences on the virtual antenna with its default sensors: what they measure is what the model holds."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from firmware_protocol.errors import BadInputError
from gimbal_hil.knowledge.experiments.conducting import conduct
from gimbal_hil.knowledge.experiments.experiment import Experiment, position_hold, step_of
from gimbal_hil.knowledge.experiments.frequency import margins_of
from gimbal_hil.knowledge.experiments.runner import Outcome
from gimbal_hil.knowledge.experiments.sequences import (
    SequenceOptions,
    breakaway_torques,
    build_experiment,
    gravity_map,
    sliding,
    sweep,
)
from gimbal_hil.knowledge.experiments.step_signals import STEPS_FOLDER
from gimbal_hil.knowledge.identification import friction_of, identify_axis
from gimbal_hil.knowledge.identification.reading import read_logs
from gimbal_hil.knowledge.tuning import AxisDynamics, CascadeLaw
from gimbal_hil.loop.control.layout import Mode
from gimbal_hil.loop.host import AxisCommand, ReferenceOrigin, Shape
from gimbal_hil.loop.settings import shipped_settings
from sim_backend.model import shipped_model
from tests.control.loop_margins import gain_margin_db, phase_margin_deg

SEED = 11
RATE_HZ = 1000.0
MODEL = shipped_model()


@pytest.fixture(scope="module")
def conducted(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str, str], Outcome]:
    """The short variant of a sequence on one axis, run once however many tests look at it."""
    known: dict[tuple[str, str], Outcome] = {}

    def outcome(name: str, axis: str) -> Outcome:
        if (name, axis) not in known:
            experiment = build_experiment(
                name, SequenceOptions(RATE_HZ, (axis,), short=True, breakaway_nm=breakaway_torques(MODEL))
            )
            known[name, axis] = conduct(
                experiment, shipped_settings(), MODEL, SEED, tmp_path_factory.mktemp(f"{name}-{axis}")
            )
        return known[name, axis]

    return outcome


@pytest.mark.parametrize("axis", ["outer", "inner"])
def test_short_sliding_finds_the_curve_of_the_model_within_its_errors(
    conducted: Callable[[str, str], Outcome], axis: str
) -> None:
    pairs = sliding.pairs_of(conducted("sliding", axis).rows, axis)
    truth = friction_of(MODEL, axis).static
    assert len(pairs) == sliding.SHORT_SPEEDS and all(pair.steady for pair in pairs)
    speed, jitter = (np.array([getattr(p, name) for p in pairs]) for name in ("speed_rad_s", "jitter_rad_s"))
    friction, error = (np.array([getattr(p, name) for p in pairs]) for name in ("friction_nm", "friction_error_nm"))
    away = (friction - truth.torque_with_jitter(speed, jitter)) / error
    assert np.max(np.abs(away)) < 4.0
    assert np.sqrt(np.mean(away**2)) < 1.6


def test_sliding_takes_the_inner_axis_gravity_out_although_it_is_seven_times_its_friction(
    conducted: Callable[[str, str], Outcome],
) -> None:
    pairs = sliding.pairs_of(conducted("sliding", "inner").rows, "inner")
    assert all(abs(pair.positional_nm) > 6.0 * pair.friction_nm for pair in pairs)


@pytest.mark.heavy
def test_identification_of_short_sliding_and_presliding_runs_covers_the_model(
    conducted: Callable[[str, str], Outcome],
) -> None:
    axis = "inner"
    folders = [conducted(name, axis).folder for name in ("sliding", "presliding")]
    logs = [log for folder in folders for log in read_logs(folder, MODEL.axes)]
    found = identify_axis(logs, MODEL, axis)
    truth = friction_of(MODEL, axis)
    for name, value in zip((e.name for e in found.estimates), truth.values().tolist(), strict=True):
        estimate = next(e for e in found.estimates if e.name == name)
        # one seed: the interval is 95 %, so a little beyond it is no contradiction
        half = 0.5 * (estimate.interval.high - estimate.interval.low)
        assert abs(estimate.value - value) < max(2.0 * half, 2e-3 * value), name


def test_a_thinned_sequence_leaves_a_table_a_step_that_identification_reads(tmp_path: Path) -> None:
    whole = build_experiment("sliding", SequenceOptions(RATE_HZ, ("outer",), every=20))
    fast = [
        step
        for step in whole.steps
        if step.measured and step.meaning["speed_rad_s"] > 0.06 and step.meaning["pass"] == 0
    ]
    experiment = Experiment(
        whole.name, whole.text, (whole.steps[0], *fast), whole.measure, whole.conclude, every=whole.every
    )
    outcome = conduct(experiment, shipped_settings(), MODEL, SEED, tmp_path)
    assert len(list((tmp_path / STEPS_FOLDER).glob("*.npz"))) == len(fast) == len(outcome.rows)
    logs = read_logs(tmp_path, MODEL.axes)
    found = identify_axis(logs, MODEL, "outer")
    assert found.velocity_map is not None
    truth = friction_of(MODEL, "outer").static
    for point in found.velocity_map.points:
        assert abs(abs(point.torque) - float(truth.torque(np.array([abs(point.rate)]))[0])) < 4.0 * point.standard_error


def test_the_whole_sliding_sequence_has_the_speeds_the_travel_and_the_time_of_the_thesis() -> None:
    experiment = build_experiment("sliding", SequenceOptions(RATE_HZ))
    outer = [step for step in experiment.steps if step.measured and step.meaning["axis"] == "outer"]
    speeds = sorted({step.meaning["speed_rad_s"] for step in outer})
    assert len(speeds) == 45 and speeds[0] == pytest.approx(0.001) and speeds[-1] == pytest.approx(0.1)
    assert sum(speed <= 0.01 for speed in speeds) >= 22
    assert [part.duration_s(RATE_HZ) for part in experiment.parts] == pytest.approx([8130.0, 8130.0], rel=0.01)


def test_every_speed_slides_both_ways_between_the_same_positions_over_the_travel_or_its_ends_and_middle() -> None:
    for speed in np.geomspace(sliding.LOWEST_RAD_S, sliding.HIGHEST_RAD_S, sliding.SPEEDS).tolist():
        passes = sliding.passes_of(speed)
        assert min(one.from_rad for one in passes) == 0.0 and max(one.to_rad for one in passes) == pytest.approx(
            math.radians(75.0)
        )
        whole = all(one.travel_rad == math.radians(75.0) for one in passes)
        middle = [one for one in passes if one.from_rad < 0.5 * math.radians(75.0) < one.to_rad]
        assert whole or (len(passes) == 3 and len(middle) == 1)
        # bristles of the softer axis have settled before anything counts, and most of a pass counts
        assert all(one.margin_rad > 11.0 * 0.2585 / 238.88 and one.travel_rad > 4.0 * one.margin_rad for one in passes)
    steps = [step for step in build_experiment("sliding", SequenceOptions(RATE_HZ, ("inner",))).steps if step.measured]
    for ahead, back in zip(steps[::2], steps[1::2], strict=True):
        assert dict(ahead.meaning) | {"direction": -1} == dict(back.meaning)


def test_the_torque_of_a_thinned_step_is_the_mean_over_all_its_ticks() -> None:
    from gimbal_hil.knowledge.experiments.antenna import LockstepAntenna

    slide = AxisCommand(Mode.POSITION, Shape.RAMP, (0.0, 0.05, 1.0), ReferenceOrigin.START)
    step = step_of("slide", RATE_HZ, 2.005, (slide, position_hold(0.0)))
    followed = []
    for every in (1, 10):
        antenna = LockstepAntenna(shipped_settings(), MODEL, SEED, log_every=every)
        antenna.connect()
        followed.append(antenna.follow(replace(step, every=every), lambda ticks: None))
    fine, thin = (one.signals for one in followed)
    assert len(thin["time_s"]) == 200
    assert thin["outer.torque"] == pytest.approx(fine["outer.torque"][:2000].reshape(-1, 10).mean(axis=1), rel=1e-12)
    assert np.array_equal(thin["outer.position"], fine["outer.position"][:2000:10])
    assert np.array_equal(followed[1].rows, followed[0].rows[followed[0].rows["tick"] % 10 == 0])


@pytest.mark.parametrize("axis", ["outer", "inner"])
def test_presliding_reads_stiffness_and_break_away_from_both_signs(
    conducted: Callable[[str, str], Outcome], axis: str
) -> None:
    rows = conducted("presliding", axis).rows
    truth = friction_of(MODEL, axis)
    stiffness = [row["stiffness_nm_per_rad"] for row in rows if row["kind"] == "loop"]
    assert np.mean(stiffness) == pytest.approx(truth.sigma0, rel=0.05)
    up, down = (
        next(row["breakaway_nm"] for row in rows if row["kind"] == "ramp" and row["direction"] == sign)
        for sign in (1, -1)
    )
    assert 0.5 * (up - down) == pytest.approx(truth.static.breakaway, rel=0.05)


def test_presliding_torques_are_shares_of_the_break_away_torque_that_is_known() -> None:
    known, twice = (
        build_experiment("presliding", SequenceOptions(RATE_HZ, ("inner",), short=True, breakaway_nm={"inner": level}))
        for level in (0.2, 0.4)
    )
    for one, other in zip(known.steps, twice.steps, strict=True):
        assert "amplitude_nm" not in one.meaning or other.meaning["amplitude_nm"] == 2.0 * one.meaning["amplitude_nm"]
    assert any("amplitude_nm" in step.meaning for step in known.steps)


def test_the_gravity_map_finds_the_static_moment_of_the_inner_body(conducted: Callable[[str, str], Outcome]) -> None:
    fit = gravity_map.fitted_gravity(gravity_map.windows_of(conducted("gravity_map", "inner").rows, "inner"))
    weight = 9.81 * MODEL.number("inner", "body.mass")
    assert fit.cosine == pytest.approx(-weight * MODEL.number("inner", "body.cog.x"), rel=1e-3)
    assert fit.sine == pytest.approx(-weight * MODEL.number("inner", "body.cog.z"), rel=1e-2)
    assert abs(fit.constant) < 1e-3


@pytest.mark.parametrize("axis", ["outer", "inner"])
def test_the_margins_of_the_sweep_are_the_computed_ones(conducted: Callable[[str, str], Outcome], axis: str) -> None:
    response = sweep.response_of(axis, conducted("sweep", axis).drawn)
    assert response is not None
    measured = margins_of(response)
    loop = shipped_settings().axes[axis].rate_loop
    inertia = {"outer": MODEL.number("outer", "body.inertia.zz") + MODEL.number("inner", "body.inertia.zz"),
               "inner": MODEL.number("inner", "body.inertia.yy")}[axis]  # fmt: skip
    w = np.geomspace(5.0, 2.0 * math.pi * 450.0, 20_000)
    step_s = 1.0 / RATE_HZ
    rigid = AxisDynamics(inertia, friction_of(MODEL, axis).static.viscous, 0.0, 0.0, 0.0, 0.0)
    computed = CascadeLaw(step_s, 0.0, 0.0, loop.kp_s_per_rad, loop.ki_per_rad).torque(w, rigid)
    phase, crossover = phase_margin_deg(w, computed)
    assert measured.crossover_hz == pytest.approx(crossover / (2.0 * math.pi), rel=0.005)
    assert measured.phase_margin_deg == pytest.approx(phase, abs=0.5)
    # with nothing but the hold in the loop its phase does not reach -180 degrees below half the tick rate
    assert math.isinf(gain_margin_db(w, computed)) and measured.gain_margin_db is None


def test_the_sweep_never_lets_the_joint_reverse() -> None:
    assert max(sweep.AMPLITUDE_RAD_S) < sweep.BIAS_RAD_S


def test_a_base_motion_brings_its_base_with_it(conducted: Callable[[str, str], Outcome]) -> None:
    row = conducted("base_motion", "outer").rows[0]
    assert row["base_rate_rad_s"] == pytest.approx(math.radians(15.0) * math.sqrt(3.0), rel=1e-2)
    assert row["outer_error_rms_rad"] < 1e-3 and row["outer_torque_rms_nm"] > 5.0


@pytest.mark.parametrize("name", ["3.1/6", "3.2/0", "nothing.csv"])
def test_a_base_motion_that_does_not_exist_is_refused(name: str) -> None:
    with pytest.raises(BadInputError, match="base"):
        build_experiment("base_motion", SequenceOptions(RATE_HZ, base=name))


def test_warm_up_shows_no_change_where_friction_does_not_depend_on_temperature(
    conducted: Callable[[str, str], Outcome],
) -> None:
    from gimbal_hil.knowledge.experiments.sequences.warm_up import laps_of

    laps = laps_of(conducted("warm_up", "inner").rows, "inner")
    assert len(laps) == 10
    # the first lap settles a loop that starts from rest
    friction = [lap["friction_nm"] for lap in laps[1:]]
    assert np.ptp(friction) < 5e-4
