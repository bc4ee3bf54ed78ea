"""Which run tells two causes apart, and why a cause cannot be seen in data that does not excite it."""

from __future__ import annotations

#: classes that look alike, and the run that separates their members (METHOD, table of section "What worked")
_CLASSES: tuple[tuple[str, str], ...] = (
    (
        "viscous viscous_asymmetry quadratic_drag torque_gain torque_offset coulomb_asymmetry coulomb",
        "five or more plateau speeds over a decade, both directions",
    ),
    ("static_unbalance cable_spring torque_offset", "a full turn, or the same motion at two base tilts"),
    ("cogging encoder_eccentricity", "two constant speeds over a full turn, gyro recorded"),
    ("torque_gain inertia static_unbalance", "a known added inertia, or a stall run against the stop"),
    ("transport_delay actuator_lag structural_resonance inertia", "a chirp or pulses of torque beyond half the resonance"),
    ("stribeck presliding coulomb", "plateaus below the Stribeck velocity and ramps below break-away"),
    ("backlash presliding", "an amplitude sweep of torque reversals: a gap has a fixed width"),
    ("temperature_viscosity viscous", "warm up at speed, then cool down, plateaus in between"),
    ("torque_gain load_dependent_friction position_dependent_friction", "the same motion at two loads"),
    ("dynamic_unbalance gyro_misalignment", "drive one axis with the other locked, then free, then reverse"),
    ("viscous back_emf", "the same plateaus with the torque measured from motor current"),
    ("cogging position_dependent_friction", "the same slow turn in both directions: cogging keeps its sign, friction turns it"),
)
_RUNS = tuple((frozenset(members.split()), run) for members, run in _CLASSES)


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
