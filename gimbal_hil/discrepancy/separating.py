"""Which run tells two causes apart, and why a cause cannot be seen in data that does not excite it."""

from __future__ import annotations

#: pairs (or classes) that look alike, and the run that separates them (METHOD, table of section "What worked")
_RUNS: tuple[tuple[frozenset[str], str], ...] = (
    (frozenset({"viscous", "viscous_asymmetry", "quadratic_drag", "torque_gain", "torque_offset", "coulomb_asymmetry", "coulomb"}),
     "five or more plateau speeds over a decade, both directions"),
    (frozenset({"static_unbalance", "cable_spring", "torque_offset"}), "a full turn, or the same motion at two base tilts"),
    (frozenset({"cogging", "encoder_eccentricity"}), "two constant speeds over a full turn, gyro recorded"),
    (frozenset({"torque_gain", "inertia", "static_unbalance"}), "a known added inertia, or a stall run against the stop"),
    (frozenset({"transport_delay", "actuator_lag", "structural_resonance", "inertia"}), "a chirp or pulses of torque beyond half the resonance"),
    (frozenset({"stribeck", "presliding", "coulomb"}), "plateaus below the Stribeck velocity and ramps below break-away"),
    (frozenset({"backlash", "presliding"}), "an amplitude sweep of torque reversals: a gap has a fixed width"),
    (frozenset({"temperature_viscosity", "viscous"}), "warm up at speed, then cool down, plateaus in between"),
    (frozenset({"torque_gain", "load_dependent_friction", "position_dependent_friction"}), "the same motion at two loads"),
    (frozenset({"dynamic_unbalance", "gyro_misalignment"}), "drive one axis with the other locked, then free, then reverse"),
    (frozenset({"viscous", "back_emf"}), "the same plateaus with the torque measured from motor current"),
    (frozenset({"cogging", "position_dependent_friction"}), "the same slow turn in both directions: cogging keeps its sign, friction turns it"),
)  # fmt: skip


def separating_run(one: str, other: str, excited_by: dict[str, str]) -> str:
    """The run that separates two causes; without a known one, the runs that excite each."""
    pair = {one, other}
    fitting = [(members, run) for members, run in _RUNS if pair <= members]
    if fitting:
        return min(fitting, key=lambda item: len(item[0]))[1]
    return f"{excited_by.get(one, one)}; then {excited_by.get(other, other)}"


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
