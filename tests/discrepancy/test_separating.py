"""The run that is proposed must be one that tells the two apart."""

from __future__ import annotations

from gimbal_hil.knowledge.discrepancy.verdict.separating import separating_run, why_not_testable
from sim_backend.effects import CATALOGUE, Need

EXCITED_BY = {name: effect.excited_by for name, effect in CATALOGUE.items()}


def test_cogging_and_an_eccentric_encoder_are_told_apart_by_two_speeds() -> None:
    assert "two constant speeds" in separating_run("cogging", "encoder_eccentricity", EXCITED_BY)
    assert separating_run("cogging", "encoder_eccentricity", EXCITED_BY) == separating_run(
        "encoder_eccentricity", "cogging", EXCITED_BY
    )


def test_every_pair_of_the_catalogue_has_a_run() -> None:
    assert all(separating_run(a, b, EXCITED_BY) for a in CATALOGUE for b in CATALOGUE if a != b)


def test_the_reason_why_an_effect_cannot_be_seen_names_what_is_missing() -> None:
    everything = Need.GYRO | Need.MOVING_BASE | Need.TEMPERATURE | Need.SLIDING
    for effect, need, word in (
        ("gyro_bias", Need.GYRO, "rate column"),
        ("dynamic_unbalance", Need.MOVING_BASE, "base"),
        ("temperature_viscosity", Need.TEMPERATURE, "temperature"),
        ("coulomb", Need.SLIDING, "slides"),
    ):
        assert word in why_not_testable(effect, everything & ~need)
        assert word not in why_not_testable(effect, everything)
