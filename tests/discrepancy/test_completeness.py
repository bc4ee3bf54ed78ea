"""When a gap counts as explained: shares, floors, channels that stand aside, and gains that last."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gimbal_hil.discrepancy.completeness import Half, explains, throughout
from gimbal_hil.discrepancy.smoothing import Bands, Floats

BANDS = Bands(25.0, 1e-3)
ROWS = 3000


def rows(*levels: float) -> Floats:
    """White residual of two or more channels at so many floors each."""
    noise = np.random.default_rng(4).standard_normal((ROWS, len(levels)))
    return np.asarray(noise / np.sqrt(np.mean(noise**2, axis=0)) * np.array(levels))


def halves(before: tuple[float, ...], after: tuple[float, ...], unsteady: float = 0.0) -> tuple[Half, Half]:
    half = Half(rows(*before), rows(*after), lambda: np.full(len(before), unsteady))
    return half, half


@pytest.mark.parametrize(
    ("before", "after", "explained"),
    [
        ((30.0, 1.0), (1.1, 1.0), True),
        # nearly all of a large gap is closed, though not to the floor
        ((30.0, 1.0), (3.0, 1.0), True),
        ((30.0, 1.0), (9.0, 1.0), False),
        # of hundreds of floors, nearly all is still far
        ((300.0, 1.0), (9.0, 1.0), False),
        # near the floor, and yet only half of a small gap: a field that a name resembles
        ((2.0, 1.0), (1.4, 1.0), False),
        ((4.0, 1.0), (1.2, 1.0), True),
        # too little to name anything for
        ((1.6, 1.0), (1.0, 1.0), False),
        # a remainder of its own stands aside, the largest gap does not
        ((30.0, 6.0), (1.1, 6.0), True),
        ((6.0, 30.0), (1.1, 30.0), False),
        # nor may a cause spoil another channel
        ((30.0, 1.0), (1.1, 2.5), False),
    ],
)
def test_what_causes_leave_decides(before: tuple[float, ...], after: tuple[float, ...], explained: bool) -> None:
    assert explains(halves(before, after), caused=True, exact=True, bands=BANDS) is explained


def test_a_twin_that_does_not_repeat_itself_may_leave_more() -> None:
    assert not explains(halves((100.0,), (8.0,)), True, True, BANDS)
    assert explains(halves((100.0,), (8.0,), unsteady=7.0), True, True, BANDS)
    # near the floor as well: what it does not repeat is noise of its own, though not instead of a gap that is closed
    assert not explains(halves((7.0,), (1.9,)), True, True, BANDS)
    assert explains(halves((7.0,), (1.9,), unsteady=1.0), True, True, BANDS)
    assert not explains(halves((3.0,), (1.9,), unsteady=1.0), True, True, BANDS)


@pytest.mark.parametrize(("gap", "quiet"), [(1.0, True), (1.45, True), (1.6, False), (40.0, False)])
def test_without_causes_only_quiet_data_are_explained(gap: float, quiet: bool) -> None:
    assert explains(halves((gap,), (gap,)), caused=False, exact=True, bands=BANDS) is quiet


@given(st.lists(st.floats(0.1, 500.0), min_size=1, max_size=4), st.booleans())
def test_causes_that_close_nothing_explain_nothing(gaps: list[float], exact: bool) -> None:
    before = tuple(gaps)
    assert not explains(halves(before, before), caused=True, exact=exact, bands=BANDS)


def test_both_halves_must_be_explained() -> None:
    good, bad = halves((30.0,), (1.1,))[0], halves((30.0,), (20.0,))[0]
    assert explains((good, good), True, True, BANDS)
    assert not explains((good, bad), True, True, BANDS)
    assert not explains((bad, good), True, True, BANDS)


def test_without_bristles_a_share_is_enough_but_it_must_last() -> None:
    gap = rows(8.0)
    everywhere = Half(gap, 0.8 * gap, lambda: np.zeros(1))
    assert explains((everywhere, everywhere), True, False, BANDS)
    assert not explains((everywhere, everywhere), True, True, BANDS)
    now_and_then = gap.copy()
    now_and_then[: ROWS // 10] *= 0.05
    setting_off = Half(gap, now_and_then, lambda: np.zeros(1))
    assert not explains((setting_off, setting_off), True, False, BANDS)


def test_a_gain_lasts_when_nearly_every_block_gains_however_uneven() -> None:
    gap = rows(1.0) * np.linspace(1.0, 60.0, ROWS)[:, None] ** 2
    assert throughout([(gap, 0.9 * gap)], BANDS)
    assert not throughout([(gap, gap)], BANDS)
    assert not throughout([(gap[:20], 0.1 * gap[:20])], BANDS)
