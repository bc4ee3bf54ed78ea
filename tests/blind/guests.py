"""Effects that a user could have written and plugged in: two of the bench's causes outside the catalogue, as packages
with an entry point.

The text below is what such a user writes: it uses the product's API and none of the bench's code, whose antenna has its
own form of both.
"""

from __future__ import annotations

from pathlib import Path

_HEAD = '''"""An effect of somebody's own."""

import numpy as np

from firmware_protocol.compiling import compiled
from sim_backend.effects import Domain, Effect, Hook, Parameter


'''
_BUMP = '''@compiled
def bump_torque(P: np.ndarray, o: int, X: np.ndarray, s: int, q: float, v: float, h: float) -> float:
    """A push at one place of the travel, N m."""
    x = (q - P[o + 1]) / P[o + 2]
    return P[o] * np.exp(-0.5 * x * x)


EFFECT = Effect(
    name="position_bump",
    domain=Domain.STRUCTURE,
    hook=Hook.TORQUE,
    law=bump_torque,
    parameters=(
        Parameter("push", "N m", -1e3, 1e3, 0.0, "at the place"),
        Parameter("place", "rad", -10.0, 10.0, 0.0, "where it pushes most"),
        Parameter("width", "rad", 1e-3, 3.0, 0.1, "standard deviation of the bump"),
    ),
    text="something pushes at one place", equation="T + A exp(-((q - q0) / w)^2 / 2)", source="own",
    excited_by="slow motion over the place",
)
'''
_STOP = '''@compiled
def stop_torque(P: np.ndarray, o: int, X: np.ndarray, s: int, q: float, v: float, h: float) -> float:
    """A stop at either end that hardens, N m."""
    away = q - P[o + 1]
    deep = (abs(away) - P[o + 2]) / 0.1
    if deep <= 0.0:
        return 0.0
    push = 0.1 * P[o] * deep * deep * (1.0 + deep)
    return -push if away > 0.0 else push


EFFECT = Effect(
    name="hardening_stop",
    domain=Domain.STRUCTURE,
    hook=Hook.TORQUE,
    law=stop_torque,
    parameters=(
        Parameter("stiffness", "N m/rad", 0.0, 1e6, 0.0, "where it is 0.1 rad deep, half of its torque over 0.1 rad"),
        Parameter("centre", "rad", -10.0, 10.0, 0.0, "middle of the free travel"),
        Parameter("free", "rad", 0.0, 10.0, 0.5, "half of the free travel"),
    ),
    text="a stop that hardens", equation="T - k d^2 (1 + d) / 10, d = (abs(q - c) - w) / 0.1", source="own",
    excited_by="the ends of the travel",
)
'''
SOURCES = {"position_bump": _HEAD + _BUMP, "hardening_stop": _HEAD + _STOP}
#: parameter of the plugged-in effect -> column of the bench's antenna
ROWS = {
    "position_bump": {"push": "bump_a", "place": "bump_q", "width": "bump_w"},
    "hardening_stop": {"stiffness": "stop_k", "centre": "stop_q", "free": "stop_w"},
}


def install(name: str, folder: Path) -> Path:
    """What an installer leaves of the guest's package; answers the folder to put on the path."""
    module = f"guest_{name}"
    info = folder / f"{module}-1.0.dist-info"
    info.mkdir(parents=True, exist_ok=True)
    (folder / f"{module}.py").write_text(SOURCES[name], encoding="utf-8")
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {module}\nVersion: 1.0\n", encoding="utf-8")
    (info / "entry_points.txt").write_text(f"[gimbal_hil.effects]\n{module} = {module}:EFFECT\n", encoding="utf-8")
    return folder
