"""Shared by all tests: hypothesis runs the same examples on every machine, without deadlines; tests in real time are
run again where the machine stood still.
"""

import os
from collections.abc import Iterator, Sequence

import pytest
from hypothesis import HealthCheck, settings

from gimbal_hil.pages.plots import Drawing
from gimbal_hil.pages.report import figures_packed, page
from tests.real_time.repeating import pytest_runtest_protocol, pytest_terminal_summary

__all__ = ["pytest_runtest_protocol", "pytest_terminal_summary"]

settings.register_profile(
    "gimbal", deadline=None, derandomize=True, max_examples=100, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "gimbal"))


@pytest.fixture(autouse=True, scope="session")
def figures_are_plotlys() -> Iterator[None]:
    """Every figure that a test puts on a page is one that plotly's own classes take: each name and value is known."""

    def packed(figures: Sequence[Drawing]) -> str:
        from plotly.graph_objects import Figure as PlotlyFigure

        for figure in figures:
            PlotlyFigure(figure.to_dict())
        return figures_packed.packed(figures)

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(page, "packed", packed)
        yield
