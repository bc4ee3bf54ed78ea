"""LuGre friction: its static map, its spring, its break-away, its loops, and the drift that it is known for."""

from __future__ import annotations

import math

import numpy as np
import pytest

from firmware_protocol.compiling import entry_point
from sim_backend.friction import BUMP_GONE, decay_half, lugre_step, stribeck_level, stribeck_share
from sim_backend.layout import P_SIZE
from sim_backend.stribeck_expansion import bump_share, has_bump_table, put_bump_table

mpmath = pytest.importorskip("mpmath", reason="mpmath is not installed (the extra test has it)")

TS, TC, VS, SIGMA0, SIGMA1, SIGMA2, DELTA = 0.2585, 0.2412, 0.0054, 238.88, 16.02, 0.0609, 1.0459
H = 1e-4


@entry_point
def along(rate: np.ndarray, z: float, h: float, sigma1: float, force: np.ndarray, bristle: np.ndarray) -> None:
    """Friction along rates (n,), each held for h seconds, from a bristle deflection."""
    for k in range(rate.shape[0]):
        level = stribeck_level(abs(rate[k]), TS, TC, VS, DELTA)
        z, force[k] = lugre_step(z, rate[k], h, level, SIGMA0, sigma1, SIGMA2)
        bristle[k] = z


@entry_point
def pushed(torque: np.ndarray, inertia: float, h: float, position: np.ndarray, rate: np.ndarray) -> None:
    """A body on this friction under torques (n,): semi-implicit steps."""
    q, v, z = 0.0, 0.0, 0.0
    for k in range(torque.shape[0]):
        z, force = lugre_step(z, v, h, stribeck_level(abs(v), TS, TC, VS, DELTA), SIGMA0, SIGMA1, SIGMA2)
        v += h * (torque[k] - force) / inertia
        q += h * v
        position[k], rate[k] = q, v


def friction(rate: np.ndarray, z: float = 0.0, h: float = H, sigma1: float = SIGMA1) -> tuple[np.ndarray, np.ndarray]:
    force, bristle = np.zeros(len(rate)), np.zeros(len(rate))
    along(np.ascontiguousarray(rate, dtype=float), z, h, sigma1, force, bristle)
    return force, bristle


def motion(torque: np.ndarray, inertia: float = 0.4386, h: float = H) -> tuple[np.ndarray, np.ndarray]:
    position, rate = np.zeros(len(torque)), np.zeros(len(torque))
    pushed(np.ascontiguousarray(torque, dtype=float), inertia, h, position, rate)
    return position, rate


def level(rate: float) -> float:
    return TC + (TS - TC) * math.exp(-((abs(rate) / VS) ** DELTA))


@pytest.mark.parametrize("rate", [-1.0, -0.02, -0.001, 0.0005, 0.005, 0.0207, 0.1, 10.0])
def test_steady_sliding_follows_the_static_map(rate: float) -> None:
    travel = 40.0 * TS / SIGMA0
    force, _ = friction(np.full(max(2, int(travel / abs(rate) / H)), rate))
    assert force[-1] == pytest.approx(math.copysign(level(rate), rate) + SIGMA2 * rate, rel=1e-7)


def test_the_static_map_has_its_minimum_at_twenty_milliradians_a_second() -> None:
    rates = np.geomspace(1e-3, 0.1, 2000)
    torque = np.array([level(v) + SIGMA2 * v for v in rates])
    assert rates[torque.argmin()] == pytest.approx(0.0207, abs=0.0005)


def test_small_displacements_meet_a_spring_of_stiffness_sigma0() -> None:
    rate = np.full(1000, 1e-7)
    force, _ = friction(rate, sigma1=0.0)
    displacement = (np.arange(1000) + 0.5) * 1e-7 * H
    np.testing.assert_allclose((force - SIGMA2 * 1e-7) / displacement, SIGMA0, rtol=1e-4)


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9, 0.98])
def test_presliding_displacement_follows_the_logarithm_so_that_a_secant_is_too_soft(share: float) -> None:
    # near zero rate s(v) = Ts, and z' = v (1 - sigma0 z / Ts) integrates to z = Ts/sigma0 (1 - exp(-sigma0 x / Ts))
    x = -TS / SIGMA0 * math.log(1.0 - share)
    steps = 20000
    rate = np.full(steps, x / (steps * H))
    _, bristle = friction(rate, sigma1=0.0)
    slow = level(rate[0])
    assert SIGMA0 * bristle[-1] == pytest.approx(slow * (1.0 - math.exp(-SIGMA0 * x / slow)), rel=1e-9)
    secant = SIGMA0 * bristle[-1] / x / SIGMA0
    assert secant == pytest.approx({0.1: 0.95, 0.5: 0.72, 0.9: 0.39, 0.98: 0.25}[share], abs=0.01)


def test_break_away_torque_falls_with_the_rate_of_the_ramp_and_stays_between_the_levels() -> None:
    peaks = []
    for ramp in (0.003, 0.01, 0.1, 1.0):
        _, rate = motion(ramp * H * np.arange(int(0.6 / ramp / H)))
        peaks.append(SIGMA0 * float(friction(rate)[1].max()))
    # the slowest ramp nearly reaches Ts; the faster the ramp, the further the bump has melted when the bristles let go
    assert TS > peaks[0] > 0.97 * TS
    assert np.all(np.diff(peaks) < 0.0) and peaks[-1] > TC * 0.999


def test_the_loop_around_zero_speed_is_wider_the_faster_the_velocity_turns() -> None:
    widths = []
    for period in (10.0, 2.0, 0.4):
        n = int(period / H)
        rate = 0.02 * np.sin(2.0 * np.pi * np.arange(2 * n) / n)
        force, _ = friction(rate)
        rising, falling = force[n : n + n // 4], force[n + n // 4 : n + n // 2][::-1]
        widths.append(float(np.mean(np.abs(falling - rising))))
    assert widths[0] < widths[1] < widths[2]


def test_a_closed_presliding_loop_takes_energy_every_cycle() -> None:
    n = 20000
    displacement = 0.3 * TS / SIGMA0 * np.sin(2.0 * np.pi * np.arange(3 * n) / n)
    rate = np.gradient(displacement, H)
    force, _ = friction(rate)
    work = np.cumsum(force * rate) * H
    per_cycle = [work[(k + 1) * n - 1] - work[k * n] for k in (1, 2)]
    assert per_cycle[0] > 0.0
    assert per_cycle[1] == pytest.approx(per_cycle[0], rel=1e-2)


def test_this_friction_forgets_an_inner_loop_it_has_no_non_local_memory() -> None:
    # out to a, back to b, out again through a: a model with non-local memory is back on the first branch at a, LuGre is
    # not
    a, b, steps = 0.6 * TS / SIGMA0, 0.3 * TS / SIGMA0, 30000
    path = np.concatenate([np.linspace(0.0, a, steps), np.linspace(a, b, steps)[1:], np.linspace(b, a, steps)[1:]])
    _, bristle = friction(np.diff(path) / H, sigma1=0.0)
    first, again = bristle[steps - 2], bristle[-1]
    assert again < first * 0.99


def test_under_a_bias_below_break_away_a_vibration_makes_it_drift() -> None:
    t = H * np.arange(200000)
    bias, swing = 0.5 * TS, 0.4 * TS
    position, _ = motion(bias + swing * np.sin(2.0 * np.pi * 2.0 * t) * (t > 2.0))
    still, _ = motion(np.full(len(t), bias))
    cycle = int(0.5 / H)
    creep = position[-1] - position[-1 - 10 * cycle]
    # a real joint would not creep: known of LuGre (Dupont et al. 2002), and shown here so that nobody is surprised
    assert creep > 0.05 * TS / SIGMA0
    assert still[-1] - still[-1 - 10 * cycle] < 1e-6 * creep + 1e-12


@pytest.mark.parametrize("rate", [0.003, 0.5, 5.0, 30.0])
def test_one_step_is_exact_at_any_size(rate: float) -> None:
    # the bristle equation at constant rate is linear: z -> s/sigma0 with time constant s / (sigma0 v)
    start, long = 0.3 * TS / SIGMA0, 0.02
    force, bristle = friction(np.array([rate]), start, long)
    settled, decay = level(rate) / SIGMA0, SIGMA0 * rate / level(rate)
    end = settled + (start - settled) * math.exp(-decay * long)
    mean = settled + (start - settled) * (1.0 - math.exp(-decay * long)) / (decay * long)
    assert bristle[0] == pytest.approx(end, rel=1e-12)
    assert force[0] == pytest.approx(SIGMA0 * mean + SIGMA1 * (end - start) / long + SIGMA2 * rate, rel=1e-12)


def test_many_short_steps_pass_the_same_impulse_as_one_long_step() -> None:
    for rate in (0.01, 1.0, 10.0):
        once, one = friction(np.array([rate]), 0.0, 1e-3)
        often, many = friction(np.full(1000, rate), 0.0, 1e-6)
        assert many[-1] == pytest.approx(one[0], rel=1e-11)
        assert often.mean() == pytest.approx(once[0], rel=1e-10)


def test_friction_stays_bounded_at_rates_where_explicit_steps_diverge() -> None:
    # explicit Euler needs sigma0 |v| h / s < 2: at 1 kHz that ends at 2.02 rad/s
    force, bristle = friction(np.full(1000, 50.0), 0.0, 1e-3)
    assert pytest.approx(2.02, abs=0.01) == 2.0 * TC / (SIGMA0 * 1e-3)
    assert np.abs(bristle).max() <= TC / SIGMA0 * (1.0 + 1e-12)
    assert force[-1] == pytest.approx(TC + SIGMA2 * 50.0, rel=1e-9)


def test_friction_is_odd_in_the_motion() -> None:
    rate = np.random.default_rng(2).normal(size=2000) * 0.05
    np.testing.assert_array_equal(friction(-rate)[0], -friction(rate)[0])


def test_without_bristles_friction_is_the_static_curve() -> None:
    for rate, sign in ((0.3, 1.0), (-0.3, -1.0), (0.0, 0.0)):
        assert lugre_step(0.0, rate, H, level(rate), 0.0, 0.0, SIGMA2)[1] == pytest.approx(
            sign * level(rate) + SIGMA2 * rate
        )


@entry_point
def shares(P: np.ndarray, ratios: np.ndarray, delta: float, out: np.ndarray) -> None:
    """The share at each ratio, (n,), by the second axis' table and by the law itself into out (2, n)."""
    for k in range(ratios.shape[0]):
        out[0, k] = bump_share(P, 1, has_bump_table(P, 1, delta), ratios[k], delta)
        out[1, k] = stribeck_share(ratios[k], delta)


@pytest.mark.parametrize("delta", [0.1, 0.5, 1.0, 1.0459, 1.4628, 2.0, 3.5])
def test_the_table_of_the_bump_is_the_bump_to_double_precision(delta: float) -> None:
    P = np.zeros(P_SIZE)
    put_bump_table(P, 1, delta)
    assert has_bump_table(P, 1, delta) == (delta <= 2.0) and not has_bump_table(P, 0, delta)
    # inside cells, on their borders and beside them, and beyond both ends of the table
    borders = np.exp2(np.arange(-14, 8))[:, None] * (1.0 + np.arange(64) / 64)
    last = BUMP_GONE ** (1.0 / delta)
    ratios = np.concatenate(
        [[0.0], np.geomspace(1e-6, last, 5000), borders.ravel(), np.nextafter(borders.ravel(), 0.0)]
    )
    ratios = ratios[ratios <= last]
    exact = [math.exp(-(ratio**delta)) for ratio in ratios.tolist()]
    found = np.zeros((2, len(ratios)))
    shares(P, ratios, delta, found)
    # the library's own power has an error of 1e-16 times its exponent
    np.testing.assert_allclose(found, [exact, exact], rtol=0.0, atol=1e-15)


def test_the_mean_of_a_decay_is_exact_on_both_sides_of_its_polynomial() -> None:
    with mpmath.workprec(120):
        for x in [*np.geomspace(1e-12, 0.2499, 300), *np.geomspace(0.25, 60.0, 300)]:
            exact = (1 - (1 - mpmath.exp(-mpmath.mpf(x))) / mpmath.mpf(x)) / mpmath.mpf(x)
            assert decay_half(x) == pytest.approx(float(exact), rel=3e-15)
    assert decay_half(0.0) == 0.5
