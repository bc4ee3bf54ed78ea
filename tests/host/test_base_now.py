"""The base between two messages of the navigation: rates and angular acceleration of now from rates of before."""

from __future__ import annotations

import math

import numpy as np
import pytest

from firmware_protocol import mail as m
from gimbal_hil.loop.host import layout
from gimbal_hil.loop.host.base_now import extrapolate_base, learn_turning, mean_rates

STEP_S, PERIOD, AGE_S = 1e-3, 10, 0.005
SIZE, TURN = 0.0873, 2.0 * math.pi


def told(frequency_hz: float, ticks: int, gap: range = range(0)) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """H after so many ticks of a base that swings about x, and what was true then: rate, angular acceleration, mean
    rate over 15 ms; without messages in `gap`.
    """
    w = TURN * frequency_hz
    mail = np.zeros(4096, np.int64)
    H, G, C = np.zeros(layout.H_SIZE), np.zeros(layout.G_SIZE, np.int64), np.zeros(layout.C_SIZE)
    C[layout.STEP_S], C[layout.BASE_LOST_TICKS], C[layout.EXTRAPOLATES_BASE] = STEP_S, 100.0, 1.0
    H[layout.NAVIGATION_AGE_S], G[layout.BASE_AGE] = AGE_S, 1_000_000
    for tick in range(ticks):
        if tick % PERIOD == 0 and tick not in gap:
            rate = SIZE * math.sin(w * (tick * STEP_S - AGE_S))
            mail[m.BASE_RATE_P] = round(rate / m.BASE_RATE_P_STEP)
            learn_turning(mail, H, G, C)
            G[layout.BASE_AGE] = 0
            H[layout.BASE_RATES] = mail[m.BASE_RATE_P] * m.BASE_RATE_P_STEP
        else:
            G[layout.BASE_AGE] += 1
        extrapolate_base(mail, H, G, C)
    now = (ticks - 1) * STEP_S
    mean = SIZE * (math.cos(w * (now - 0.015)) - math.cos(w * now)) / (w * 0.015)
    return H, np.array([SIZE * math.sin(w * now), SIZE * w * math.cos(w * now), mean]), G


@pytest.mark.parametrize("ticks", [200, 205, 209, 431, 777])
def test_rate_acceleration_and_mean_rate_are_those_of_now(ticks: int) -> None:
    H, (rate, turning, mean), _ = told(1.0, ticks)
    # what is left: the wire's steps of 0.1 mrad/s, and the acceleration's second change over 20 ms
    assert H[layout.BASE_NOW] == pytest.approx(rate, abs=5e-4)
    assert H[layout.BASE_TURNING] == pytest.approx(turning, abs=0.05)
    assert mean_rates(H, 0.015)[0] == pytest.approx(mean, abs=2.5e-4)


def test_the_acceleration_is_no_longer_fifteen_milliseconds_old() -> None:
    late = np.array([told(1.0, ticks)[0][layout.BASE_TURNING] for ticks in range(1000, 2000, 7)])
    true = np.array([told(1.0, ticks)[1][1] for ticks in range(1000, 2000, 7)])
    # 15 ms of 1 Hz are 9.4 % of it; 4 % are the steps of the wire, differenced twice
    assert np.std(late - true) < 0.045 * np.std(true)


def test_rates_too_far_apart_tell_no_acceleration_and_the_next_two_tell_no_change() -> None:
    lost = range(300, 380)
    assert told(1.0, 382, lost)[0][layout.BASE_TURNING] == 0.0
    H, (_, turning, _), _ = told(1.0, 392, lost)
    assert H[layout.BASE_JERK] == 0.0 and H[layout.BASE_TURNING] == pytest.approx(turning, rel=0.2, abs=0.06)
    H, (_, turning, _), _ = told(1.0, 402, lost)
    assert H[layout.BASE_JERK] != 0.0 and H[layout.BASE_TURNING] == pytest.approx(turning, abs=0.05)
