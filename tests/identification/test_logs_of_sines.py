"""A log that swings all the time, which is what people record first, is no log of constant speeds."""

from __future__ import annotations

import numpy as np
import pytest

from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.identification import Determination, Log, numbers_of_motion
from gimbal_hil.knowledge.identification.evidence import collect
from gimbal_hil.knowledge.identification.segments import stretches_of_table
from tests.change.rig import Machine

MACHINE = Machine()


def log_of(table: SignalsTable) -> Log:
    return Log("log", table, {"joint": stretches_of_table(table, "joint")})


def test_sines_give_inertia_and_friction_and_not_points_of_a_curve_at_their_crests() -> None:
    logs = [log_of(MACHINE.log(np.random.default_rng(1004)))]
    assert collect(logs, MACHINE.model(), "joint").plateaus == ()
    found = {estimate.name: estimate for estimate in numbers_of_motion(logs, MACHINE.model(), "joint")}
    for name, true in (("inertia", 0.02), ("coulomb", 0.05), ("viscous", 0.02)):
        assert found[name].verdict is Determination.IDENTIFIED, name
        assert found[name].value == pytest.approx(true, rel=0.15), name


def test_passes_at_constant_speed_with_turns_between_them_are_plateaus() -> None:
    period_s, each_s, turn_s = 2e-3, 4.0, 1.0
    rates = np.concatenate(
        [
            np.concatenate(
                [
                    np.linspace(-sign * 0.7 * speed, sign * speed, round(turn_s / period_s)),
                    np.full(round(each_s / period_s), sign * speed),
                ]
            )
            for speed in (0.3, 0.8)
            for sign in (1.0, -1.0)
        ]
    )
    position = np.round(np.cumsum(rates) * period_s / 9.6e-5) * 9.6e-5
    torque = 0.05 * np.sign(rates) + 0.02 * rates + 1e-3 * np.random.default_rng(3).standard_normal(len(rates))
    columns = {"joint.torque": torque, "joint.position": position}
    table = SignalsTable.of(("joint",), period_s * np.arange(len(rates)), columns, source="log")
    assert len(collect([log_of(table)], MACHINE.model(), "joint").plateaus) >= 4
