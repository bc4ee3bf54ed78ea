"""The workflow, from a request to a result: the only way in, for the command, `improve`, the demonstration and the
benches alike.

Read top to bottom: logs become an inquiry; the model as stated and with its known numbers inside their uncertainty is
what has to be explained; causes are added while they pay; those that do not stand are left out; what remains is told.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.discrepancy.inquiry import (
    LEAST_S,
    Inquiry,
    Noise,
    State,
    as_stated,
    effect_names,
    prepared,
    recalibrated,
    rms,
    shared,
    stands_out,
    without_candidate,
)
from gimbal_hil.knowledge.discrepancy.judgement import (
    Kind,
    Request,
    Result,
    beyond_noise,
    decide,
    hidden_errors,
    smallest_sizes,
    torque_is_measured,
    with_identification,
    with_measured_torque,
)
from gimbal_hil.knowledge.discrepancy.laws import described
from gimbal_hil.knowledge.discrepancy.noise import moves
from gimbal_hil.knowledge.discrepancy.search import Path, explain, explain_again
from gimbal_hil.knowledge.executor import WorkExecutor, open_executor
from sim_backend.model import with_weight_left_open

#: floors that fell below this share of what they were under an explanation are worth another look
_FALLEN = 0.8
#: a gap of so many times the limit in the hold-out, and none in the logs that are fitted, is fitted where it is
_ONLY_THERE = 2.0


def diagnose(
    request: Request, *, workers: int = 1, dask: str | None = None, progress: Callable[[str], None] = lambda text: None
) -> Result:
    """Search for what the model lacks. Half of the hold-out selects, half only judges. The same bits whatever does the
    work.
    """
    with open_executor(workers, dask) as executor:
        return _diagnose(request, executor, progress)


def _diagnose(request: Request, executor: WorkExecutor, progress: Callable[[str], None]) -> Result:
    request = replace(request, model=with_weight_left_open(request.model))
    measured, holdout, suspected_only = with_hold_out(request.measured, request.holdout)
    begun = _begun(request, measured, holdout, executor, progress)
    only_there = False
    if not suspected_only and _only_in_hold_out(begun.inquiry, begun.null):
        part, rest, alone = with_hold_out(holdout, ())
        # what is too short for the band, or stands still, judges nothing: then the whole hold-out does
        with suppress(BadInputError):
            if min(len(table) * table.period_s for table in (*part, *rest)) >= LEAST_S:
                begun = _begun(request, (*measured, *part), rest, executor, progress)
                only_there, suspected_only = True, alone
                progress("the gap is in the hold-out alone: a part of it is fitted too, and the rest judges")
    inquiry, noise, stated, null = begun
    if stands_out(inquiry, null):
        path = explain(inquiry, null)
    else:
        # one cause, however small its gap, shows whether it passed for noise
        path = explain(replace(inquiry, policy=replace(request.policy, least_gap=0.0)), null, most=1)
    found = path.state.hypothesis
    if found.causes:
        lower = noise.under(inquiry.twin, found).undercut(inquiry.twin, found, path.state.left() * inquiry.floor)
        if np.min(lower.effective(inquiry.twin) / inquiry.floor) < _FALLEN:
            # what seemed explained under the old floors may hide another cause under the new ones
            inquiry, noise, stated, null, path = _under(inquiry, lower, path)
    progress("judging what was found")
    by_command = not torque_is_measured(inquiry.logs, request.model.axes)
    decision = decide(inquiry, stated, null, path, suspected_only, by_command)
    decision = with_identification(inquiry, with_measured_torque(inquiry, decision))
    progress("from which size on errors would have shown")
    smallest = smallest_sizes(inquiry, null)
    hidden = hidden_errors(inquiry, null, smallest, effect_names(request.only, request.without))
    result = Result(request, inquiry, noise, stated, null, decision, path, suspected_only, only_there, smallest, hidden)
    if decision.kind is Kind.NO_DISCREPANCY and result.hidden:
        # nothing stands out, but an error of the size that matters would not have either
        result = replace(result, decision=replace(decision, kind=Kind.CANNOT_JUDGE))
    searched_all = not (request.only or request.without)
    if result.decision.kind is Kind.UNEXPLAINED and searched_all and not suspected_only:
        laws = described(inquiry, null, beyond_noise(inquiry, null), path.state)
        if laws is not None:
            result = replace(result, decision=replace(decision, kind=Kind.DESCRIBED), described=laws)
    return result


class _Begun(NamedTuple):
    """What is known before anything is searched."""

    inquiry: Inquiry
    noise: Noise
    stated: State
    null: State


def _begun(
    request: Request,
    measured: tuple[SignalsTable, ...],
    holdout: tuple[SignalsTable, ...],
    executor: WorkExecutor,
    progress: Callable[[str], None],
) -> _Begun:
    """Logs as an inquiry; what the model leaves of them as stated, and once its known numbers moved. BadInputError for
    a hold-out that judges nothing.
    """
    if not any(moves(table, axis, request.model) for table in holdout for axis in request.model.axes):
        where = holdout[0].source or "the hold-out"
        raise BadInputError(where, "stands still where it judges", "a log of another trajectory (--holdout) that moves")
    names = effect_names(request.only, request.without)
    inquiry, noise = prepared(
        request.model, measured, holdout, request.band_hz, names, request.policy, executor, progress
    )
    noise = without_candidate(inquiry, noise, as_stated(inquiry))
    floor = noise.effective(inquiry.twin)
    inquiry = replace(inquiry, floor=floor, inexact=noise.processing / floor)
    stated = as_stated(inquiry)
    inquiry, null = recalibrated(inquiry, stated)
    return _Begun(shared(inquiry), noise, stated, null)


def _only_in_hold_out(inquiry: Inquiry, null: State) -> bool:
    """Whether the fitted logs leave no gap, and the hold-out leaves a plain one."""
    limit = inquiry.policy.least_gap * np.hypot(1.0, inquiry.inexact)
    plain = rms(null.held_out()) > _ONLY_THERE * limit
    return bool(np.any(plain) and np.all(rms(null.fitted) <= limit))


def _under(inquiry: Inquiry, noise: Noise, path: Path) -> tuple[Inquiry, Noise, State, State, Path]:
    """The same search further, with floors that an explanation showed to lie lower."""
    floor = noise.effective(inquiry.twin)
    heard = tuple(response.over(inquiry.floor / floor) for response in path.heard)
    inquiry = replace(inquiry, floor=floor, inexact=noise.processing / floor, known=None)
    stated = as_stated(inquiry)
    inquiry, null = recalibrated(inquiry, stated)
    inquiry = shared(inquiry)
    anew = explain_again(inquiry, null, path.state.hypothesis, heard)
    both = replace(anew, rounds=(*path.rounds, *anew.rounds), over_others=len(path.rounds))
    return inquiry, noise, stated, null, both


def with_hold_out(
    measured: tuple[SignalsTable, ...], holdout: tuple[SignalsTable, ...]
) -> tuple[tuple[SignalsTable, ...], tuple[SignalsTable, ...], bool]:
    """Logs to fit and logs to judge on; without a hold-out the last, or (suspected only) the last third of the only
    one.
    """
    if holdout:
        return measured, holdout, False
    if len(measured) > 1:
        return measured[:-1], measured[-1:], False
    n = len(measured[0])
    first, last = measured[0].rows(0, 2 * n // 3), measured[0].rows(2 * n // 3, n)
    return (first,), (last,), True


__all__ = ["diagnose", "with_hold_out"]
