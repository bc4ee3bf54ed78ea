"""Drawn cases as the product's own types, for tests that call it without files."""

from __future__ import annotations

import numpy as np

from gimbal_hil.data.signals import SignalsTable
from sim_backend.model import AntennaModel, model_from_document
from tests.blind.draw import Case
from tests.blind.files import model_document
from tests.blind.kinds import Stated


def model_of(case: Case, stated: Stated = Stated.EXACT) -> AntennaModel:
    """The model that the workflow is given, its numbers known as well as stated."""
    return model_from_document(model_document(case.rig, stated), "the case's model")


def tables_of(columns: list[dict[str, np.ndarray]], axes: tuple[str, ...]) -> tuple[SignalsTable, ...]:
    """Drawn columns as signals tables."""
    return tuple(
        SignalsTable.of(
            axes,
            c["time_s"],
            {k: v for k, v in c.items() if k not in ("time_s", "repeat")},
            c.get("repeat"),
            f"log {i}",
        )
        for i, c in enumerate(columns)
    )
