"""False suspicions in hours on which nothing sets in: `python -m tests.observing.false_names --hours 6 --seed 1`.

Rows as the service makes them: motion that is another every minute, a model that is not quite right (a ripple, a gain,
a friction level), friction that wanders by a few per cent over half a minute and over five, a viscosity that follows
the temperature of a room and of the work done, and a base that swings and is heard late. Each second is looked at; a
name is told from the second in a row on, which is sooner than the watch would.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Iterator

import numpy as np

from gimbal_hil.realtime.observing.suspicion import suspicion

ROW_S, MINUTE, LOOK, HISTORY = 0.02, 3000, 50, 3400
LEAST_NM = 0.0077
INERTIA, COULOMB, VISCOUS = 0.5, 0.24, 0.06


def minutes(rng: np.random.Generator) -> Iterator[np.ndarray]:
    """One minute of rows after another: missing torque, position, rate, torque, gyro error."""
    levels, room, worked = np.zeros(2), rng.uniform(0.0, 6.0), 0.0
    began = 0.0
    while True:
        t = began + ROW_S * np.arange(MINUTE)
        began += ROW_S * MINUTE
        q, v, a = np.zeros(MINUTE), np.zeros(MINUTE), np.zeros(MINUTE)
        for _ in range(3):
            hz = float(np.exp(rng.uniform(np.log(0.05), np.log(0.8))))
            turns, phase = 2.0 * np.pi * hz, rng.uniform(0.0, 6.3)
            rad = min(0.5, 0.6 / turns) * rng.uniform(0.3, 1.0)
            q += rad * np.sin(turns * t + phase)
            v += rad * turns * np.cos(turns * t + phase)
            a -= rad * turns**2 * np.sin(turns * t + phase)
        wander = []
        for k, (time_s, share) in enumerate(((30.0, 0.02), (300.0, 0.03))):
            kept = np.exp(-60.0 / time_s)
            following = kept * levels[k] + np.sqrt(1.0 - kept**2) * share * rng.normal()
            wander.append(np.linspace(levels[k], following, MINUTE))
            levels[k] = following
        worked += (float(np.mean(v**2)) * 40.0 - worked) * 60.0 / 900.0
        degrees = 5.0 * np.sin(2.0 * np.pi * t / 5400.0 + room) + worked
        swing = 0.1 * np.sin(2.0 * np.pi * 0.15 * t)
        late = INERTIA * 0.1 * (2.0 * np.pi * 0.15) ** 2 * 0.1 * np.cos(2.0 * np.pi * 0.15 * t)
        missing = COULOMB * (wander[0] + wander[1]) * np.sign(v) - 0.02 * VISCOUS * degrees * v + late
        torque = INERTIA * a + COULOMB * np.sign(v) + VISCOUS * v
        missing += 0.004 * np.cos(11.0 * q) + 0.01 * torque + 0.003 * np.sign(v) + 0.002 * rng.normal(size=MINUTE)
        gyro = 3e-4 * rng.normal(size=MINUTE) + 2e-4 + 1e-3 * swing
        yield np.column_stack([missing, q, v, torque, gyro])


def main(arguments: list[str]) -> int:
    """Count what is told."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--hours", type=float, default=6.0)
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args(arguments)
    told: Counter[str] = Counter()
    rows, before, latched = np.zeros((0, 5)), None, None
    given = minutes(np.random.default_rng(asked.seed))
    for _ in range(round(60.0 * asked.hours)):
        minute = next(given)
        for first in range(0, MINUTE, LOOK):
            rows = np.concatenate([rows, minute[first : first + LOOK]])[-HISTORY:]
            found = suspicion(rows, LEAST_NM)
            cause = None if found is None else found.cause
            if cause is not None and cause is before and cause is not latched:
                told[cause.value] += 1
                latched = cause
            before = cause
            latched = latched if cause is not None else None
    print(f"{asked.hours:g} h of antenna time, seed {asked.seed}: {sum(told.values())} names told, {dict(told)}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
