"""How honest the intervals of `identify` are: antennas whose friction is drawn anew, short sequences, wrong priors.

    python -m tests.benchmarks.interval_coverage [--antennas 6] [--first 7000] [--static]

Every antenna has both axes' friction drawn up to 40 % off the shipped one, and is identified from a prior that is up to
25 % off its own, so that nothing is recovered by being known. An interval of 95 % should hold the truth in 90 to 98 of
100, and its error should be half a half width rms (0.51 where errors are normal): much less and it promises too
little, much more and it promises too much. `--static` leaves presliding, and with it sigma0 and sigma1, out.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

import numpy as np

from gimbal_hil.knowledge.experiments.conducting import conduct
from gimbal_hil.knowledge.experiments.sequences import SequenceOptions, breakaway_torques, build_experiment
from gimbal_hil.knowledge.identification import LUGRE_NAMES, Estimate, Log, friction_of, identify_axis, read_logs
from gimbal_hil.loop.settings import shipped_settings
from sim_backend.model import AntennaModel, shipped_model

DRAWN_WITHIN, PRIOR_OFF_BY = 0.4, 0.25
DYNAMIC = ("sigma0", "sigma1")


def scaled(model: AntennaModel, within: float, rng: np.random.Generator) -> AntennaModel:
    """The model with every friction number of every axis off by up to a share; break-away stays above Coulomb."""
    for axis in model.axes:
        known = friction_of(model, axis).values()
        values = known * rng.uniform(1.0 - within, 1.0 + within, len(known))
        values[0] = values[1] + (known[0] - known[1]) * rng.uniform(1.0 - within, 1.0 + within)
        numbers = {f"friction.{name}": value for name, value in zip(LUGRE_NAMES, values.tolist(), strict=True)}
        model = model.with_numbers(axis, numbers)
    return model


def errors_of(seed: int, axis: str, sequences: tuple[str, ...]) -> list[tuple[str, float]]:
    """Each parameter's error in half widths of its interval, on one axis of one antenna; undetermined ones left out."""
    rng = np.random.default_rng(seed)
    truth = scaled(shipped_model(), DRAWN_WITHIN, rng)
    prior = scaled(truth, PRIOR_OFF_BY, rng)
    settings = shipped_settings()
    options = SequenceOptions(settings.rate_hz, (axis,), short=True, breakaway_nm=breakaway_torques(prior))
    logs: list[Log] = []
    with tempfile.TemporaryDirectory() as folder:
        for place, name in enumerate(sequences):
            own_seed = 4 * seed + 2 * truth.axes.index(axis) + place
            outcome = conduct(build_experiment(name, options), settings, truth, own_seed, Path(folder) / name)
            logs += read_logs(outcome.folder, truth.axes)
        found = identify_axis(logs, prior, axis, seed)
    known = dict(zip(LUGRE_NAMES, friction_of(truth, axis).values().tolist(), strict=True))
    return [(e.name, _in_half_widths(e, known[e.name])) for e in found.estimates if np.isfinite(e.fitted)]


def _in_half_widths(estimate: Estimate, truth: float) -> float:
    interval = estimate.interval
    half = interval.high - estimate.value if truth > estimate.value else estimate.value - interval.low
    return (truth - estimate.value) / half if half > 0.0 else float("inf")


def said(name: str, errors: list[float]) -> str:
    """One line of figures."""
    holds = sum(abs(error) <= 1.0 for error in errors)
    rms = float(np.sqrt(np.mean(np.square(errors))))
    share = 100.0 * holds / len(errors)
    worst = max(errors, key=abs)
    hold = f"{holds:>4} of {len(errors):<4} hold ({share:.0f} %)"
    return f"{name:<18}{hold}, rms {rms:.2f}, worst {worst:+.2f} half widths"


def main() -> None:
    """See the module."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--antennas", type=int, default=6)
    parser.add_argument("--first", type=int, default=7000, help="seed of the first antenna")
    parser.add_argument("--static", action="store_true", help="sliding alone, without sigma0 and sigma1")
    asked = parser.parse_args()
    sequences = ("sliding",) if asked.static else ("sliding", "presliding")
    errors: dict[str, list[float]] = {name: [] for name in LUGRE_NAMES}
    for seed in range(asked.first, asked.first + asked.antennas):
        for axis in shipped_model().axes:
            own = errors_of(seed, axis, sequences)
            for name, error in own:
                errors[name].append(error)
            print(f"seed {seed} {axis}: " + ", ".join(f"{name} {error:+.2f}" for name, error in own), flush=True)
    groups = {name: found for name, found in errors.items() if found}
    groups["static"] = [error for name, found in errors.items() if name not in DYNAMIC for error in found]
    groups["dynamic"] = [error for name in DYNAMIC for error in errors[name]]
    for name, found in groups.items():
        if found:
            print(said(name, found))


if __name__ == "__main__":
    main()
