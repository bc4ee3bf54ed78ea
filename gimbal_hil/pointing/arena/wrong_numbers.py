"""Models whose every number is off: what loops that rely on one are worth when it is not true."""

from __future__ import annotations

import copy
import random
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gimbal_hil.loop.settings import AxisSettings, DaemonSettings
from sim_backend.model import CONTROL_ANTENNA, AntennaModel, model_from_document, model_named

Law = NDArray[np.float64]
#: numbers that are off together, because no body (no friction) has them apart
_TOGETHER = ("inertia", "cog", "breakaway", "coulomb")


def wrong_model(model: AntennaModel, share: float, seed: int) -> AntennaModel:
    """The model with every number of its axes and effects off by `share` of itself: all larger for seed 1, all smaller
    for seed 2, after that by signs that the seed draws; a tensor, a centre of gravity, and sliding with break-away
    friction have one sign each.
    """
    draw = random.Random(seed)
    signs: dict[tuple[str, ...], float] = {}

    def sign(path: tuple[str, ...]) -> float:
        if seed <= 2:
            return 1.0 if seed == 1 else -1.0
        group = next((i for i, word in enumerate(path) if word in _TOGETHER), None)
        if group is not None:
            path = (*path[:group], "friction level") if path[group] in _TOGETHER[2:] else path[: group + 1]
        return signs.setdefault(path, draw.choice((1.0, -1.0)))

    def walk(node: Any, path: tuple[str, ...]) -> None:
        if isinstance(node, dict) and "value" in node:
            node["value"] *= 1.0 + share * sign(path)
            return
        for key, value in node.items() if isinstance(node, dict) else enumerate(node):
            if isinstance(value, dict | list):
                walk(value, (*path, str(key)))
            elif isinstance(value, float) and isinstance(node, dict):
                node[key] = value * (1.0 + share * sign((*path, str(key))))

    document = copy.deepcopy(model.document)
    walk(document["axes"], ("axes",))
    walk(document.get("effects", []), ("effects",))
    return model_from_document(document, f"{model.where}, {share:g} off")


def with_wrong_model(settings: DaemonSettings, share: float, seed: int, folder: Path) -> DaemonSettings:
    """Settings of somebody whose model is wrong, which is written into `folder`: torques fed forward by its numbers,
    and gains off as its inertias are, because a loop's gain is a crossing times an inertia, whoever chose it.
    """
    if share == 0.0:
        return settings
    control = settings.model_control
    model = model_named(control.model if control is not None else CONTROL_ANTENNA)
    wrong = wrong_model(model, share, seed)
    changed: dict[str, object] = {
        "axes": {axis: _off(settings.axes[axis], model, wrong, axis) for axis in settings.axes}
    }
    if control is not None:
        file = folder / "wrong.yaml"
        file.write_text(wrong.to_yaml(), encoding="utf-8")
        changed["model_control"] = control.model_copy(update={"model": str(file)})
    return settings.model_copy(update=changed)


def with_wrong_law(law: Law, settings: DaemonSettings, share: float, seed: int) -> Law:
    """A law of somebody whose model is wrong: its torques off as its inertias are."""
    if share == 0.0:
        return law
    model = model_named(settings.model_control.model if settings.model_control is not None else CONTROL_ANTENNA)
    wrong, size = wrong_model(model, share, seed), law.shape[1] - 1
    found = law.copy()
    for place, axis in zip(found, model.axes, strict=True):
        path = model.own_inertia_path(axis)
        place[size] *= wrong.number(axis, path) / model.number(axis, path)
    return found


def _off(section: AxisSettings, model: AntennaModel, wrong: AntennaModel, axis: str) -> AxisSettings:
    def ratio(path: str) -> float:
        known = model.number(axis, path)
        return wrong.number(axis, path) / known if known else 1.0

    inertia, friction = ratio(model.own_inertia_path(axis)), ratio("friction.coulomb")
    weight = ratio("body.mass") * ratio("body.cog.x")
    loop, forward, observer = section.rate_loop, section.feedforward, section.observer
    kp = observer.rate_kp_s_per_rad if observer is not None else None
    return section.model_copy(
        update={
            "rate_loop": loop.model_copy(
                update={"kp_s_per_rad": inertia * loop.kp_s_per_rad, "ki_per_rad": inertia * loop.ki_per_rad}
            ),
            "feedforward": forward.model_copy(
                update={
                    "coulomb_nm": friction * forward.coulomb_nm,
                    "viscous_nm_s_per_rad": ratio("friction.viscous") * forward.viscous_nm_s_per_rad,
                    "moment_kg_m": tuple(weight * moment for moment in forward.moment_kg_m),
                }
            ),
            "observer": observer.model_copy(update={"rate_kp_s_per_rad": inertia * kp})
            if observer and kp
            else observer,
        }
    )
