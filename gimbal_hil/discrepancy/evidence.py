"""What is evidence: the commanded torque that the measured motion asks for, through the hypothesis' own actuator.

A residual "torque given minus torque needed" can be shrunk by a hypothesis that deletes the torque: a low limit, a gain near zero, a
long lag. What such a hypothesis cannot do is say which *command* was sent. So the residual is divided by the share of a small
change of the command that comes through the hypothesis' actuator and structure, which is that of the log-likelihood's change of
variables, p(u | motion) = p(residual) |d residual / d u|: a limit that cuts everything, or a gain of one per cent, gains nothing.
The share is measured: the twin is evaluated with a small random change of the command, whatever the hypothesis is.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gimbal_hil.discrepancy.hypothesis import Hypothesis, parameters_of
from gimbal_hil.discrepancy.record import TORQUE
from gimbal_hil.discrepancy.smoothing import Floats, scored
from gimbal_hil.discrepancy.twin import Structure, Twin
from sim_backend.effects import CATALOGUE, Effect, Hook

#: size of the change of the command over its own rms
_DITHER = 1e-3
#: window in which the share that comes through is measured, s; a command that is cut off there could have been
#: anything, and what is left counts twenty times
_WINDOW_S, _CUT_OFF = 0.25, 0.05


def command_residual(twin: Twin, hypothesis: Hypothesis, floor: Floats) -> Floats:
    """Residual of all records in units of the logged command, over the floors, (rows, channels)."""
    structure, P = parameters_of(twin, hypothesis)
    shaped = shapes_command(twin, hypothesis)
    rows = []
    for which in range(len(twin.records)):
        left = twin.leftover(structure, P, which)
        part = twin.scored_rows(left, which)
        rows.append(part / transmitted(twin, structure, P, which, left) if shaped else part)
    return np.asarray(np.concatenate(rows) / floor)


def torque_residual(twin: Twin, hypothesis: Hypothesis, floor: Floats) -> Floats:
    """Residual of all records as torque at the joint (and rate errors), over the floors, (rows, channels)."""
    return np.asarray(twin.residual(*parameters_of(twin, hypothesis)) / floor)


def shapes_command(twin: Twin, hypothesis: Hypothesis) -> bool:
    """Whether anything in the model or the hypothesis stands between the command and the joint."""
    own = any(_carries_command(entry.effect) for entry in twin.model.effects)
    return own or any(_carries_command(CATALOGUE[name]) for name, _ in hypothesis.labels)


def _carries_command(effect: Effect) -> bool:
    if effect.hook is not None:
        return effect.hook in (Hook.COMMAND, Hook.STRUCTURE)
    return any((parameter.path or "").startswith("actuator.") for parameter in effect.parameters)


def transmitted(twin: Twin, structure: Structure, P: Floats, which: int, left: Floats) -> Floats:
    """Share of a small change of the command that reaches the residual `left` of one record, around every scored row
    and per channel.

    Answers (rows that count, channels), at most one; one where the channel is a rate.
    """
    from scipy.ndimage import uniform_filter1d

    record = twin.records[which]
    rng = np.random.default_rng(17)
    size = _DITHER * np.sqrt(np.mean(record.torque**2, axis=0))
    dither = size * rng.standard_normal(record.torque.shape)
    moved = replace(record, torque=record.torque + dither)
    change = twin.leftover(structure, P, which, twin.records[:which] + (moved,) + twin.records[which + 1 :]) - left
    if not np.isfinite(change).all():
        return np.ones((int(record.keep.sum()), len(twin.channels)))
    sent, came = (scored(part, record.bands)[record.keep] for part in (dither, change[:, :2]))
    length = max(5, round(_WINDOW_S / (record.bands.stride * record.bands.period_s)))
    shares = np.ones((len(sent), len(twin.channels)))
    for j, channel in enumerate(twin.channels):
        if channel.signal == TORQUE:
            power = [uniform_filter1d(part[:, channel.column] ** 2, length, mode="nearest") for part in (came, sent)]
            shares[:, j] = np.clip(np.sqrt(np.maximum(power[0], 0.0) / np.maximum(power[1], 1e-300)), _CUT_OFF, 1.0)
    return shares
