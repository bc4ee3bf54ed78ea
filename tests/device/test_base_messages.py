"""What the antenna tells of its base: true at the stated time, however old, and with the pivot's acceleration."""

from __future__ import annotations

from pathlib import Path

import pytest

from firmware_protocol.messages import BaseAcceleration, BaseAttitude, BaseHeading, BaseRate
from sim_backend.device import Device
from sim_backend.model import shipped_model
from tests.device.bench import FrameWire

ROWS_S = 0.01


def told(folder: Path, age_s: float, ticks: int = 400) -> list[tuple[int, object]]:
    """Every message of a base that rolls by 0.2 rad/s^2 and pushes forward by 3 m/s^3, with the tick of its sample."""
    lines = ["time_s,roll,pitch,yaw,ax,ay,az"]
    lines += [f"{t},{0.1 * t * t},0,{0.3 * t},{3.0 * t},0,-1.5" for t in (ROWS_S * i for i in range(120))]
    (folder / "base.csv").write_text("\n".join(lines))
    base = {"motion": "recorded", "file": str(folder / "base.csv"), "ins_age_s": age_s}
    device, wire = Device(shipped_model().with_base(base)), FrameWire()
    return [(device.drive.tick, message) for _ in range(ticks) for message in wire.exchange(device, [])]


@pytest.mark.parametrize("age_s", [0.0, 0.005, 0.0123])
def test_the_heading_tells_when_the_attitude_was_true(tmp_path: Path, age_s: float) -> None:
    headings = [(tick, m) for tick, m in told(tmp_path, age_s) if isinstance(m, BaseHeading)][3:]
    assert headings
    for tick, message in headings:
        valid = (message.valid_tick + message.valid_fraction_ticks) * 1e-3
        # the heading comes a tick after the attitude was taken
        assert valid == pytest.approx((tick - 1) * 1e-3 - age_s, abs=5e-6)
        assert message.yaw_rad == pytest.approx(0.3 * ((tick - 1) * 1e-3 - age_s), abs=2e-6)


def test_rates_attitude_and_acceleration_are_all_as_old(tmp_path: Path) -> None:
    found = [(tick, m) for tick, m in told(tmp_path, 0.005) if tick > 50]
    rates = [(tick, m) for tick, m in found if isinstance(m, BaseRate)]
    rolls = [(tick, m) for tick, m in found if isinstance(m, BaseAttitude)]
    pushes = [(tick, m) for tick, m in found if isinstance(m, BaseAcceleration)]
    assert rates and rolls and pushes
    for tick, rate in rates:
        assert rate.p_rad_s == pytest.approx(0.2 * (tick * 1e-3 - 0.005), abs=2e-4)
    for tick, roll in rolls:
        assert roll.roll_rad == pytest.approx(0.1 * (tick * 1e-3 - 0.005) ** 2, abs=1e-5)
    for tick, push in pushes:
        assert push.ax_m_s2 == pytest.approx(3.0 * (tick * 1e-3 - 0.005), abs=2e-3)
        assert push.az_m_s2 == pytest.approx(-1.5, abs=2e-3)


def test_a_base_that_does_not_shift_tells_no_acceleration() -> None:
    device, wire = Device(shipped_model()), FrameWire()
    pushes = [m for _ in range(100) for m in wire.exchange(device, []) if isinstance(m, BaseAcceleration)]
    assert pushes and all((m.ax_m_s2, m.ay_m_s2, m.az_m_s2) == (0.0, 0.0, 0.0) for m in pushes)
