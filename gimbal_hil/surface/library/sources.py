"""Measured data and models as a script has them: files, folders, runs, DataFrames, names."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from firmware_protocol.errors import BadInputError
from gimbal_hil.surface.library.run import Run
from sim_backend.model import AntennaModel, model_named

if TYPE_CHECKING:
    import pandas as pd

    from gimbal_hil.pages.report import Block, Plot

    #: measured data: a run folder, a table file, a `Run`, or a DataFrame with the columns of a signals table
    Source: TypeAlias = str | Path | Run | pd.DataFrame
else:
    Source = Any


def model_of(model: str | Path | AntennaModel | None) -> AntennaModel:
    """A model from an object, a file or the name of a shipped one; without any the thesis'."""
    return model if isinstance(model, AntennaModel) else model_named(model or "thesis")


def as_list(sources: Source | Sequence[Source]) -> list[Source]:
    """One source, or several, as several."""
    return list(sources) if isinstance(sources, list | tuple) else [sources]


@contextmanager
def as_paths(sources: Sequence[Source], name: str) -> Iterator[list[Path]]:
    """Paths of the sources; a DataFrame lies in a file of that name meanwhile, and passes the door that all files
    pass.
    """
    with TemporaryDirectory() as folder:
        try:
            yield [_path(source, Path(folder) / f"{name}-{place}.npz") for place, source in enumerate(sources)]
        except BadInputError as refused:
            if folder not in refused.where:
                raise
            # nobody has that file but this function: the caller knows the table by its place
            where = re.sub(rf"{re.escape(folder)}/{name}-(\d+)\.npz", rf"{name} \1 (a DataFrame)", refused.where)
            raise BadInputError(where, refused.problem, refused.expected, refused.others) from refused


def _path(source: Source, spare: Path) -> Path:
    if isinstance(source, Run):
        return source.folder
    if isinstance(source, str | Path):
        return Path(source)
    if not hasattr(source, "rename_axis"):
        raise BadInputError(spare.stem, f"is a {type(source).__name__}", "a path, a Run or a DataFrame")
    names = [".".join(word for word in name if word) if isinstance(name, tuple) else str(name) for name in source]
    frame = source.set_axis(names, axis=1)
    frame = frame if "time_s" in names else frame.rename_axis("time_s").reset_index()
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise BadInputError(spare.stem, f"has two columns named {twice!r}", "every name once")
    columns = {str(name): frame[name].to_numpy() for name in frame.columns}
    np.savez(
        spare, **{name: cells if cells.dtype.kind in "fiubMm" else cells.astype(str) for name, cells in columns.items()}
    )
    return spare


def plots_of(blocks: Sequence[Block]) -> list[Plot]:
    """All plots of a page in their order, folded ones too."""
    from gimbal_hil.pages.report import Details, Plot

    found: list[Plot] = []
    for block in blocks:
        if isinstance(block, Plot):
            found.append(block)
        elif isinstance(block, Details):
            found += plots_of(list(block.blocks))
    return found
