"""Which run tells two causes apart, and why a cause cannot be seen in data that does not excite it."""

from __future__ import annotations

from dataclasses import dataclass

#: classes that look alike, the run that separates their members, and the sequence that makes it; none where a person has to do something
_CLASSES: tuple[tuple[str, str, str], ...] = (
    (
        "viscous viscous_asymmetry quadratic_drag torque_gain torque_offset coulomb_asymmetry coulomb gyro_scale gyro_bias",
        "five or more plateau speeds over a decade, both directions",
        "plateaus",
    ),
    ("static_unbalance cable_spring torque_offset", "the whole travel, a full turn if it can", "full_turn"),
    ("static_unbalance cable_spring torque_offset", "the same motion at two base tilts", ""),
    (
        "cogging encoder_eccentricity position_dependent_friction gyro_scale",
        "two constant speeds over a full turn in both directions, gyro recorded",
        "full_turn",
    ),
    ("torque_gain inertia static_unbalance", "a known added inertia, or a stall run against the stop", ""),
    ("transport_delay actuator_lag structural_resonance inertia", "a chirp or pulses of torque beyond half the resonance", "sweep"),
    ("stribeck presliding coulomb", "plateaus below the Stribeck velocity and ramps below break-away", "creep"),
    (
        "backlash presliding inertia torque_gain actuator_lag transport_delay structural_resonance",
        "an amplitude sweep of reversals: a gap has a fixed width",
        "reversals",
    ),
    ("temperature_viscosity viscous coulomb", "warm up at speed, then cool down, plateaus in between", "warm_and_cool"),
    (
        "torque_gain load_dependent_friction position_dependent_friction static_unbalance inertia coulomb cable_spring",
        "the same motion at two loads: in several poses",
        "two_loads",
    ),
    ("dynamic_unbalance gyro_misalignment inertia static_unbalance", "drive one axis with the other locked, then reverse", "one_locked"),
    ("viscous back_emf", "the same plateaus with the torque measured from motor current", ""),
)


#: what a cause is separated from that no hold-out has shown yet
CHANCE = "chance"


@dataclass(frozen=True)
class SeparatingRun:
    """A run in words, and the sequence of that name that makes it; None where it needs a person."""

    text: str
    sequence: str | None


def separating_runs(one: str, other: str) -> tuple[SeparatingRun, ...]:
    """Runs made to separate two causes, those of the smallest class first; empty where no class holds both."""
    fitting = [(members.split(), text, sequence) for members, text, sequence in _CLASSES if {one, other} <= set(members.split())]
    return tuple(SeparatingRun(text, sequence or None) for _, text, sequence in sorted(fitting, key=lambda item: len(item[0])))


def showing_sequences(*effects: str) -> tuple[str, ...]:
    """Sequences made for a class that holds at least one of these effects, in the order of the table."""
    found = [sequence for members, _, sequence in _CLASSES if sequence and set(effects) & set(members.split())]
    return tuple(dict.fromkeys(found))


def all_sequences() -> tuple[str, ...]:
    """Every sequence of the table, in its order."""
    return tuple(dict.fromkeys(sequence for _, _, sequence in _CLASSES if sequence))


def separating_run(one: str, other: str, excited_by: dict[str, str]) -> str:
    """The run that separates two causes, in words with the command that makes it; without a known one, the runs that excite each."""
    runs = separating_runs(one, other)
    if not runs:
        return f"{excited_by.get(one, one)}; then {excited_by.get(other, other)}"
    run = min(runs, key=lambda run: run.sequence is None)
    return run.text + (f" (gimbal-hil experiment {run.sequence})" if run.sequence else "")


def why_not_testable(effect: str, moving_base: bool, has_gyro: bool, has_temperature: bool) -> str:
    """Reason that an effect leaves no trace in this data."""
    if effect.startswith("gyro") and not has_gyro:
        return "the data has no rate column for this axis"
    if effect == "temperature_viscosity" and not has_temperature:
        return "the temperature is not in the data, or does not move"
    if effect in ("dynamic_unbalance", "gyro_misalignment") and not moving_base:
        return "the base does not move in this data"
    if effect == "presliding":
        return "the model has no bristle here, or the axis never stays below break-away"
    if effect == "saturation":
        return "the command stays below any limit that the data could show"
    return "this data does not excite it"
