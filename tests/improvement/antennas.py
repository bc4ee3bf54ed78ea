"""Antennas with hidden effects, drawn from a seed: effects, axes and magnitudes in noise floors; known numbers off;
causes outside.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.discrepancy.hypotheses.hypothesis import known_numbers
from gimbal_hil.knowledge.discrepancy.inquiry.standing import standing
from gimbal_hil.knowledge.discrepancy.verdict.corrected import with_numbers
from gimbal_hil.knowledge.experiments.sequences import SequenceOptions
from gimbal_hil.knowledge.experiments.sequences.survey import survey_motion
from gimbal_hil.knowledge.improvement.rehearsal import rehearse
from gimbal_hil.loop.settings import shipped_settings
from sim_backend.effects import CATALOGUE
from sim_backend.model import AntennaModel, shipped_model
from sim_backend.shipped import shipped_file

LEAST_FLOORS, MOST_FLOORS = 3.0, 30.0
#: survey numbers that no improvement reaches, for measuring magnitudes and for the last word
MAGNITUDE_SURVEY, LAST_SURVEY = 0, 7
Parameters = dict[str, float]


@dataclass(frozen=True)
class Hidden:
    """One effect as it was put in: its parameters and how many floors it makes alone on a survey."""

    name: str
    axis: str
    parameters: Parameters
    floors: float


@dataclass(frozen=True)
class Antenna:
    """A hidden antenna and what was put in."""

    model: AntennaModel
    hidden: tuple[Hidden, ...]


def gaps_in_floors(model: AntennaModel, table: SignalsTable) -> np.ndarray:
    """Rms per channel that `model` leaves of a table, in its floors."""
    return np.array([gap["before"] / gap["noise_floor"] for gap in standing(model, table)])


def judged(antenna: AntennaModel, model: AntennaModel, number: int = LAST_SURVEY, short: bool = True) -> float:
    """Largest gap (floors) that `model` leaves on a survey of `antenna` that neither has seen."""
    table = rehearse(
        survey_motion(SequenceOptions(1000.0, short=short), number), shipped_settings(), antenna, seed=977
    ).table
    assert table is not None
    return float(np.max(gaps_in_floors(model, table)))


def effects(axis: str, rng: np.random.Generator, model: AntennaModel) -> dict[str, Callable[[float], Parameters]]:
    """Every effect that a level, fixed antenna shows, as a function of its size (1 is a usual one) to its
    parameters.
    """
    sign, phase = float(rng.choice([-1.0, 1.0])), float(rng.uniform(-math.pi, math.pi))
    order, slow = float(rng.integers(5, 37)), float(rng.integers(3, 13))
    shift, hz, zeta = float(rng.uniform(1.5, 3.5)), float(rng.uniform(9.0, 28.0)), float(rng.uniform(0.01, 0.05))
    rest = float(rng.uniform(-0.4, 0.4))

    def number(path: str) -> float:
        return model.number(axis, path)

    inertia = model.number(axis, model.own_inertia_path(axis))
    found: dict[str, Callable[[float], Parameters]] = {
        "viscous": lambda s: {"viscous": number("friction.viscous") + 0.05 * s},
        "coulomb": lambda s: {
            "coulomb": number("friction.coulomb") + 0.02 * sign * s,
            "breakaway": number("friction.breakaway") + 0.02 * sign * s,
        },
        "stribeck": lambda s: {
            "breakaway": number("friction.breakaway") + 0.05 * s,
            "stribeck_velocity": shift * number("friction.stribeck_velocity"),
        },
        "coulomb_asymmetry": lambda s: {"asymmetry": 0.05 * sign * s},
        "viscous_asymmetry": lambda s: {"asymmetry": 0.2 * sign * s},
        "load_dependent_friction": lambda s: {"coefficient": 0.03 * s},
        "position_dependent_friction": lambda s: {"relative_amplitude": 0.08 * s, "order": slow, "phase": phase},
        "quadratic_drag": lambda s: {"coefficient": 0.05 * s},
        "inertia": lambda s: {"inertia": inertia * (1.0 + 0.03 * sign * s)},
        "cogging": lambda s: {"amplitude": 0.01 * s, "order": order, "phase": phase},
        "cable_spring": lambda s: {"stiffness": 0.03 * s, "rest_position": rest},
        "structural_resonance": lambda s: {
            "antiresonance_frequency": hz,
            "damping_ratio": zeta,
            "inertia_share": 0.05 * s,
        },
        "torque_gain": lambda s: {"gain_error": 0.02 * sign * s},
        "torque_offset": lambda s: {"offset": 0.01 * sign * s},
        "actuator_lag": lambda s: {"time_constant": 5e-4 * s},
        "transport_delay": lambda s: {"delay": 5e-4 * s},
        "back_emf": lambda s: {"coefficient": 0.05 * s},
        "gyro_bias": lambda s: {"bias": 1e-3 * sign * s},
        "gyro_scale": lambda s: {"scale_error": 3e-3 * sign * s},
        "encoder_eccentricity": lambda s: {"amplitude": 2e-4 * s, "phase": phase},
        "presliding": lambda s: {"sigma0": number("friction.sigma0") * math.exp(-0.3 * s)},
    }
    if axis == "inner":
        found["static_unbalance"] = lambda s: {
            "cog_x": number("body.cog.x") + 1e-4 * sign * s,
            "cog_z": number("body.cog.z") + 8e-5 * s,
        }
        found["gyro_misalignment"] = lambda s: {"leak_x": 0.005 * sign * s, "leak_z": 0.004 * s}
    return found


#: sizes (see `effects`) beyond which a quantity is no longer physical or the loop no longer stable
_LARGEST = {
    "structural_resonance": 8.0, "torque_gain": 15.0, "actuator_lag": 10.0, "transport_delay": 10.0, "inertia": 10.0,
    "coulomb": 4.0, "coulomb_asymmetry": 10.0, "viscous_asymmetry": 4.0, "presliding": 3.0, "stribeck": 4.0,
    "position_dependent_friction": 8.0, "load_dependent_friction": 10.0,
}  # fmt: skip


def sized(
    start: AntennaModel, name: str, axis: str, of_size: Callable[[float], Parameters], goal: float
) -> Hidden | None:
    """An effect of the size that makes `goal` floors alone on a survey; None where it cannot."""
    size, top = 1.0, _LARGEST.get(name, 40.0)
    for _ in range(5):
        table = _surveyed(start.with_effect(name, axis, of_size(size)))
        if table is None:
            return None
        made = float(np.sqrt(np.max(np.maximum(gaps_in_floors(start, table) ** 2 - 1.0, 1e-6))))
        if 0.9 < made / goal < 1.1:
            return Hidden(name, axis, of_size(size), made)
        if size >= top and made < goal:
            return Hidden(name, axis, of_size(size), made) if made > LEAST_FLOORS else None
        size = min(top, size * float(np.clip(goal / made, 0.02, 20.0)))
    return Hidden(name, axis, of_size(size), made) if LEAST_FLOORS <= made <= 1.3 * MOST_FLOORS else None


def _surveyed(antenna: AntennaModel) -> SignalsTable | None:
    rehearsal = rehearse(
        survey_motion(SequenceOptions(1000.0, short=True), MAGNITUDE_SURVEY), shipped_settings(), antenna, seed=31
    )
    return rehearsal.table if rehearsal.stopped is None else None


def draw(seed: int, count: int = 2, off: float = 0.0) -> Antenna:
    """An antenna with `count` hidden effects; `off` moves every known number by half to all of that share, up or
    down.
    """
    rng = np.random.default_rng(seed)
    start = shipped_model()
    hidden: list[Hidden] = []
    while len(hidden) < count:
        axis = str(rng.choice(["outer", "inner"]))
        pool = effects(axis, rng, start)
        name = str(rng.choice(sorted(pool)))
        goal = float(np.exp(rng.uniform(math.log(LEAST_FLOORS), math.log(MOST_FLOORS))))
        if _clash(name, axis, hidden):
            continue
        found = sized(start, name, axis, pool[name], goal)
        if found is not None:
            hidden.append(found)
    antenna = start if off == 0.0 else _moved(start, rng, off)
    for one in hidden:
        antenna = antenna.with_effect(one.name, one.axis, _beside(start, antenna, one))
    return Antenna(antenna, tuple(hidden))


def _clash(name: str, axis: str, hidden: list[Hidden]) -> bool:
    """Two effects on one axis that would overwrite each other's numbers."""
    same = {"coulomb", "stribeck"}
    return any(one.axis == axis and (one.name == name or {one.name, name} <= same) for one in hidden)


def _beside(start: AntennaModel, antenna: AntennaModel, one: Hidden) -> Parameters:
    """Parameters that are numbers of the model change the moved antenna's number by the same share as the first
    model's.
    """
    found = dict(one.parameters)
    for parameter in CATALOGUE[one.name].parameters:
        if parameter.path is not None and parameter.name in found:
            path = start.number_path(one.axis, parameter.path)
            if start.number(one.axis, path) != 0.0:
                found[parameter.name] *= antenna.number(one.axis, path) / start.number(one.axis, path)
    return found


def _moved(start: AntennaModel, rng: np.random.Generator, off: float) -> AntennaModel:
    numbers: dict[tuple[str, str], float] = {}
    for known in known_numbers(start):
        share = off * float(rng.choice([-1.0, 1.0])) * float(rng.uniform(0.5, 1.0))
        numbers[known.axis, known.path] = start.number(known.axis, known.path) * (1.0 + share)
    for axis in start.axes:
        numbers[axis, "friction.breakaway"] = max(
            numbers[axis, "friction.breakaway"], 1.02 * numbers[axis, "friction.coulomb"]
        )
    return with_numbers(start, numbers)


def with_a_bump(axis: str = "inner") -> AntennaModel:
    """An antenna with a cause that no catalogue holds: a bump of torque over position, made of many small ripples."""
    model, centre, width = shipped_model(), 0.1, 0.12
    for order in range(1, 25):
        amplitude = 0.05 * width * 2.0 / math.sqrt(2.0 * math.pi) * math.exp(-0.5 * (order * width) ** 2)
        model = model.with_effect(
            "cogging",
            axis,
            {"amplitude": amplitude, "order": float(order), "phase": _wrapped(0.5 * math.pi - order * centre)},
        )
    return model


def _wrapped(angle: float) -> float:
    return (angle + math.pi) % (2.0 * math.pi) - math.pi


def configuration(folder: Path, antenna: AntennaModel, seed: int = 5) -> Path:
    """A configuration file whose embedded antenna is this one."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "hidden.yaml").write_text(antenna.to_yaml(), encoding="utf-8")
    document: dict[str, Any] = yaml.safe_load(shipped_file("virtual_antenna.yaml").read_text())
    document["link"] = {"embedded": {"model": "./hidden.yaml", "seed": seed}}
    (folder / "antenna.yaml").write_text(yaml.safe_dump(document), encoding="utf-8")
    return folder / "antenna.yaml"
