"""Small rigs with closed-form motions: one rotary axis without friction or gravity, and the thesis' antenna without
sensor noise.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from sim_backend.model import AntennaModel, model_from_document, shipped_model
from sim_backend.plant import Plant, Simulation

STEP_S = 1e-4
RATE_HZ = 1000.0


def rotary(
    inertia: float = 0.5, start_position: float = 0.0, start_rate: float = 0.0, **friction: float
) -> AntennaModel:
    """One frictionless vertical axis; `friction` puts numbers of the model file's friction section in."""
    axis: dict[str, Any] = {
        "body": {"inertia": {"zz": inertia}},
        "start": {"position": start_position, "rate": start_rate},
        "friction": dict(friction),
    }
    return model_from_document({"schema": 1, "name": "rig", "kind": "rotary", "axes": {"axis": axis}}, "rig")


def horizontal(inertia: float, mass: float, cog_y: float, start_position: float) -> AntennaModel:
    """A pendulum: one frictionless horizontal axis with its centre of mass off the pivot."""
    axis = {
        "body": {"inertia": {"zz": inertia}, "mass": mass, "cog": {"y": cog_y}},
        "start": {"position": start_position},
    }
    document = {"schema": 1, "name": "rig", "kind": "rotary", "incline_sine": 1.0, "axes": {"axis": axis}}
    return model_from_document(document, "rig")


def antenna(**base: Any) -> AntennaModel:
    """The thesis' antenna with ideal sensors, on a base given as in a model file (fixed when empty)."""
    model = shipped_model()
    for axis in model.axes:
        for path in ("encoder.step", "gyro.noise", "gyro.step"):
            model = model.with_number(axis, path, 0.0)
    return model.with_base(base) if base else model


def with_effect(model: AntennaModel, name: str, axis: str | None = None, **parameters: float) -> AntennaModel:
    """The model with an effect on its first axis, or on a named one."""
    return model.with_effect(name, axis or model.axes[0], parameters)


def run(model: AntennaModel, torque: np.ndarray | float, samples: int | None = None) -> Simulation:
    """Simulate from the start: torque (n,) or (n, axes), or one number held for `samples`."""
    if isinstance(torque, float | int):
        torque = np.full(samples or 1000, float(torque))
    torque = np.asarray(torque, dtype=float)
    if torque.ndim == 1:
        torque = np.column_stack([torque] + [np.zeros(len(torque))] * (len(model.axes) - 1))
    return Plant(model, RATE_HZ).run(torque)


def times(motion: Simulation) -> np.ndarray:
    """Sample times of a motion, s."""
    return np.arange(len(motion.position)) / RATE_HZ


def columns(motion: Simulation) -> Mapping[str, np.ndarray]:
    """Every column of a motion by name."""
    return {name: getattr(motion, name) for name in ("position", "rate", "encoder", "gyro", "applied", "friction")}
