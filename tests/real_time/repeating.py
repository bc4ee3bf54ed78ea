"""A test in real time that failed while the machine stood still is run again.

A host that is kept from running for a quarter of a second is rightly taken for dead by its antenna, so no patience of a
test makes up for such a stall. A test marked `realtime` that fails beside one is run again, at most three times in all;
one that fails without a stall, or every time, has failed. Each repetition is told at the end of the run.
"""

from __future__ import annotations

import time
from functools import cache

import pytest
from _pytest.runner import runtestprotocol

from tests.real_time.stall_watch import STALL_S, StallWatch

TRIES = 3
the_watch = cache(StallWatch)
_REPEATED = "repeated after a stall of"


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_protocol(item: pytest.Item, nextitem: pytest.Item | None) -> bool | None:
    """The protocol of one test in real time; None leaves every other test to pytest."""
    if item.get_closest_marker("realtime") is None:
        return None
    watch = the_watch()
    item.ihook.pytest_runtest_logstart(nodeid=item.nodeid, location=item.location)
    for attempt in range(1, TRIES + 1):
        began = time.monotonic()
        reports = runtestprotocol(item, nextitem=nextitem, log=False)
        if attempt == TRIES or not any(report.failed for report in reports):
            break
        stall_s = watch.longest_since(began)
        if stall_s < STALL_S:
            break
        item.user_properties.append((_REPEATED, f"{stall_s * 1e3:.0f} ms"))
    for report in reports:
        item.ihook.pytest_runtest_logreport(report=report)
    item.ihook.pytest_runtest_logfinish(nodeid=item.nodeid, location=item.location)
    return True


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Which tests were run again, and why."""
    for report in (report for kind in terminalreporter.stats.values() for report in kind):
        if isinstance(report, pytest.TestReport) and report.when == "call":
            for name, value in report.user_properties:
                if name == _REPEATED:
                    terminalreporter.write_line(f"REPEATED {report.nodeid} - the machine stood still for {value}")
