"""A case on disk: logs and model for the workflow in one folder, the truth apart from it. Writes with no code of the
product.
"""

from __future__ import annotations

import contextlib
import json
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import yaml

from tests.blind.draw import Case, Unstable, draw
from tests.blind.kinds import Job, Stated
from tests.blind.rig import Axes, Rig

SHIPPED_MODEL = Path(__file__).resolve().parents[2] / "config" / "models" / "thesis.yaml"
_FRICTION = {"Ts": "breakaway", "Tc": "coulomb", "vs": "stribeck_velocity", "delta": "shape", "s2": "viscous"}
_BRISTLE = {"s0": "sigma0", "s1": "sigma1"}
_TENSOR = ("xx", "yy", "zz", "xy", "xz", "yz")


def model_document(rig: Rig, stated: Stated) -> dict[str, Any]:
    """The rig as a model file that says of its numbers what it is told to."""
    if rig.shipped:
        return dict(yaml.safe_load(SHIPPED_MODEL.read_text(encoding="utf-8")))
    source = {Stated.MEASURED: "measured", Stated.CAD: "CAD"}.get(stated)

    def number(value: float) -> Any:
        return {"value": float(value), "source": source} if source else float(value)

    axes: dict[str, dict[str, Any]] = {}
    for a, name in enumerate(rig.names):
        where = ("outer", "inner")[a]
        columns = _FRICTION | (_BRISTLE if rig.states_bristle else {})
        axes[name] = {
            "body": _body(rig, rig.bodies[where], number),
            "friction": {key: number(rig.friction[where][column]) for column, key in columns.items()},
            "actuator": {"limit": float(rig.limits[a])},
            "encoder": {"step": float(rig.encoder_step)},
        }
        if a == 1:
            axes[name]["parent"] = rig.names[0]
    document: dict[str, Any] = {"schema": 1, "name": "bench", "kind": rig.axes.name.lower(), "axes": axes}
    if rig.axes is not Axes.GIMBAL:
        document["incline_sine"] = 1.0 if rig.axes is Axes.ROTARY else 0.0
    if stated is Stated.EXACT:
        document["uncertainty"] = "0.1%"
    return document


def _body(rig: Rig, row: np.ndarray, number: Any) -> dict[str, Any]:
    if rig.axes is Axes.LINEAR:
        return {"mass": number(row[9])}
    cog = {axis: number(row[6 + i]) for i, axis in enumerate("xyz")}
    return {"mass": number(row[9]), "cog": cog, "inertia": {key: number(row[i]) for i, key in enumerate(_TENSOR)}}


def write_log(columns: dict[str, np.ndarray], path: Path) -> None:
    """One signals table."""
    pq.write_table(pa.table({name: pa.array(values) for name, values in columns.items()}), path, compression="zstd")


def _stable(job: Job, bench_seed: int) -> Case:
    """The case as its seed draws it, or the first of the next seeds whose loop stands it."""
    for again in range(10):
        with contextlib.suppress(Unstable):
            return draw((job.seed(bench_seed) + again) % 2**63, **job.arguments)
    raise Unstable(f"{job.name}: ten draws in a row")


def write_case(job: Job, bench_seed: int, folder: Path) -> None:
    """Draw a case; logs and model into `folder`/data, truth into `folder`/truth.json."""
    case = _stable(job, bench_seed)
    data = folder / "data"
    data.mkdir(parents=True, exist_ok=True)
    for kind, logs in (("measured", case.measured), ("holdout", case.holdout)):
        for i, columns in enumerate(logs):
            write_log(columns, data / f"{kind}_{i}.parquet")
    if case.rig.shipped:
        (data / "model.yaml").write_bytes(SHIPPED_MODEL.read_bytes())
    else:
        # sorted by name, as any tool may leave it: `parent` says which axis carries which
        (data / "model.yaml").write_text(yaml.safe_dump(model_document(case.rig, job.stated)), encoding="utf-8")
    truth = case.truth | {"stated": job.stated.name}
    # last of all, so that a case with a truth is whole
    (folder / "truth.json").write_text(json.dumps(truth, indent=1, default=float), encoding="utf-8")
