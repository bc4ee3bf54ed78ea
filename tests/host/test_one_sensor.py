"""Position and rate that are two numbers of one sensor do not part, however slowly: what the short window forgets."""

from __future__ import annotations

import numpy as np
import pytest

from firmware_protocol import mail as m
from gimbal_hil.loop.host import Host, HostCause, HostState, Mode, layout
from tests.host.host_loop import HostLoop, configuration, hold

#: nothing but the comparison of angles: 0.1 rad, over 2 s and over 20 s
_SETTINGS = {
    f"{axis}__{key}": value
    for axis in ("outer", "inner")
    for key, value in {
        "expectation": None,
        "limits__stuck_gyro_ticks": None,
        "limits__gyro_encoder_rad_s": None,
        "limits__gyro_encoder_rad": 0.1,
    }.items()
}
_WINDOW_S = 20.0
#: below this a difference of rates is forgotten before it is 0.1 rad in the short window
_SLOW_RAD_S = 0.04


def _moving(window_s: float | None = _WINDOW_S, rates: tuple[float, float] = (0.0, 0.0)) -> HostLoop:
    loop = HostLoop(Host(configuration(**_SETTINGS, supervisor__one_sensor_window_s=window_s))).connected()
    return loop.command(hold(Mode.RATE, 0.1, 0.1)).run(100).command(hold(Mode.RATE, *rates)).run(100)


def _off_by(loop: HostLoop, rate: float, ticks: int, axes: tuple[int, ...] = (0, 1)) -> HostLoop:
    """The rates that are told are off."""
    loop.antenna.gyro_error = [rate if axis in axes else 0.0 for axis in range(2)]
    return loop.run(ticks)


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("rate", [_SLOW_RAD_S, -_SLOW_RAD_S])
def test_a_rate_that_parts_slowly_from_the_position_is_noticed_before_a_tenth_of_a_radian_and_its_share(
    axis: int, rate: float
) -> None:
    loop = _off_by(_moving(), rate, 2200, (axis,))
    assert loop.host.state is HostState.ACTIVE, loop.texts()
    loop.run(800)
    assert (loop.host.state, loop.host.cause) == (HostState.FAULT, HostCause.SENSOR_DRIFT), loop.texts()


def test_without_the_long_window_it_is_a_gyro_s_bias() -> None:
    loop = _off_by(_moving(None), _SLOW_RAD_S, 4000)
    assert loop.host.state is HostState.ACTIVE, loop.texts()


def test_a_share_of_the_path_of_both_axes_may_be_missing() -> None:
    """Four hundredths of it, which is more than the angle itself."""
    loop = _moving(rates=(1.0, 0.0))
    _off_by(loop, -_SLOW_RAD_S, 4000, (0,))
    assert loop.host.state is HostState.ACTIVE, loop.texts()
    assert abs(loop.host.memory.H[layout.axis_h(0) + layout.LONG_DRIFT]) > 0.1


def _coarse(loop: HostLoop) -> HostLoop:
    """Rates are told in whole steps, and what is less than one as none."""
    seen, step = loop.antenna._fill, round(0.05 / m.FEEDBACK_OUTER_RATE_STEP)

    def fill(mail: np.ndarray) -> None:
        seen(mail)
        for slot in (m.FEEDBACK_OUTER_RATE, m.FEEDBACK_INNER_RATE):
            mail[slot] = int(mail[slot] / step) * step

    loop.antenna._fill = fill  # type: ignore[method-assign, assignment]
    return loop


def test_a_rate_that_is_told_in_coarse_steps_may_be_off_by_one() -> None:
    loop = HostLoop(Host(configuration(**_SETTINGS, supervisor__one_sensor_window_s=_WINDOW_S)))
    _coarse(loop).connected().command(hold(Mode.RATE, 0.2, 0.2)).run(100).command(hold(Mode.RATE)).run(100)
    loop.antenna.rate, loop.antenna.friction = [_SLOW_RAD_S] * 2, (0.0, 0.0)
    loop.run(4000)
    assert loop.host.state is HostState.ACTIVE, loop.texts()
    assert abs(loop.host.memory.H[layout.axis_h(0) + layout.LONG_DRIFT]) > 0.1


def test_a_rate_that_never_changed_may_be_too_coarse_to_show_the_motion() -> None:
    loop = HostLoop(Host(configuration(**_SETTINGS, supervisor__one_sensor_window_s=_WINDOW_S)))
    _coarse(loop).connected().command(hold(Mode.RATE)).run(100)
    loop.antenna.rate, loop.antenna.friction = [_SLOW_RAD_S] * 2, (0.0, 0.0)
    loop.run(4000)
    assert loop.host.state is HostState.ACTIVE, loop.texts()
    assert abs(loop.host.memory.H[layout.axis_h(0) + layout.LONG_DRIFT]) > 0.1


def test_after_an_operator_s_reset_angles_are_compared_anew() -> None:
    loop = _off_by(_moving(), _SLOW_RAD_S, 3200)
    assert loop.host.cause is HostCause.SENSOR_DRIFT, loop.texts()
    loop.antenna.gyro_error = [0.0, 0.0]
    loop.run(3000)
    loop.host.reset_fault()
    loop.run(600).command(hold(Mode.RATE)).run(500)
    assert loop.host.state is HostState.ACTIVE, loop.texts()


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("mode", [Mode.RATE, Mode.POSITION])
def test_it_is_noticed_after_the_same_way_in_either_direction(axis: int, mode: Mode) -> None:
    """Of an axis that goes where its rate does not say, and of one that rests while its rate says otherwise."""

    def ticks(rate: float) -> int:
        loop = _moving().command(hold(mode)).run(100)
        _off_by(loop, rate, 2200, (axis,))
        begun = loop.number
        while loop.host.state is HostState.ACTIVE:
            loop.run(1)
            assert loop.number < begun + 2000, loop.texts()
        assert loop.host.cause is HostCause.SENSOR_DRIFT, loop.texts()
        return 2200 + loop.number - begun

    there, back = ticks(_SLOW_RAD_S), ticks(-_SLOW_RAD_S)
    assert there == pytest.approx(back, rel=0.03)


def test_without_the_long_window_a_step_back_into_place_is_none_of_its_matters() -> None:
    narrow = {f"{axis}__limits__gyro_encoder_rad": 0.03 for axis in ("outer", "inner")}
    loop = HostLoop(Host(configuration(**_SETTINGS | narrow))).connected().command(hold(Mode.RATE, 0.1)).run(200)
    assert loop.host.memory.H[layout.axis_h(0) + layout.GYRO_STEP] > 0.0
    loop.host.memory.H[layout.axis_h(0) + layout.DRIFT] = -0.02
    loop.antenna.position[0] += 0.04
    loop.run(3)
    assert loop.host.state is HostState.ACTIVE, loop.texts()
