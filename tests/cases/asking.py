"""A log as both commands take it in."""

from __future__ import annotations

from pathlib import Path

from gimbal_hil.data.preflight import preflight, questioned
from gimbal_hil.data.signals import ColumnMap, SignalsTable, read_signals
from sim_backend.model import load_model


def asked(
    folder: Path, text: str, words: tuple[str, ...] = (), repair: bool = False, **reading: object
) -> SignalsTable:
    """The log with this text beside `model.yaml`, read, questioned and repaired as asked."""
    (folder / "log.csv").write_text(text)
    model = load_model(folder / "model.yaml")
    table = read_signals(folder / "log.csv", model, columns=ColumnMap.of_words(words), **reading)  # type: ignore[arg-type]
    tables = questioned(model, [table], repair)
    preflight(model, tables)
    return tables[0]
