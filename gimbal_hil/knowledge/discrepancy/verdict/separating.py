"""Which run tells two causes apart, and why a cause cannot be seen in data that does not excite it."""

from __future__ import annotations

from sim_backend.effects import CATALOGUE, RUNS, Need, SeparatingRun

#: why an effect is not seen in data that lacks what it needs, in the order in which they are told
_MISSING = {
    Need.GYRO: "the data has no rate column for this axis",
    Need.TEMPERATURE: "the temperature is not in the data, or does not move",
    Need.MOVING_BASE: "the base does not move in this data",
    Need.SLIDING: "the joint never slides in this data",
}
#: why no weight is told of a single axis that the model has upright
UPRIGHT = "the model has the axis upright (incline_sine: 0), where no weight acts; 1 is a level axis"
#: what a cause is separated from that no hold-out has shown yet
CHANCE = "chance"


def separating_runs(one: str, other: str) -> tuple[SeparatingRun, ...]:
    """Runs that both effects say separate them, those of the smallest class first; empty where they share none."""
    shared = [run for run in _runs() if {one, other} <= _separated_by(run)]
    return tuple(sorted(shared, key=lambda run: len(_separated_by(run))))


def showing_sequences(*effects: str) -> tuple[str, ...]:
    """Sequences made for a class that holds at least one of these effects, in the order of the runs."""
    found = [run.sequence for run in _runs() if run.sequence and set(effects) & _separated_by(run)]
    return tuple(dict.fromkeys(found))


def all_sequences() -> tuple[str, ...]:
    """Every sequence that separates anything, in the order of the runs."""
    return tuple(dict.fromkeys(run.sequence for run in _runs() if run.sequence))


def _runs() -> tuple[SeparatingRun, ...]:
    """The runs that the catalogue knows, then those that plugged-in effects bring."""
    return tuple(dict.fromkeys((*RUNS, *(run for effect in CATALOGUE.values() for run in effect.separated_by))))


def _separated_by(run: SeparatingRun) -> set[str]:
    return {name for name, effect in CATALOGUE.items() if run in effect.separated_by}


def separating_run(one: str, other: str, excited_by: dict[str, str]) -> str:
    """The run that separates two causes, in words with the command that makes it; without a known one, the runs that
    excite each.
    """
    runs = separating_runs(one, other)
    if not runs:
        return f"{excited_by.get(one, one)}; then {excited_by.get(other, other)}"
    run = min(runs, key=lambda run: run.sequence is None)
    return run.text + (f" (gimbal-hil experiment {run.sequence})" if run.sequence else "")


def why_not_testable(effect: str, present: Need) -> str:
    """Reason that an effect leaves no trace in data that have what is present."""
    needs = CATALOGUE[effect].needs
    return next(
        (text for need, text in _MISSING.items() if need in needs and need not in present), CATALOGUE[effect].unseen
    )
