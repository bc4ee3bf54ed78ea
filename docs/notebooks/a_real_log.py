# ---
# jupyter:
#   jupytext:
#     text_representation:
#       format_name: percent
# ---

# %% [markdown]
# # A real log
#
# EMPS, a carriage on a ball screw at Centrale Nantes (Janot, Gautier and Brunot, 2019), published as
# `DATA_EMPS.mat` and `DATA_EMPS_PULSES.mat`. Put both into a folder `emps` and name the folder above it in
# `GIMBAL_HIL_DATA`. Any other log does as well: it needs time, position and the commanded torque or force.

# %%
import os
from pathlib import Path

import pandas as pd
from scipy.io import loadmat

from gimbal_hil import find_discrepancy, identify

folder = Path(os.environ.get("GIMBAL_HIL_DATA", ".")) / "emps"


def log(name: str) -> pd.DataFrame:
    """A file of the data set with the columns of a signals table (docs/reference/signals-table.md)."""
    data = loadmat(folder / f"{name}.mat")
    return pd.DataFrame(
        {
            "time_s": data["t"].ravel(),
            "carriage.torque": data["vir"].ravel() * data["gtau"].item(),
            "carriage.position": data["qm"].ravel(),
            "carriage.position_ref": data["qg"].ravel(),
        }
    )


plain, pulses = log("DATA_EMPS"), log("DATA_EMPS_PULSES")
print(plain.describe().T[["mean", "min", "max"]])

# %% [markdown]
# Friction with intervals. The model `emps` ships; it has the published mass.

# %%
friction = identify(plain, model="emps")
print(friction.frame().to_string())

# %%
friction.figures()[0]

# %% [markdown]
# What does the model lack? The second file, with pulses, judges.

# %%
finding = find_discrepancy(plain, pulses, model="emps")
print(finding.kind.value, "-", finding.verdict.text)

# %%
assert not friction.frame().empty and len(friction.figures()) > 0
assert finding.kind.value in ("named", "ambiguous", "unexplained", "no_discrepancy")
