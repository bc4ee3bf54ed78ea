"""The ghost of an antenna: a model given the torque that was recorded, beside the motion that was measured.

The run is done again on a virtual antenna of the model. The axis in question gets the recorded torque and no loop that
could hide an error; the other one follows its reference as it did. Where the model is right the ghost stays on the
antenna; where it lacks something it drifts away.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.signals import SignalsTable, read_signals
from gimbal_hil.knowledge.experiments import Experiment, Row, Signals, Step, conduct, step_of
from gimbal_hil.loop.host import AxisCommand, Mode, Shape
from gimbal_hil.loop.settings import DaemonSettings
from gimbal_hil.pages.report import Block, ModelMotion, MovingAntenna
from sim_backend.model import AntennaModel

#: rows of the moving picture in a second
_ROWS_HZ = 25.0


def ghost_of(
    measured: SignalsTable, axis: str, model: AntennaModel, settings: DaemonSettings, seed: int, folder: Path
) -> NDArray[np.float64]:
    """Positions (n, 2), rad, of a model that is given the torque of `axis` row by row; those of the measured run stand
    in `measured`. The run itself is left in `folder`.

    BadInputError where the measured run has no position reference, or the ghost's run ended early.
    """
    other = next(name for name in model.axes if name != axis)
    reference, torque = measured.signal(other, "position_ref"), measured.torque(axis)
    if reference is None or not torque.any():
        raise BadInputError(measured.source or "log", f"has no {other}.position_ref or no torque", "a run of a survey")
    # before its first torque the host only connected, in as many ticks as it will take again
    begin, end = int(np.argmax(torque != 0.0)), len(measured)
    row_s = measured.period_s
    led = AxisCommand(Mode.POSITION, Shape.TABLE, (row_s, 1.0), table=reference[begin:end])
    driven = AxisCommand(Mode.TORQUE, Shape.TABLE, (row_s, 1.0), table=torque[begin:end])
    commands = [driven if name == axis else led for name in model.axes]
    step = step_of("ghost", settings.rate_hz, (end - begin) * row_s, commands)
    again = Experiment("ghost", "The recorded torque again", (step,), _nothing, _no_blocks)
    conduct(again, settings, model, seed, folder, force=True)
    moved = read_signals(folder, model.axes)
    found = np.column_stack([moved.columns[f"{name}.position"] for name in model.axes])
    if len(found) < end:
        raise BadInputError(str(folder), f"ended after {len(found)} rows", f"{end}, as the measured run has")
    return found[:end]


def side_by_side(measured: SignalsTable, axis: str, ghosts: Mapping[str, NDArray[np.float64]]) -> MovingAntenna:
    """The measured motion with its ghosts, by what is said of each model; below it, how far each is off at the end."""
    few = slice(None, None, max(1, round(1.0 / (_ROWS_HZ * measured.period_s))))
    outer, inner = measured.axes
    positions = np.column_stack([measured.columns[f"{name}.position"] for name in measured.axes])
    place = measured.axes.index(axis)
    off = {name: math.degrees(abs(float(found[-1, place] - positions[-1, place]))) for name, found in ghosts.items()}
    told = "; ".join(f"{name}: {degrees:.2g}\u00b0" for name, degrees in off.items())
    said = (
        f"The ghost (orange lines) gets the torque that was recorded on {axis}, and no loop that could correct it; "
        "the other axis follows its reference. "
        f"How far the ghost is off on {axis} after {measured.time_s[-1]:.0f} s: {told}."
    )
    if len(ghosts) == 1:
        said += " Nothing was added to the model, so it goes on drifting."
    time_s = measured.time_s[few] - measured.time_s[0]
    models = [ModelMotion(name, found[few].T.tolist()) for name, found in ghosts.items()]
    title = "The antenna, and its model as a ghost"
    return MovingAntenna(title, (outer, inner), time_s.tolist(), positions[few].T.tolist(), models, said)


def _nothing(step: Step, signals: Signals) -> Row | None:
    return None


def _no_blocks(rows: object, drawn: object) -> list[Block]:
    return []
