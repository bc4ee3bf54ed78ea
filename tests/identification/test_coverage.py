"""Do the intervals of the whole chain cover the truth, with gravity, ripple, noise and wrong priors? `-s` shows the
figures.
"""

from __future__ import annotations

import numpy as np
import pytest

from gimbal_hil.knowledge.identification import (
    LUGRE_NAMES,
    AxisRecord,
    Estimate,
    LugreFriction,
    OutputErrorRule,
    Plateau,
    PreslidingRun,
    fit_output_error,
    fit_presliding,
    fit_static,
    measure_velocity_map,
)
from gimbal_hil.knowledge.identification.axis_motion import centred_torque
from tests.identification.one_axis_rig import (
    ENCODER_STEP,
    OUTER,
    Recorded,
    Rig,
    apply_torque,
    follow_rate,
    plateau_rows,
    pulses,
    slow_ramp,
    there_and_back,
)

TRUE = dict(zip(LUGRE_NAMES, OUTER.values().tolist(), strict=True))
PRIOR = OUTER.with_values(LUGRE_NAMES, OUTER.values() * np.array([1.15, 1.15, 1.6, 1.5, 1.2, 1.25, 0.7]))
RIG = Rig(gravity=0.01, ripple=0.003)
REPEATS = 40


def _chain(seed: int) -> dict[str, Estimate]:
    """All seven estimates of one seed."""
    rng = np.random.default_rng(1000 + seed)
    sliding = follow_rate(RIG, there_and_back(np.geomspace(0.001, 0.1, 12), least_s=6.0, least_rad=0.35), seed)
    torque = centred_torque(sliding.torque)
    plateaus = [
        Plateau(str(rows.start), sliding.time_s[rows], sliding.position[rows], torque[rows], RIG.inertia)
        for rows in plateau_rows(sliding.rate_ref)
    ]
    static = fit_static(measure_velocity_map(plateaus, None, ENCODER_STEP, 1.1e-3).points, prior=PRIOR.static)
    assert static is not None
    level = static.friction.breakaway
    ramp = apply_torque(Rig(), slow_ramp(0.8 * level, 30.0))
    run = PreslidingRun("ramp", ramp.time_s, _jittered(ramp, rng), ramp.torque)
    curve = fit_presliding([run], level, ENCODER_STEP, PRIOR.sigma0, PRIOR.sigma1, False, static.friction)
    assert curve is not None
    known = LugreFriction(static.friction, curve.sigma0.fitted, PRIOR.sigma1)
    pulse = apply_torque(Rig(), pulses(0.12, 4.0))
    record = AxisRecord("pulses", 1e-3, pulse.torque, _jittered(pulse, rng))
    rule = OutputErrorRule(starts=2, seed=seed)
    dynamic = fit_output_error([record], RIG.inertia, known, ("breakaway", "sigma0", "sigma1"), ENCODER_STEP, rule)
    return {e.name: e for e in dynamic.estimates} | {e.name: e for e in static.estimates}


def _jittered(recorded: Recorded, rng: np.random.Generator) -> np.ndarray:
    """Encoder positions with a noise of a third of a step, on the encoder's grid again."""
    noise = rng.normal(0.0, 0.3 * ENCODER_STEP, len(recorded.position))
    return np.asarray(recorded.position + np.round(noise / ENCODER_STEP) * ENCODER_STEP)


@pytest.mark.heavy
def test_intervals_of_the_whole_chain_cover_the_truth_in_at_least_nine_of_ten_repeats() -> None:
    estimates = [_chain(seed) for seed in range(REPEATS)]
    for name, true in TRUE.items():
        found = [one[name] for one in estimates]
        covered = sum(e.interval.covers(true) for e in found)
        errors = np.abs([e.fitted / true - 1.0 for e in found])
        width = float(np.median([0.5 * (e.interval.high - e.interval.low) / true for e in found]))
        said = f"error {100 * np.median(errors):.2f} % (worst {100 * errors.max():.2f}), half width {100 * width:.2f} %"
        print(f"{name}: covered {covered}/{REPEATS}, {said}")
        assert covered >= 0.9 * REPEATS, name
        assert errors.max() < 0.02, name
