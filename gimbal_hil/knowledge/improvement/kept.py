"""The files that a round keeps: verdict, page and model, as `discrepancy` writes them."""

from __future__ import annotations

import json
from pathlib import Path

from gimbal_hil.knowledge.discrepancy import Result, Verdict, corrected_model, discrepancy_page
from sim_backend.model import AntennaModel

MODEL_FILE = "model.yaml"


def keep_round(
    folder: Path, diagnosis: Result, verdict: Verdict, model: AntennaModel | None, sources: list[str]
) -> None:
    """Write `verdict.json`, `report.html` and, where there is one, `model.yaml` into a round's folder, which is made if
    it is not there.
    """
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "verdict.json").write_text(
        json.dumps(verdict.document, indent=2, allow_nan=False) + "\n", encoding="utf-8"
    )
    discrepancy_page(diagnosis, verdict, corrected_model(diagnosis), sources).write(folder / "report.html")
    if model is not None:
        (folder / MODEL_FILE).write_text(model.to_yaml(), encoding="utf-8")
