"""Arguments and options that several commands take in the same words."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, TypeAlias

import typer

from gimbal_hil.surface.cli.completion import model_names

#: the model that logs or a plan are asked about
AskedModel: TypeAlias = Annotated[
    str | None,
    typer.Option(
        metavar="MODEL",
        autocompletion=model_names,
        help="Model file, or name of a shipped one; without it the shipped model thesis.",
    ),
]
#: a daemon that is looked at
DaemonRun: TypeAlias = Annotated[
    Path | None, typer.Argument(metavar="RUN", help="Run folder of the daemon; without it the newest below ./runs.")
]
#: how long a client of a daemon stays
EndAfter: TypeAlias = Annotated[
    float, typer.Option(metavar="SECONDS", help="End after so long; 0: with Ctrl-C or the daemon.", min=0.0)
]
