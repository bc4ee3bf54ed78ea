"""A joint that swings, as text in whatever form somebody's logger writes it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sim_backend.model import AntennaModel, model_from_document

PERIOD_S, ROWS = 2e-3, 600
T = PERIOD_S * np.arange(ROWS)
#: position, rate and acceleration of two swings
_SWINGS = ((0.9, 3.0), (0.4, 9.0))
Q = sum(size * np.sin(w * T) for size, w in _SWINGS)
_V = sum(size * w * np.cos(w * T) for size, w in _SWINGS)
_A = sum(-size * w * w * np.sin(w * T) for size, w in _SWINGS)
U = 0.02 * _A + 0.05 * np.sign(_V) + 0.02 * _V
HEADER = ("time_s", "joint.torque", "joint.position")


def joint() -> AntennaModel:
    """The model that knows this joint."""
    axis = {
        "body": {"inertia": {"zz": 0.02}},
        "friction": {"coulomb": 0.05, "breakaway": 0.05, "stribeck_velocity": 0.01, "viscous": 0.02},
        "actuator": {"limit": 3.0},
        "encoder": {"step": 1e-4},
    }
    return model_from_document({"schema": 1, "name": "joint", "kind": "rotary", "axes": {"joint": axis}}, "test")


def lines(between: str = ",", header: Sequence[str] | None = HEADER, comma: bool = False, end: str = "") -> list[str]:
    """The log as lines, each with `end` behind it."""
    rows = [(f"{t:.3f}", f"{u:.6f}", f"{q:.6f}") for t, u, q in zip(T, U, Q, strict=True)]
    text = [between.join(cell.replace(".", ",") if comma else cell for cell in row) for row in rows]
    return [line + end for line in ([between.join(header), *text] if header else text)]


def grouped(number: int, mark: str) -> str:
    """A whole number with a mark between its thousands."""
    return f"{number:,d}".replace(",", mark)
