"""A pendulum on a hobby servo in a position loop: duty cycle, supply voltage, position; no torque was measured."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from tests.rigs.data import data_folder
from tests.rigs.rig import Rig, write_log, write_model

AXIS = "pendulum"
#: N m at a supply of 5 V and full duty, data sheet
STALL_TORQUE, STALL_VOLTS = 0.52, 5.0
FULL_DUTY = 885
#: N m: 0.49 kg at 0.1 m, without the rod
KNOWN_UNBALANCE = 0.49 * 9.81 * 0.1


def write_bam(folder: Path, scaled: Mapping[str, float] | None = None) -> Rig:
    """The sixteen runs (keys `kp100_sin_sin` ...) and the model of one who forgot that the mass hangs beside the axis.

    Torque is stall torque per volt times duty times supply, which leaves the back-EMF in the viscous number. In
    `lift_and_drop` the motor is switched off half way; there its duty counts as zero.
    """
    folder.mkdir(parents=True, exist_ok=True)
    logs = {}
    for file in sorted(data_folder("bam").glob("*.json")):
        run = json.loads(file.read_text())
        entries = {key: np.array([float(entry[key]) for entry in run["entries"]]) for key in run["entries"][0]}
        load = entries["load"]
        # sixteen bits, two's complement
        duty = np.where(load >= 32768, load - 65536, load) / FULL_DUTY * entries["torque_enable"]
        columns = {
            "time_s": entries["timestamp"],
            f"{AXIS}.torque": STALL_TORQUE / STALL_VOLTS * duty * entries["input_volts"],
            f"{AXIS}.position": entries["position"],
            f"{AXIS}.position_ref": entries["goal_position"],
            f"{AXIS}.temperature": entries["temp"],
        }
        name = f"kp{run['kp']}_{run['trajectory']}"
        logs[name] = write_log(folder / f"{name}.csv", columns)
    return Rig(write_model(folder / "bam.yaml", _model(), scaled), logs)


def _model() -> dict:
    axis = {
        "body": {
            "mass": {"value": 0.49, "unit": "kg", "source": "measured"},
            "inertia": {
                "zz": {"value": 0.49 * 0.1**2, "unit": "kg m2", "source": "inferred, 0.49 kg at 0.1 m without the rod"}
            },
        },
        "friction": {
            "coulomb": {"value": 0.03, "unit": "N m", "source": "assumed"},
            "breakaway": {"value": 0.03, "unit": "N m", "source": "assumed, no bump"},
            "viscous": {
                "value": 0.037,
                "unit": "N m s/rad",
                "source": "inferred from stall torque and speed, back-EMF included",
            },
        },
        "encoder": {
            "step": {"value": 2.0 * float(np.pi) / 4096, "unit": "rad", "source": "printed, 4096 counts a turn"}
        },
    }
    return {"schema": 1, "name": "bam", "kind": "rotary", "incline_sine": 1.0, "axes": {AXIS: axis}}
