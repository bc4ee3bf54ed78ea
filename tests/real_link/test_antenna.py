"""What the project asks of an antenna on a link, through its own pytest plugin:

    pytest tests/real_link --gimbal-link serial:/dev/ttyUSB0

Without options the virtual antenna in this process. Each axis moves by 0.1 rad about where it stands.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from gimbal_hil.surface.testing import within

if TYPE_CHECKING:
    from gimbal_hil.surface.testing.antennas import AntennaOfTest

_STEP_RAD = 0.1


@pytest.mark.parametrize("place", [0, 1], ids=["carrying axis", "carried axis"])
def test_a_step_is_followed_to_its_end(antenna: AntennaOfTest, place: int) -> None:
    axis, other = antenna.axes[place], antenna.axes[1 - place]
    antenna.wait(0.2)
    start = float(antenna.signal(f"{axis}.position").values[-1])
    beside = float(antenna.signal(f"{other}.position").values[-1])
    step = antenna.step(axis, start + _STEP_RAD, for_s=2.5)
    position = antenna.signal(f"{axis}.position")
    assert position.overshoot(step) < 0.1
    assert position.settles_at(start + _STEP_RAD, within(0.002).for_s(0.5).after(step, 1.8))
    assert antenna.signal(f"{other}.position").stays_at(beside, within(0.01).for_s(2.4).after(step))
    assert antenna.signal(f"{axis}.torque").largest(after=step) < 15.5


def test_encoder_and_gyro_tell_the_same_motion(antenna: AntennaOfTest) -> None:
    axis = antenna.axes[0]
    antenna.wait(0.2)
    start = float(antenna.signal(f"{axis}.position").values[-1])
    antenna.go_to(**{axis: start + _STEP_RAD})
    assert antenna.wait_until(f"{axis}.position", start + _STEP_RAD, within(0.002).for_s(0.3), at_most_s=5.0)
    position, rate = antenna.signal(f"{axis}.position"), antenna.signal(f"{axis}.rate")
    moved = position.values[-1] - position.values[0]
    assert np.trapezoid(rate.values, rate.time_s) == pytest.approx(moved, abs=0.1 * _STEP_RAD)


def test_the_first_second_has_a_row_for_each_tick(antenna: AntennaOfTest) -> None:
    antenna.wait(1.0)
    time_s = antenna.signal(f"{antenna.axes[0]}.position").time_s
    assert len(time_s) > 900 * antenna.settings.rate_hz / 1000.0
