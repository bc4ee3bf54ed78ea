"""Models whose every number is off: what loops that rely on one are worth when it is not true."""

from __future__ import annotations

import copy
import random
from pathlib import Path
from typing import Any

from gimbal_hil.loop.settings import DaemonSettings
from sim_backend.model import AntennaModel, model_from_document, model_named

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
    """Settings whose loops take their numbers from a wrong model, which is written into `folder`; without
    `model_control` they stay.
    """
    control = settings.model_control
    if control is None or share == 0.0:
        return settings
    file = folder / "wrong.yaml"
    file.write_text(wrong_model(model_named(control.model), share, seed).to_yaml(), encoding="utf-8")
    return settings.model_copy(update={"model_control": control.model_copy(update={"model": str(file)})})
