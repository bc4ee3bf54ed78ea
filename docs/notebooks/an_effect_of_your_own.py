# ---
# jupyter:
#   jupytext:
#     text_representation:
#       format_name: percent
# ---

# %% [markdown]
# # An effect of your own
#
# Wind on a dish: a torque that the catalogue does not have. An effect is one module and one entry point of the group
# `gimbal_hil.effects`. Here both are written by hand; in a package of yours `pyproject.toml` says
# `[project.entry-points."gimbal_hil.effects"]` and `wind = "my_effects:EFFECT"`.

# %%
import sys
from pathlib import Path
from tempfile import mkdtemp

LAW = '''
import numpy as np

from firmware_protocol.compiling import compiled
from sim_backend.effects import Domain, Effect, Hook, Parameter


@compiled
def wind_torque(P: np.ndarray, o: int, X: np.ndarray, s: int, q: float, v: float, h: float) -> float:
    """A push that grows with the sine of twice the angle, N m."""
    return P[o] * np.sin(2.0 * q)


EFFECT = Effect(
    name="wind",
    domain=Domain.MASS,
    hook=Hook.TORQUE,
    law=wind_torque,
    parameters=(Parameter("push", "N m", -10.0, 10.0, 0.0, "largest torque of the wind"),),
    text="wind on the dish",
    equation="T + push sin(2 q)",
    source="this notebook",
    excited_by="a wide motion in the wind",
)
'''
packages = Path(mkdtemp())
(packages / "my_effects.py").write_text(LAW)
info = packages / "my_effects-1.0.dist-info"
info.mkdir()
(info / "METADATA").write_text("Metadata-Version: 2.1\nName: my_effects\nVersion: 1.0\n")
(info / "entry_points.txt").write_text("[gimbal_hil.effects]\nwind = my_effects:EFFECT\n")
sys.path.insert(0, str(packages))

# %% [markdown]
# The catalogue has it now: model files, plant and search take it like any other. What uses it is compiled anew.

# %%
import numpy as np
import pandas as pd

from gimbal_hil import find_discrepancy
from sim_backend.effects import CATALOGUE
from sim_backend.model import model_from_document
from sim_backend.plant import Plant

print(CATALOGUE["wind"].equation)

# %% [markdown]
# A dish in the wind, and a model that knows of none.

# %%
axis = {
    "body": {"inertia": {"zz": 0.5}},
    "friction": {"coulomb": 0.2, "breakaway": 0.25, "stribeck_velocity": 0.01, "viscous": 0.3, "sigma0": 400.0},
}
document = {"schema": 1, "name": "dish", "kind": "rotary", "axes": {"dish": axis}}
model = model_from_document(document, "dish")
truth = model.with_effect("wind", "dish", {"push": 0.4})


def recorded(frequencies_hz: tuple[float, float]) -> pd.DataFrame:
    """A log of the dish under two sines of torque."""
    time_s = 1e-3 * np.arange(24_000)
    torque = sum(1.2 * np.sin(2 * np.pi * f * time_s) for f in frequencies_hz)
    motion = Plant(truth).run(np.asarray(torque)[:, None])
    return pd.DataFrame({"time_s": time_s, "dish.torque": torque, "dish.position": motion.encoder[:, 0]})


measured, holdout = recorded((0.23, 0.61)), recorded((0.31, 0.83))

# %%
finding = find_discrepancy(measured, holdout, model, only=["wind"])
print(finding.kind.value, "-", finding.verdict.text)
push = finding.effects[0]["parameters"]["push"]
print(f"push {push['value']:.3f} N m, {push['low']:.3f} to {push['high']:.3f}")

# %%
assert finding.effects[0]["name"] == "wind" and abs(push["value"] - 0.4) < 0.04
