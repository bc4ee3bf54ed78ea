"""The only place where a verdict meets the truth."""

from __future__ import annotations

from enum import Enum
from typing import Any

#: parameter of the catalogue -> column of the bench's antenna, by effect
_ROWS = {
    "viscous": {"viscous": "s2"}, "coulomb": {"coulomb": "Tc", "breakaway": "Ts"},
    "stribeck": {"breakaway": "Ts", "stribeck_velocity": "vs"},
    "presliding": {"sigma0": "s0"}, "coulomb_asymmetry": {"asymmetry": "asym_c"}, "viscous_asymmetry": {"asymmetry": "asym_v"},
    "load_dependent_friction": {"coefficient": "load_c"}, "quadratic_drag": {"coefficient": "quad"},
    "position_dependent_friction": {"relative_amplitude": "pos_a", "order": "pos_n"},
    "temperature_viscosity": {"temperature_coefficient": "temp_b"}, "cogging": {"amplitude": "cog_a", "order": "cog_n"},
    "cable_spring": {"stiffness": "spring_k", "rest_position": "spring_q0"}, "structural_resonance": {"inertia_share": "res_share"},
    "backlash": {"gap": "gap", "rotor_inertia": "rotor"}, "torque_gain": {"gain_error": "gain"}, "torque_offset": {"offset": "offset"},
    "actuator_lag": {"time_constant": "lag"}, "transport_delay": {"delay": "delay"}, "saturation": {"limit": "limit"},
    "back_emf": {"coefficient": "emf"}, "gyro_bias": {"bias": "g_bias"}, "gyro_scale": {"scale_error": "g_scale"},
    "gyro_misalignment": {"leak_x": "leak_x", "leak_y": "leak_y", "leak_z": "leak_z"}, "encoder_eccentricity": {"amplitude": "ecc_a"},
}  # fmt: skip


#: body column -> parameter, by effect
_BODY = {
    "inertia": {"1": "inertia", "2": "inertia", "9": "inertia"},
    "static_unbalance": {"6": "cog_x", "7": "cog_y", "8": "cog_z"},
    "dynamic_unbalance": {"3": "ixy", "4": "ixz", "5": "iyz"},
}  # fmt: skip


class Outcome(Enum):
    """What a verdict was worth."""

    EXACT = "exact name and axis"
    CLASS = "right class, with the run that separates"
    ABSTAINED = "rightly named nothing"
    MISSED = "named nothing where something is"
    PARTLY = "named one of two"
    FALSE = "false name"


def _folded(pairs: set[tuple[str, str]]) -> set[tuple[str, str]]:
    """Commanded torque cannot tell back-EMF from viscous friction: either name is right."""
    return {("viscous" if name == "back_emf" else name, axis) for name, axis in pairs}


def outcome(truth: dict[str, Any], verdict: dict[str, Any]) -> Outcome:
    """Judge one verdict."""
    hidden = _folded({(c["name"], c["axis"]) for c in truth["causes"] if c["inside"]})
    named = _folded({(e["name"], e["axis"]) for e in verdict["effects"]})
    if not hidden or any(not c["inside"] for c in truth["causes"]):
        return Outcome.FALSE if named else Outcome.ABSTAINED
    if not named:
        return Outcome.MISSED
    if named == hidden:
        return Outcome.EXACT
    others = _folded({(a["name"], a["axis"]) for a in verdict["alternatives"]})
    if hidden <= named | others and verdict["next_experiment"]:
        return Outcome.CLASS
    return Outcome.PARTLY if named < hidden else Outcome.FALSE


def parameter_errors(truth: dict[str, Any], verdict: dict[str, Any]) -> list[tuple[str, float, bool]]:
    """(effect.parameter, relative error, interval covers the truth) of every rightly named effect."""
    found = []
    for cause in truth["causes"]:
        for effect in verdict["effects"]:
            if (effect["name"], effect["axis"]) != (cause["name"], cause["axis"]):
                continue
            true = {name: cause["row"][column] for name, column in _ROWS.get(cause["name"], {}).items() if column in cause["row"]}
            true |= {_BODY[cause["name"]][column]: value for column, value in cause["body"].items() if cause["name"] in _BODY}
            for name, value in true.items():
                if name in effect["parameters"]:
                    p = effect["parameters"][name]
                    error = abs(p["value"] - value) / max(abs(value), 1e-12)
                    found.append((f"{cause['name']}.{name}", error, bool(p["low"] <= value <= p["high"])))
    return found
