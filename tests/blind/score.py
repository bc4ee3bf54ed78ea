"""The only place where a verdict meets the truth."""

from __future__ import annotations

from enum import Enum
from typing import Any

from tests.blind.guests import ROWS as GUEST_ROWS

#: parameter of the catalogue -> column of the bench's antenna, by effect
_ROWS = {
    "viscous": {"viscous": "s2"},
    "coulomb": {"coulomb": "Tc", "breakaway": "Ts"},
    "stribeck": {"breakaway": "Ts", "stribeck_velocity": "vs"},
    "presliding": {"sigma0": "s0"},
    "coulomb_asymmetry": {"asymmetry": "asym_c"},
    "viscous_asymmetry": {"asymmetry": "asym_v"},
    "load_dependent_friction": {"coefficient": "load_c"},
    "quadratic_drag": {"coefficient": "quad"},
    "position_dependent_friction": {"relative_amplitude": "pos_a", "order": "pos_n"},
    "temperature_viscosity": {"temperature_coefficient": "temp_b"},
    "cogging": {"amplitude": "cog_a", "order": "cog_n"},
    "cable_spring": {"stiffness": "spring_k", "rest_position": "spring_q0"},
    "structural_resonance": {"inertia_share": "res_share"},
    "backlash": {"gap": "gap", "rotor_inertia": "rotor"},
    "torque_gain": {"gain_error": "gain"},
    "torque_offset": {"offset": "offset"},
    "actuator_lag": {"time_constant": "lag"},
    "transport_delay": {"delay": "delay"},
    "saturation": {"limit": "limit"},
    "back_emf": {"coefficient": "emf"},
    "gyro_bias": {"bias": "g_bias"},
    "gyro_scale": {"scale_error": "g_scale"},
    "gyro_misalignment": {"leak_x": "leak_x", "leak_y": "leak_y", "leak_z": "leak_z"},
    "encoder_eccentricity": {"amplitude": "ecc_a"},
}


#: body column -> parameter, by effect
_BODY = {
    "inertia": {"1": "inertia", "2": "inertia", "9": "inertia"},
    "static_unbalance": {"6": "cog_x", "7": "cog_y", "8": "cog_z"},
    "dynamic_unbalance": {"3": "ixy", "4": "ixz", "5": "iyz"},
}


Pair = tuple[str, str]

#: a wrong number of the model that stands lower than this, in floors, need not be told
DEMANDED_FLOORS = 3.0
#: answers that are none
NO_ANSWERS = ("unusable_data", "crashed", "too_slow")


class Outcome(Enum):
    """What a verdict was worth."""

    EXACT = "all named, nothing else"
    CLASS = "right class, with the run that separates"
    ABSTAINED = "rightly named nothing"
    NEAR = "named a number that is off within what the model says of it"
    AKIN = "named the catalogue's nearest to what is in no catalogue"
    GUESSED = "guessed, as ambiguous, where nothing can be named"
    MISSED = "named nothing where something is"
    PARTLY = "named a part, nothing else"
    FALSE = "false name"
    NO_ANSWER = "no answer"


#: outcomes in which all is as it should be
GOOD = (Outcome.EXACT, Outcome.CLASS, Outcome.ABSTAINED)


def _folded(name: str, axis: str) -> Pair:
    """Commanded torque cannot tell back-EMF from viscous friction: either name is right."""
    return ("viscous" if name == "back_emf" else name, axis)


def demanded(truth: dict[str, Any]) -> set[Pair]:
    """What has to be named: every hidden effect of the catalogue, and every wrong number that shows."""
    causes = [
        c
        for c in truth["causes"]
        if c["inside"] and not (c.get("number") and not c["magnitude_floors"] >= DEMANDED_FLOORS)
    ]
    return {_folded(c["name"], c["axis"]) for c in causes}


def near_numbers(truth: dict[str, Any]) -> set[Pair]:
    """Effects that say of a known number what is true: it is off, if only as far as the model says it may be."""
    named = {"viscous": "viscous", "coulomb": "coulomb", "breakaway": "stribeck", "stribeck_velocity": "stribeck"}
    named |= {
        "sigma0": "presliding",
        "sigma1": "presliding",
        "x": "static_unbalance",
        "y": "static_unbalance",
        "z": "static_unbalance",
    }
    named |= {"xx": "inertia", "yy": "inertia", "zz": "inertia", "mass": "inertia"}
    named |= {"xy": "dynamic_unbalance", "xz": "dynamic_unbalance", "yz": "dynamic_unbalance"}
    found = (
        {(named[n["path"].split(".")[-1]], n["axis"]) for n in truth.get("off_numbers", ())} if truth["off"] else set()
    )
    # a body's mass times its centre of gravity is what one weighs
    return found | {("static_unbalance", axis) for name, axis in found if name == "inertia"}


def right_names(truth: dict[str, Any]) -> set[Pair]:
    """Every name that is no false one on this case."""
    akin = {(name, c["axis"]) for c in truth["causes"] for name in c.get("akin", ())}
    akin |= {(name, axis) for name, axis in truth.get("lacking", ())}
    return {_folded(c["name"], c["axis"]) for c in truth["causes"] if c["inside"]} | near_numbers(truth) | akin


def outcome(truth: dict[str, Any], verdict: dict[str, Any]) -> Outcome:
    """Judge one verdict."""
    if verdict["verdict"] in NO_ANSWERS:
        return Outcome.NO_ANSWER
    told = {_folded(e["name"], e["axis"]): e["status"] for e in verdict["effects"]}
    firm = {pair for pair, status in told.items() if status == "named"}
    causes, wanted = truth["causes"], demanded(truth)
    if any(not c["inside"] for c in causes) or not causes:
        return _where_nothing_can_be_named(truth, set(told), firm)
    if not told:
        return Outcome.MISSED if wanted else Outcome.ABSTAINED
    right = right_names(truth)
    if wanted <= firm and set(told) <= right:
        return Outcome.EXACT
    if _is_class(wanted, told, right, verdict):
        return Outcome.CLASS
    return Outcome.PARTLY if set(told) <= right else Outcome.FALSE


def _where_nothing_can_be_named(truth: dict[str, Any], told: set[Pair], firm: set[Pair]) -> Outcome:
    if not told:
        return Outcome.ABSTAINED
    near = near_numbers(truth)
    if told <= near:
        return Outcome.NEAR
    if told <= right_names(truth):
        return Outcome.AKIN
    return Outcome.FALSE if firm - right_names(truth) else Outcome.GUESSED


def _is_class(wanted: set[Pair], told: dict[Pair, str], right: set[Pair], verdict: dict[str, Any]) -> bool:
    """Whether what is wanted is told or is an alternative to an ambiguous guess, and every other guess has a right
    alternative.
    """
    others = [(_folded(a["name"], a["axis"]), _folded(a["instead_of"], a["axis"])[0]) for a in verdict["alternatives"]]
    if not wanted <= set(told) | {pair for pair, _ in others} or not verdict["next_experiment"]:
        return False
    excused = {instead for pair, instead in others if pair in right}
    return all(pair in right or (status == "ambiguous" and pair[0] in excused) for pair, status in told.items())


def told_names(truth: dict[str, Any], verdict: dict[str, Any]) -> list[tuple[str, str, float | None, bool]]:
    """(name, axis, told probability, right) of every name in a verdict; orders of one ripple count once, with the
    highest.
    """
    right, found = right_names(truth), dict[Pair, float | None]()
    for effect in verdict["effects"]:
        pair = _folded(effect["name"], effect["axis"])
        told = effect.get("probability", effect.get("confidence"))
        known = [p for p in (found.get(pair), told) if p is not None]
        found[pair] = max(known) if known else None
    return [(*pair, told, pair in right) for pair, told in found.items()]


def told_class(truth: dict[str, Any], verdict: dict[str, Any]) -> tuple[float, bool] | None:
    """(probability that the told causes or their alternatives hold it, whether they do); None where nothing is told or
    no such number.
    """
    if verdict.get("something_else") is None or not verdict["effects"]:
        return None
    told = {_folded(e["name"], e["axis"]) for e in (*verdict["effects"], *verdict["alternatives"])}
    return 1.0 - float(verdict["something_else"]), bool(told & right_names(truth))


def numbers_found(truth: dict[str, Any], verdict: dict[str, Any]) -> list[tuple[str, bool, bool]]:
    """(number's effect @ axis, named, named or recalibrated to within 10 % of the truth) of every wrong number that
    shows.
    """
    named = {_folded(e["name"], e["axis"]) for e in verdict["effects"] if e["status"] == "named"}
    moved = {(r["axis"], r["path"]): r["to"] for r in verdict.get("recalibrated") or () if r.get("to") is not None}
    found = []
    for cause in truth["causes"]:
        pair = _folded(cause["name"], cause["axis"])
        if not cause.get("number") or pair not in demanded(truth):
            continue
        mine = [n for n in truth["off_numbers"] if n["axis"] == cause["axis"] and _is_of(n["path"], cause)]
        right = bool(mine) and all(
            abs(moved.get((n["axis"], n["path"]), n["model"]) - n["true"]) <= 0.1 * abs(n["true"]) for n in mine
        )
        found.append(("@".join(pair), pair in named, pair in named or right))
    return found


def _is_of(path: str, cause: dict[str, Any]) -> bool:
    """Whether a model's number is one of those that a wrong-number cause is about."""
    columns = {"s2": "viscous", "Tc": "coulomb", "Ts": "breakaway", "s0": "sigma0"}
    bodies = ("xx", "yy", "zz", "xy", "xz", "yz", "x", "y", "z", "mass")
    return path.split(".")[-1] in {columns[key] for key in cause["row"]} | {bodies[int(key)] for key in cause["body"]}


def parameter_errors(truth: dict[str, Any], verdict: dict[str, Any]) -> list[tuple[str, float, bool]]:
    """(effect.parameter, relative error, interval covers the truth) of every rightly named effect; of several entries
    the nearest.
    """
    found = []
    for cause in truth["causes"]:
        columns = _ROWS | GUEST_ROWS
        true = {
            name: cause["row"][column]
            for name, column in columns.get(cause["name"], {}).items()
            if column in cause["row"]
        }
        true |= {
            _BODY[cause["name"]][column]: value for column, value in cause["body"].items() if cause["name"] in _BODY
        }
        mine = [e["parameters"] for e in verdict["effects"] if (e["name"], e["axis"]) == (cause["name"], cause["axis"])]
        entries = [
            [(f"{cause['name']}.{name}", *_error(p[name], value)) for name, value in true.items() if name in p]
            for p in mine
        ]
        found += min(entries, key=lambda entry: sum(error for _, error, _ in entry), default=[])
    return found


def _error(told: dict[str, Any], true: float) -> tuple[float, bool]:
    covered = told["low"] is not None and told["high"] is not None and told["low"] <= true <= told["high"]
    return abs(told["value"] - true) / max(abs(true), 1e-12), bool(covered)
