"""The bench's list of cases, and how each is written to disk: logs and model for the workflow, truth apart from them."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gimbal_hil.signals import SignalsTable, write_signals
from sim_backend.model import AntennaModel, model_from_document, shipped_model
from tests.blind.draw import BODY, THESIS, Case, catalogue, draw, outside


@dataclass(frozen=True)
class Job:
    """One case of the bench: its name and what `draw` is called with."""

    name: str
    arguments: dict[str, Any]


def jobs(nulls: int = 100, pairs: int = 60, per_effect: int = 3) -> list[Job]:
    """Every effect on every axis, nulls with and without a field, pairs, outside causes, floating starts, single axes."""
    rng = np.random.default_rng(0)
    effects = [c.name for c in catalogue(rng, "outer", 0)]
    found = []
    for k in range(per_effect):
        for i, name in enumerate(effects):
            for j, axis in enumerate(("outer", "inner")):
                found.append(Job(f"{name}.{axis}.{k}", {"seed": 10000 + 1000 * k + 2 * i + j, "names": [name], "axis": axis}))
    for i in range(nulls):
        found.append(Job(f"null.{i}", {"seed": 20000 + i, "names": [], "field_on_null": i % 2 == 1}))
    for i in range(pairs):
        found.append(Job(f"pair.{i}", {"seed": 30000 + i, "count": 2}))
    for i, cause in enumerate(outside(rng, "outer")):
        for j, axis in enumerate(("outer", "inner")):
            arguments = {"seed": 40000 + 2 * i + j, "names": [cause.name], "axis": axis, "outside_cause": True}
            found.append(Job(f"outside.{cause.name}.{axis}", arguments))
    for i in range(10):
        found.append(Job(f"floating_null.{i}", {"seed": 50000 + i, "names": [], "off": 0.08}))
        found.append(Job(f"floating.{i}", {"seed": 51000 + i, "off": 0.08}))
    single = ("cogging", "coulomb", "stribeck", "cable_spring", "viscous_asymmetry", "inertia", "torque_offset", "quadratic_drag")
    for i, name in enumerate(single):
        found.append(Job(f"rotary.{name}", {"seed": 60000 + i, "names": [name], "kind": 1, "axis": "outer"}))
        if name != "cable_spring":
            found.append(Job(f"linear.{name}", {"seed": 61000 + i, "names": [name], "kind": 2, "axis": "outer"}))
    return found


def single_axis_model(kind: int) -> AntennaModel:
    """Model file of the one-axis antennas: the thesis' outer axis standing alone."""
    f, body = THESIS["outer"], BODY["outer"]
    friction = {"breakaway": f["Ts"], "coulomb": f["Tc"], "stribeck_velocity": f["vs"], "shape": f["delta"]}
    friction |= {"sigma0": f["s0"], "sigma1": f["s1"], "viscous": f["s2"]}
    mass: dict[str, Any] = {"mass": float(body[9])}
    if kind == 1:
        mass |= {"cog": {"x": float(body[6]), "y": float(body[7])}, "inertia": {"zz": float(body[2])}}
    sensors = {"encoder": {"step": 2 * np.pi / 2**22}}
    document = {
        "schema": 1, "name": "one axis", "kind": "rotary" if kind == 1 else "linear", "incline_sine": 1.0 if kind == 1 else 0.0,
        "axes": {"outer": {"body": mass, "friction": friction, "actuator": {"limit": 15.5}, **sensors}},
    }  # fmt: skip
    return model_from_document(document, "single axis")


def model_of(case: Case) -> AntennaModel:
    """The model that the workflow is given."""
    return shipped_model() if case.kind == 0 else single_axis_model(case.kind)


def tables_of(columns: list[dict[str, np.ndarray]], axes: tuple[str, ...]) -> tuple[SignalsTable, ...]:
    """Drawn columns as signals tables."""
    return tuple(
        SignalsTable.of(axes, c["time_s"], {k: v for k, v in c.items() if k not in ("time_s", "repeat")}, c.get("repeat"), f"log {i}")
        for i, c in enumerate(columns)
    )


def write_case(job: Job, folder: Path) -> None:
    """Logs and model into `folder`/data, truth into `folder`/truth.json."""
    case = draw(**job.arguments)
    data = folder / "data"
    data.mkdir(parents=True, exist_ok=True)
    for kind, columns in (("measured", case.measured), ("holdout", case.holdout)):
        for i, table in enumerate(tables_of(columns, case.axes)):
            write_signals(table, data / f"{kind}_{i}.parquet", force=True)
    (data / "model.yaml").write_text(model_of(case).to_yaml(), encoding="utf-8")
    (folder / "truth.json").write_text(json.dumps(case.truth, indent=1, default=float), encoding="utf-8")
