# ---
# jupyter:
#   jupytext:
#     text_representation:
#       format_name: percent
# ---

# %% [markdown]
# # From nothing to a named effect
#
# No hardware: an antenna that has something which its model does not know, two runs of it, and the search for what it
# is. On a real antenna the two runs come from `gimbal-hil experiment survey --run DAEMON`; the rest is the same.

# %%
from pathlib import Path
from tempfile import mkdtemp

from gimbal_hil import Antenna, find_discrepancy

folder = Path(mkdtemp())
model = Antenna().model

# %% [markdown]
# The antenna as it is: twelve cogs a turn on the outer axis. The model knows nothing of them.

# %%
antenna = Antenna().with_effect("cogging", "outer", amplitude=0.03, order=12, phase=0.7)

# %% [markdown]
# One run to search in, another trajectory to judge on.

# %%
measured = antenna.experiment("survey", folder / "measured", short=True)
holdout = antenna.experiment("survey_holdout", folder / "holdout", short=True)
frame = measured.frame()
print(frame.describe().T[["mean", "min", "max"]])
print(frame.attrs["units"])

# %%
measured.figure("outer.position", "outer.rate", "outer.torque")

# %%
finding = find_discrepancy(measured, holdout, model)
print(finding.kind.value, "-", finding.verdict.text)

# %%
effect = finding.effects[0]
print(effect["name"], effect["axis"], effect["parameters"])

# %% [markdown]
# The model with what was named, and the figures of the report as objects.

# %%
assert finding.model is not None
(folder / "model.yaml").write_text(finding.model.to_yaml())
figures = finding.figures()
print(len(figures), "figures;", folder / "model.yaml")

# %%
assert finding.kind.value == "named" and (effect["name"], effect["axis"]) == ("cogging", "outer")
assert abs(effect["parameters"]["amplitude"]["value"] - 0.03) < 0.006
