"""How long the quadratic programs of the arena's `mpc` take of a tick: `python -m tests.benchmarks.predictive_time`.

Processor time of both axes' programs with all that Python does around them; one scenario in which no limit is near, one
step that is all limits.
"""

from __future__ import annotations

import numpy as np

from gimbal_hil.pointing.arena import chosen, entrants, shipped_scenarios
from gimbal_hil.pointing.arena.predictive_run import PredictivePath
from gimbal_hil.pointing.arena.trial import Trial, program_for
from sim_backend.model import shipped_model


def main() -> None:
    """Print median, 99th percentile and the longest, in microseconds and ticks."""
    (entrant,), model = entrants(["mpc"]), shipped_model("realistic")
    assert isinstance(entrant.law, tuple)
    for words in ("reversals: 0.2 rad", "outer 1.0 rad"):
        scenario = chosen(shipped_scenarios(), words)[0].model_copy(update={"duration_s": 4.0})
        trial = Trial(scenario, "mpc", entrant.settings, "realistic", model, 1, law=entrant.law)
        path = PredictivePath(entrant.settings, model, 1, entrant.law)
        path.connect()
        path.run(program_for(trial))
        took = 1e6 * np.array(path.solving_s)
        middle, late = np.percentile(took, [50.0, 99.0])
        over = np.count_nonzero(took > 1e6 * entrant.settings.step_s)
        print(
            f"{scenario.name}: median {middle:.0f} us, 99 % {late:.0f} us, longest {took.max():.0f} us; "
            f"{over} of {len(took)} ticks longer than the tick"
        )


if __name__ == "__main__":
    main()
