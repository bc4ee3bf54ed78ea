"""Numbers that keep their prior, and what the others are worth beside them."""

from __future__ import annotations

import numpy as np
import pytest

from gimbal_hil.knowledge.identification import settled
from gimbal_hil.knowledge.identification.estimate import Determination, Interval
from gimbal_hil.knowledge.identification.least_squares import LeastSquaresFit, Unknown, fit
from gimbal_hil.knowledge.identification.profile import ProfileTask
from gimbal_hil.knowledge.identification.settled import Asked, settle_parameters

NAMES = ("first", "second", "third")
PRIORS = (1.0, 1.0, 1.0)


def _task() -> ProfileTask:
    """The first two are seen by their sum, 6, the third as three times the second; at 2, 4 and 12 all is in place."""

    def residuals(x: np.ndarray) -> np.ndarray:
        return np.array([x[0] + x[1] - 6.0, 10.0 * (x[2] - 3.0 * x[1]), 0.01 * (x[0] - 2.0), 0.01 * (x[2] - 12.0)])

    unknowns = [Unknown(name, 1e-3, 1e3) for name in NAMES]
    best: LeastSquaresFit = fit(residuals, unknowns, [np.array([2.0, 4.0, 12.0])])
    return ProfileTask(residuals, unknowns, best)


@pytest.fixture
def intervals(monkeypatch: pytest.MonkeyPatch) -> dict[int, Interval]:
    """What profiles say, by place."""
    said: dict[int, Interval] = {}
    monkeypatch.setattr(settled, "profile_interval", lambda task, index: said[index])
    return said


def _asked() -> list[Asked]:
    return [Asked(name, "N m", prior, f"a run for {name}") for name, prior in zip(NAMES, PRIORS, strict=True)]


def test_what_is_too_wide_for_its_value_beside_a_prior_keeps_its_own_prior(intervals: dict[int, Interval]) -> None:
    # the first is open: at its prior of 1 the second comes to 5 and the third to 15, for which 11 to 13 is narrow
    intervals |= {0: Interval(0.1, 9.0), 1: Interval(3.9, 4.1), 2: Interval(11.0, 13.0)}
    found, best = settle_parameters(_task(), _asked())
    assert found[0].verdict is Determination.NOT_IDENTIFIED and found[0].value == 1.0
    assert found[1].value == pytest.approx(5.0, rel=1e-3) and found[1].interval.high == pytest.approx(5.0, rel=1e-3)
    assert found[2].value == pytest.approx(15.0, rel=1e-3) and best.values[2] == pytest.approx(15.0, rel=1e-3)

    # the third is open: beside its prior of 1 the second comes to a third, and 0.1 to 7.9 is too wide for that
    intervals |= {0: Interval(1.9, 2.1), 1: Interval(0.1, 7.9), 2: Interval(0.1, 99.0)}
    found, best = settle_parameters(_task(), _asked())
    assert [one.verdict is Determination.NOT_IDENTIFIED for one in found] == [False, True, True]
    second = found[1]
    assert second.value == 1.0 and second.fitted == pytest.approx(4.0, rel=1e-3)
    assert "beside the priors of others it comes to 0.33" in second.reason and second.experiment == "a run for second"
    assert (second.interval.low, second.interval.high) == (0.1, 7.9)
    # and the first is told beside both priors
    assert found[0].value == pytest.approx(5.0, rel=1e-3) == best.values[0]


def test_intervals_are_stretched_over_the_last_values_only(intervals: dict[int, Interval]) -> None:
    # beside the third's prior alone the first comes to 5.67; beside both it comes to 5
    intervals |= {0: Interval(1.9, 2.1), 1: Interval(0.1, 7.9), 2: Interval(0.1, 99.0)}
    found, _ = settle_parameters(_task(), _asked())
    assert found[0].interval.high == pytest.approx(5.0, rel=1e-3)
