"""One scenario per guard of the drive: what triggers it, what must come of it. Its name is the sentence.

They run compiled in the tests, interpreted for the mutants, and on the C device as a library, as machine code and on a
board.
"""

from __future__ import annotations

from collections.abc import Callable

from tests.device.guard_scenarios import limits, sensors, silence, states, stopping
from tests.device.guard_scenarios.expecting import MakeBench

SCENARIOS: dict[str, Callable[[MakeBench], None]] = {
    name: scenario
    for module in (silence, limits, sensors, states, stopping)
    for name, scenario in vars(module).items()
    if callable(scenario) and getattr(scenario, "__module__", "") == module.__name__
}
