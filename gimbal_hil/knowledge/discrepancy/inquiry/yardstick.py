"""A noise floor that does not depend on the model under test: what a regression with free numbers leaves of the
hold-out.

A floor that is computed with a wrong model includes the model's own errors: a wrong inertia times the encoder's error,
or an unmodelled resonance above the band, is taken for noise. Whatever a plain regression explains on data that it has
not seen cannot be noise, so its residual caps the floor. The regression uses the command as it is, so that no
hypothesis can shrink what has to be explained; its numbers have no prior.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gimbal_hil.knowledge.discrepancy.hypotheses import STEP, Hypothesis, KnownNumber, command_residual, known_numbers
from gimbal_hil.knowledge.discrepancy.inquiry.inquiry import Inquiry, State
from gimbal_hil.knowledge.discrepancy.inquiry.prepare import Noise
from gimbal_hil.knowledge.discrepancy.twin import TORQUE, Channel, Floats, Record, Twin, scored

#: rows that a number of the regression must have; fewer say nothing of what it would leave elsewhere
_ROWS_PER_NUMBER = 20
#: singular values below this share count as none
_SMALLEST = 1e-8
#: rate below which a sign is none, as a share of the largest
_SLOW = 1e-3
#: a gain would shrink the command itself
_OF_THE_COMMAND = "actuator.gain_error"


def without_candidate(inquiry: Inquiry, noise: Noise, stated: State) -> Noise:
    """The noise, and what the pipeline is said to leave of a right model, no larger than a free regression leaves of
    the hold-out.
    """
    left = free_residual(inquiry, stated)
    # a right model leaves no more than that, and neither does the pipeline of it
    left = left * inquiry.floor
    return replace(noise.at_most(left), processing=np.minimum(noise.processing, left))


def free_residual(inquiry: Inquiry, stated: State) -> Floats:
    """Rms per channel, in floors, of what a regression fitted to the searched logs leaves of the hold-out; infinite
    where these rows cannot carry one, and for rates, which have no command.
    """
    twins = inquiry.twin, inquiry.holdout
    residuals = [command_residual(twin, Hypothesis(), inquiry.floor) for twin in twins]
    numbers = [known for known in known_numbers(inquiry.twin.model) if known.path != _OF_THE_COMMAND]
    slopes = [_slopes(twin, numbers, rows, inquiry.floor) for twin, rows in zip(twins, residuals, strict=True)]
    found = np.full(len(inquiry.floor), np.inf)
    for j, channel in enumerate(inquiry.twin.channels):
        if channel.signal != TORQUE:
            continue
        columns = [
            np.column_stack([slope[:, :, j].T, _features(twin, channel, j, float(inquiry.floor[j]))])
            for twin, slope in zip(twins, slopes, strict=True)
        ]
        found[j] = _left_elsewhere(columns[0], residuals[0][:, j], columns[1], residuals[1][:, j])
    return found


def _left_elsewhere(columns: Floats, rows: Floats, there: Floats, rows_there: Floats) -> float:
    size = np.sqrt(np.mean(columns**2, axis=0))
    used = np.isfinite(size) & (size > 0.0) & np.isfinite(there).all(axis=0)
    if len(rows) < _ROWS_PER_NUMBER * max(1, int(used.sum())) or not np.isfinite(rows).all():
        return float("inf")
    numbers, *_ = np.linalg.lstsq(columns[:, used] / size[used], rows, rcond=_SMALLEST)
    return float(np.sqrt(np.mean((rows_there - (there[:, used] / size[used]) @ numbers) ** 2)))


def _slopes(twin: Twin, numbers: list[KnownNumber], rows: Floats, floor: Floats) -> Floats:
    """What each known number does to the residual, (numbers, rows, channels)."""
    found = np.zeros((len(numbers), *rows.shape))
    for k, known in enumerate(numbers):
        moved = command_residual(twin, Hypothesis(floating=(known,), y=(STEP,)), floor)
        found[k] = (moved - rows) / STEP
    return found


def _features(twin: Twin, channel: Channel, column: int, floor: float) -> Floats:
    """What torque on an axis is made of in any model, over the channel's floor, (rows, features)."""
    return (
        np.concatenate([_of_record(twin, which, record, channel, column) for which, record in enumerate(twin.records)])
        / floor
    )


def _of_record(twin: Twin, which: int, record: Record, channel: Channel, column: int) -> Floats:
    i = channel.column
    q, v, a = (record.motion[:, k + i] for k in (0, 2, 4))
    slow = _SLOW * float(np.max(np.abs(v))) or 1.0
    sign = np.clip(v / slow, -1.0, 1.0)
    plain = [np.ones(len(q)), q, np.sin(q), np.cos(q), sign, np.abs(sign), v, np.abs(v), v * np.abs(v), a]
    if len(record.axes) > 1:
        plain.append(record.motion[:, 4 + (1 - i)])
    rows = scored(np.column_stack(plain), record.bands)[record.keep]
    return rows if twin.scales is None else np.asarray(rows / twin.scales[which][:, column : column + 1])
