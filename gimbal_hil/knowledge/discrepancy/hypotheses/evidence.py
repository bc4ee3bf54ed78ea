"""What is evidence: the commanded torque that the measured motion asks for, through the hypothesis' own actuator.

A residual "torque given minus torque needed" can be shrunk by a hypothesis that deletes the torque: a low limit, a gain
near zero, a long lag. What such a hypothesis cannot do is say which *command* was sent. So the residual is divided by
the share of a small change of the command that comes through the hypothesis' actuator and structure, which is that of
the log-likelihood's change of variables, p(u | motion) = p(residual) |d residual / d u|: a limit that cuts everything,
or a gain of one per cent, gains nothing. The share is measured: the twin is evaluated with a small random change of the
command, whatever the hypothesis is. Of which effects that has to be done is measured the same way, once for a search.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gimbal_hil.knowledge.discrepancy.hypotheses.families import Family, profiled
from gimbal_hil.knowledge.discrepancy.hypotheses.hypothesis import Cause, Hypothesis, parameters_of
from gimbal_hil.knowledge.discrepancy.hypotheses.origin import placed
from gimbal_hil.knowledge.discrepancy.twin import TORQUE, Evaluation, Floats, Structure, Twin, turned_inertia
from sim_backend.effects import NEUTRAL_ORDER, ripple_start

#: window in which the share that comes through is measured, s; a command that is cut off there could have been
#: anything, and what is left counts twenty times
_WINDOW_S, _CUT_OFF = 0.25, 0.05


#: share of a small change of the command that comes through, (rows that count, channels), per record
Shares = tuple[Floats, ...]


def command_residual(twin: Twin, hypothesis: Hypothesis, floor: Floats) -> Floats:
    """Residual of all records in units of the logged command, over the floors, (rows, channels)."""
    return with_shares(twin, hypothesis, floor)[0]


def with_shares(
    twin: Twin, hypothesis: Hypothesis, floor: Floats, shares: Shares | None = None
) -> tuple[Floats, Shares | None]:
    """The same, and the shares of the command that it was divided by; None where nothing shapes the command.

    `shares` are those of a hypothesis that differs in nothing that shapes the command.
    """
    structure, P = parameters_of(twin, hypothesis)
    records = placed(twin.records, hypothesis)
    rows, found = [], []
    shaped = shares is not None or shapes_command(twin, hypothesis)
    for which in range(len(records)):
        left = twin.evaluated(structure, P, records[which])
        part = twin.scored_rows(left, which)
        if shaped:
            found.append(transmitted(twin, structure, P, which, left) if shares is None else shares[which])
            part = part / found[-1]
        rows.append(part)
    return np.asarray(np.concatenate(rows) / floor), tuple(found) if shaped else None


def noise_of_command(twin: Twin, hypothesis: Hypothesis, floor: Floats) -> Floats:
    """Squares per channel, in units of the command, of what is one floor of noise at the joint: more than one where a
    gain, a lag or a limit lets little of the command through.
    """
    return np.asarray(np.mean(np.concatenate(shares_of(twin, hypothesis, floor)) ** -2, axis=0))


def noise_of_motion(twin: Twin, hypothesis: Hypothesis, share: Floats | float) -> Floats:
    """Noise per channel, in floors, where a hypothesis has more inertia than the model: the encoder's error, `share` of
    a floor's squares, counts by it. At least one: less inertia lowers the floors themselves.
    """
    _, P = parameters_of(twin, hypothesis)
    stated = twin.structure(()).P
    more = np.ones(len(twin.channels))
    for j, channel in enumerate(twin.channels):
        if channel.signal == TORQUE:
            mine, before = (turned_inertia(twin.model, of, channel.axis) for of in (P, stated))
            more[j] = max(1.0, mine / max(before, 1e-300))
    return np.asarray(np.sqrt(1.0 + share * (more**2 - 1.0)))


def shares_of(twin: Twin, hypothesis: Hypothesis, floor: Floats) -> Shares:
    """The shares of a hypothesis; where nothing stands between the command and the joint, all of it comes through."""
    if shapes_command(twin, hypothesis):
        return with_shares(twin, hypothesis, floor)[1] or ()
    return tuple(np.ones((int(record.keep.sum()), len(twin.channels))) for record in twin.records)


def torque_residual(twin: Twin, hypothesis: Hypothesis, floor: Floats) -> Floats:
    """Residual of all records as torque at the joint (and rate errors), over the floors, (rows, channels)."""
    structure, P = parameters_of(twin, hypothesis)
    records = placed(twin.records, hypothesis)
    rows = [twin.scored_rows(twin.evaluated(structure, P, record), which) for which, record in enumerate(records)]
    return np.asarray(np.concatenate(rows) / floor)


def families(twin: Twin, axis: str) -> list[Family]:
    """Every effect of the catalogue that an axis can have in these logs, and of each whether it cuts the command."""
    return [replace(family, cuts_command=_cuts(twin, family)) for family in profiled(twin.model, axis, twin.records)]


def shapes_command(twin: Twin, hypothesis: Hypothesis) -> bool:
    """Whether anything in the model or the hypothesis keeps a part of a change of the command from the joint."""
    return any(cause.family.cuts_command for cause in hypothesis.causes) or twin.cuts_command


def _cuts(twin: Twin, family: Family) -> bool:
    """Whether at any of its probes a family lets less of a change of the command through than the model does."""
    return any(
        not twin.passes(*parameters_of(twin, Hypothesis((Cause(family, probe),))))
        for start in family.starts or (ripple_start(NEUTRAL_ORDER),)
        for probe in start.probes
    )


def transmitted(twin: Twin, structure: Structure, P: Floats, which: int, left: Evaluation) -> Floats:
    """Share of a small change of the command that reaches the residual `left` of one record, around every scored row
    and per channel.

    Answers (rows that count, channels), at most one; one where the channel is a rate.
    """
    from scipy.ndimage import uniform_filter1d

    record, moved = twin.records[which], twin.dithered(which)
    if left.record is not record:
        # positions are counted from another zero there
        moved = replace(moved, motion=left.record.motion)
    changed = twin.evaluated(structure, P, moved)
    shares = np.ones((int(record.keep.sum()), len(twin.channels)))
    length = max(5, round(_WINDOW_S / (record.bands.stride * record.bands.period_s)))
    for j, channel in enumerate(twin.channels):
        if channel.signal == TORQUE:
            sent = twin.dither(which)[record.keep, channel.column]
            came = (changed.thinned(channel.column) - left.thinned(channel.column))[record.keep]
            if not np.isfinite(came).all():
                return np.ones_like(shares)
            power = [uniform_filter1d(part**2, length, mode="nearest") for part in (came, sent)]
            driven = power[1] > 0.0
            ratio = np.sqrt(np.maximum(power[0], 0.0) / np.where(driven, power[1], 1.0))
            # of an axis that is not driven nothing can be cut off
            shares[:, j] = np.where(driven, np.clip(ratio, _CUT_OFF, 1.0), 1.0)
    return shares
