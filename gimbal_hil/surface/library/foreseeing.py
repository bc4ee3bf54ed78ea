"""What a run could show, before any data, for scripts."""

from __future__ import annotations

from pathlib import Path

from gimbal_hil.knowledge.discrepancy import Foreseen, foreseen
from gimbal_hil.loop.settings import DaemonSettings
from gimbal_hil.surface.library.antenna import Antenna
from sim_backend.model import AntennaModel


def foresee(
    plan: str,
    model: str | Path | AntennaModel | None = None,
    config: str | Path | DaemonSettings | None = None,
    *,
    short: bool = False,
) -> Foreseen:
    """What a sequence or a plan file could show on an antenna: rehearsed in lockstep on the model alone.

    BadInputError for a plan that ends early on this antenna, or is too short for the scored band.
    """
    from firmware_protocol.errors import BadInputError
    from gimbal_hil.knowledge.experiments.sequences import SequenceOptions, breakaway_torques, build_experiment
    from gimbal_hil.knowledge.improvement import rehearse
    from sim_backend.model import shipped_model

    antenna = Antenna(shipped_model() if model is None and config is None else model, config)
    settings = antenna.settings
    torques = breakaway_torques(antenna.model)
    options = SequenceOptions(
        settings.rate_hz, settings.axis_names, short=short, breakaway_nm=torques, names=settings.axis_names
    )
    rehearsal = rehearse(build_experiment(plan, options), settings, antenna.model, antenna.seed)
    if rehearsal.stopped is not None or rehearsal.table is None:
        raise BadInputError(plan, f"comes to no end on this antenna: {rehearsal.stopped}", "a run that it can follow")
    return foreseen(antenna.model, rehearsal.table)
