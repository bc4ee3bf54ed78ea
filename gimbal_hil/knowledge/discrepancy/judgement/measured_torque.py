"""What the actuator really gave, where a log says so: it tells causes in the actuator from causes in the joint.

`torque_measured` takes no part in the search: the contract does not say at which instant of a row the current was read,
and half a row would pass for a delay. It is asked at the end, where a cause could as well be another one, since each of
them predicts what the actuator gave. Prediction and measurement are compared below a few hertz, with a shift in time
fitted to each; who is clearly worse is ruled out.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.discrepancy.hypotheses import Hypothesis, parameters_of
from gimbal_hil.knowledge.discrepancy.inquiry import BLOCK_S, Inquiry, State
from gimbal_hil.knowledge.discrepancy.judgement.deciding import Decision, kind_of, rejudged
from gimbal_hil.knowledge.discrepancy.twin import Bands, Floats, Twin, scored, scoring_reach

#: end of the band in which torques are compared, Hz
_BAND_HZ = 3.0
#: standard errors of the blockwise difference beyond which a prediction is clearly worse
_CLEARLY = 4.0
#: and it must leave this many times the squares of the better one
_WORSE = 1.5


def with_measured_torque(inquiry: Inquiry, decision: Decision) -> Decision:
    """The decision with every alternative left out that the measured torque of the searched logs rules out.

    Where the only cause that was found is ruled out and another would do as well, that one takes its place.
    """
    measured = inquiry.logs
    if not torque_is_measured(measured, inquiry.twin.model.axes):
        return decision
    told = []
    for one in decision.told:
        left = {
            id(state): _squares(inquiry, state, measured) for state in (decision.state, *(r.state for r in one.close))
        }
        least = min(left.values(), key=lambda blocks: float(np.mean(blocks)))
        out = {key for key, blocks in left.items() if _clearly_worse(blocks, least)}
        kept = tuple(rival for rival in one.close if id(rival.state) not in out)
        lead = next((rival for rival in kept if rival.is_cause), None)
        if id(decision.state) in out and len(decision.told) == 1 and lead is not None:
            rest = tuple(rival for rival in kept if rival is not lead)
            # the class was judged, and the measured torque says which of it; but the cause itself was not judged, so it
            # is named only where what it replaces was shown
            standing = replace(one.standing, label=lead.label, at_bound=lead.at_bound)
            swapped = rejudged(inquiry.policy, replace(one, standing=standing), rest)
            return replace(decision, state=lead.state, told=(swapped,), kind=kind_of((swapped,)))
        told.append(one if len(kept) == len(one.close) else rejudged(inquiry.policy, one, kept))
    return replace(decision, told=tuple(told), kind=kind_of(tuple(told)) if told else decision.kind)


def torque_is_measured(measured: tuple[SignalsTable, ...], axes: tuple[str, ...]) -> bool:
    """Whether any log says what an actuator really gave."""
    return any(_given(table, axis) is not None for table in measured for axis in axes)


def _given(table: SignalsTable, axis: str) -> Floats | None:
    """The measured torque of an axis, (n,); None where it was not measured: only zeros were written, or the command
    once more.
    """
    torque = table.signal(axis, "torque_measured")
    if torque is None or not np.any(torque != 0.0) or np.allclose(torque, table.commanded(axis), rtol=1e-6, atol=0.0):
        return None
    # the records hold what is left once the known part is taken off
    return np.asarray(torque - (table.commanded(axis) - table.torque(axis)))


def _squares(inquiry: Inquiry, state: State, tables: tuple[SignalsTable, ...]) -> Floats:
    """Mean squares, block by block, of what a state's prediction leaves of the measured torques."""
    twin, blocks = inquiry.twin, []
    for which, table in enumerate(tables):
        for i, axis in enumerate(twin.model.axes):
            torque = _given(table, axis)
            if torque is not None:
                blocks.append(_left_of(twin, state.hypothesis, which, i, torque))
    return np.concatenate(blocks)


def _left_of(twin: Twin, hypothesis: Hypothesis, which: int, i: int, measured: Floats) -> Floats:
    record = twin.records[which]
    given = twin.applied(*parameters_of(twin, hypothesis), which)[:, i]
    bands = Bands(min(_BAND_HZ, record.bands.scored_hz), record.bands.period_s)
    rows = np.column_stack([measured[: len(given)], given, np.gradient(given) / bands.period_s])
    edge = scoring_reach(bands) // bands.stride + 1
    seen, predicted, slope = scored(rows, bands)[edge:-edge].T
    left = seen - predicted
    power = float(slope @ slope)
    left = left - slope * (float(slope @ left) / power if power > 0.0 else 0.0)
    length = max(2, round(BLOCK_S / (bands.stride * bands.period_s)))
    return np.asarray((left[: len(left) // length * length] ** 2).reshape(-1, length).mean(axis=1))


def _clearly_worse(one: Floats, other: Floats) -> bool:
    difference = one - other
    if len(difference) < 3 or float(np.mean(one)) < _WORSE * float(np.mean(other)):
        return False
    error = float(difference.std(ddof=1)) / math.sqrt(len(difference))
    return float(difference.mean()) > _CLEARLY * error
