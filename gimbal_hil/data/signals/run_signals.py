"""A run folder as a signals table, put in order by the device's own tick and by the echo of the set-points.

A feedback set is the frames up to and with its `drive_status`. Set k was sampled at device tick k; its `last_sequence`
names the set-point that acted up to then, so the torque of row k is that of the set-point which set k+1 echoes. This
holds however long frames were under way and whichever ticks the host skipped.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.enumerations import DriveState
from firmware_protocol.errors import BadInputError
from gimbal_hil.data.runs import AXES, EventKind, MessageColumns, RecordedRun, columns_of, require_frames
from gimbal_hil.data.signals.missed_rows import asked_late_rows, bridged
from gimbal_hil.data.signals.table import BASE_ANGLES

#: a device tick that jumps by more than this against the host's is a restarted device, not a stall
RESTART_TICKS = 64
_DEVICE_TICKS, _SEQUENCES, _COUNTERS = 4096, 1024, 16
#: states in which the drive brakes by itself: its torque is no longer the commanded one
_REACTIONS = (DriveState.QUICK_STOP_ACTIVE, DriveState.FAULT_REACTION_ACTIVE)

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


@dataclass(frozen=True)
class _FeedbackSets:
    """The sets of one session of the device in time order: device tick (unwrapped), place of `drive_status` in the log,
    its columns.
    """

    tick: Integers
    rows: Integers
    status: MessageColumns


def run_columns(run: RecordedRun) -> tuple[Floats, dict[str, Floats], Integers | None, list[str]]:
    """Time from the first set, columns, laps, and notes; raises BadInputError without feedback.

    Where frames are missing there is NaN; of a run in real time a few short gaps are bridged (`missed_rows`).
    """
    notes = list(run.notes)
    sets = _feedback_sets(run, notes)
    first, last = int(sets.tick[0]), int(sets.tick[-1])
    count = last - first  # the last set only closes the row before it
    place = sets.tick - first
    columns: dict[str, Floats] = {}
    host_tick, acting = _acting_set_points(run, sets)
    for own, axis in zip(AXES, run.record.header.axes, strict=True):
        torque = np.full(count + 1, np.nan)
        torque[place[1:] - 1] = acting[own][1:]
        feedback = columns_of(run.frames, f"feedback_{own}", run.protocol)
        sampled = _rows_in_sets(feedback, sets)
        columns[f"{axis}.torque"] = torque
        for signal in ("position", "rate"):
            values = np.full(count + 1, np.nan)
            values[place] = (
                np.where(sampled >= 0, feedback.physical(signal)[sampled], np.nan) if len(feedback.place) else np.nan
            )
            columns[f"{axis}.{signal}"] = values
    row_tick = np.full(count + 1, -1, np.int64)
    row_tick[place[1:] - 1] = host_tick[1:]
    if not run.record.header.lockstep:
        row_tick = _counted_on(row_tick)
    if run.record.header.configuration.get("link", {}).get("kind") == "adapter":
        # these drives tell the motion of when the host asked or looked, the antenna's own device that of its own clock
        asked_late = asked_late_rows(run.ticks, row_tick, run.record.header.period_ns)
        for axis, signal in itertools.product(run.record.header.axes, ("position", "rate")):
            columns[f"{axis}.{signal}"][asked_late] = np.nan
    columns |= _references(run, row_tick, columns, notes) | _slow_columns(run, sets, first, count)
    laps = _laps(run, row_tick)
    period_s = run.record.header.period_ns * 1e-9
    time_s = period_s * np.arange(count, dtype=np.float64)
    columns = {name: values[:count] for name, values in columns.items()}
    laps = None if laps is None else laps[:count]
    if run.record.header.lockstep:
        return time_s, columns, laps, notes
    whole = bridged(columns, _sent_torques(run, row_tick[:count]), period_s)
    part = slice(whole.start, whole.stop)
    return time_s[part], dict(whole.columns), None if laps is None else laps[part], [*notes, *whole.notes]


def _counted_on(row_tick: Integers) -> Integers:
    """Host ticks of rows; where no answer names one, counted on from the row before, and -1 before the first."""
    known = np.flatnonzero(row_tick >= 0)
    if not len(known):
        return row_tick
    rows = np.arange(len(row_tick))
    before = known[np.maximum(np.searchsorted(known, rows, side="right") - 1, 0)]
    return np.where(rows >= before, row_tick[before] + rows - before, -1)


def _sent_torques(run: RecordedRun, row_tick: Integers) -> dict[str, Floats]:
    """By column the torque (n,) of the newest set-point that the host had sent by the tick of each row, N m."""
    sent = columns_of(run.frames, "set_point", run.protocol)
    at = np.searchsorted(sent.tick, row_tick, side="right") - 1
    found = {}
    for own, axis in zip(AXES, run.record.header.axes, strict=True):
        torque = np.where(sent.raw[f"enable_{own}"] == 1, sent.physical(f"torque_{own}"), 0.0)
        found[f"{axis}.torque"] = np.where(at >= 0, torque[at], np.nan) if len(torque) else np.full(len(at), np.nan)
    return found


def _feedback_sets(run: RecordedRun, notes: list[str]) -> _FeedbackSets:
    if len(run.ticks):
        require_frames(run)
    status = columns_of(run.frames, "drive_status", run.protocol)
    if len(status.place) < 2:
        raise BadInputError(
            str(run.folder),
            "holds no feedback",
            "a run in which the antenna answered; this one ended before: record it again",
        )
    tick, end = _device_ticks(status)
    if end < len(tick):
        notes.append(f"the device restarted at tick {status.tick[end]}: the table ends there")
    newest = np.maximum.accumulate(tick[:end])
    rows = np.flatnonzero(np.concatenate(([True], tick[1:end] > newest[:-1])))
    reaction = np.isin(status.raw["state"][rows], _REACTIONS)
    enabled = status.raw["state"][rows] == DriveState.OPERATION_ENABLED
    taken = np.flatnonzero(reaction & np.logical_or.accumulate(enabled))
    if len(taken):
        notes.append(f"the drive braked by itself from tick {status.tick[rows[taken[0]]]} on: the table ends there")
        rows = rows[: taken[0]]
    if len(rows) < 2:
        raise BadInputError(
            str(run.folder), "has fewer than two feedback sets in sequence", "a run in which the antenna answered"
        )
    return _FeedbackSets(tick[rows], rows, status)


def _device_ticks(status: MessageColumns) -> tuple[Integers, int]:
    """The device's tick of every set, unwrapped, and the index of the first set after a restart (their number without
    one).

    A host that stalled finds many sets at once; the newest one at each host tick is in step with the host unless the
    device restarted.
    """
    own = status.raw["tick"]
    newest = np.flatnonzero(np.append(np.diff(status.tick) > 0, True))
    drift = _wrapped(np.diff(own[newest] - status.tick[newest]))
    reached = status.tick[newest] + np.concatenate(([0], np.cumsum(drift)))
    group = np.searchsorted(newest, np.arange(len(own)))
    restarts = np.flatnonzero(np.abs(drift) > RESTART_TICKS)
    end = int(newest[restarts[0]]) + 1 if len(restarts) else len(own)
    return reached[group] + _wrapped(own - own[newest][group]), end


def _wrapped(ticks: Integers) -> Integers:
    """Differences of device ticks, nearest to zero."""
    wrapped: Integers = np.mod(ticks + _DEVICE_TICKS // 2, _DEVICE_TICKS) - _DEVICE_TICKS // 2
    return wrapped


def _acting_set_points(run: RecordedRun, sets: _FeedbackSets) -> tuple[Integers, dict[str, Floats]]:
    """For each set the host tick (-1: unknown) whose set-point its echo names, and the torque by axis that acted, N
    m.
    """
    sent = columns_of(run.frames, "set_point", run.protocol)
    state = sets.status.raw["state"][sets.rows]
    unknown = np.full(len(sets.rows), -1)
    idle = np.where(state == DriveState.OPERATION_ENABLED, np.nan, 0.0)
    if not len(sent.place):
        return unknown, dict.fromkeys(AXES, idle)
    newest = np.searchsorted(sent.place, sets.status.place[sets.rows]) - 1
    back = np.mod(sent.raw["sequence"][newest] - sets.status.raw["last_sequence"][sets.rows], _SEQUENCES)
    wanted = sent.tick[newest] - back
    found = np.clip(np.searchsorted(sent.tick, wanted), 0, len(sent.tick) - 1)
    known = (
        (newest >= 0)
        & (sent.tick[found] == wanted)
        & (sent.raw["sequence"][found] == sets.status.raw["last_sequence"][sets.rows])
    )
    torques = {}
    for axis in AXES:
        commanded = np.where(sent.raw[f"enable_{axis}"] == 1, sent.physical(f"torque_{axis}"), 0.0)
        torques[axis] = np.where(np.isnan(idle) & known, commanded[found], idle)
    return np.where(known, wanted, unknown), torques


def _rows_in_sets(feedback: MessageColumns, sets: _FeedbackSets) -> Integers:
    """For each set the index of its feedback frame, -1 where that frame is missing.

    The messages of a set are sent together, so their alive counters differ by what they differ in nearly all sets.
    """
    status_place = sets.status.place[sets.rows]
    found = np.searchsorted(feedback.place, status_place) - 1
    before = np.concatenate(([-1], status_place[:-1]))
    inside = (
        (found >= 0) & (feedback.place[np.maximum(found, 0)] > before)
        if len(feedback.place)
        else np.zeros(len(found), bool)
    )
    if inside.any():
        apart = np.mod(feedback.counter[found] - sets.status.counter[sets.rows], _COUNTERS)
        inside &= apart == np.argmax(np.bincount(apart[inside], minlength=_COUNTERS))
    return np.where(inside, found, -1)


def _references(
    run: RecordedRun, row_tick: Integers, measured: dict[str, Floats], notes: list[str]
) -> dict[str, Floats]:
    """Joint references of the tick whose torque acts in each row, for loops that were closed at some time.

    Where a loop was open there is no reference: the measured value stands in its place, so the loop's error reads zero.
    """
    columns: dict[str, Floats] = {}
    open_rows: dict[int, list[str]] = {}
    if not len(run.ticks):
        return columns
    order = np.clip(np.searchsorted(run.ticks["tick"], row_tick), 0, len(run.ticks) - 1)
    known = run.ticks["tick"][order] == row_tick
    for own, axis in zip(AXES, run.record.header.axes, strict=True):
        for signal in ("position", "rate"):
            values = np.where(known, run.ticks[f"{signal}_ref_{own}"][order], np.nan)
            closed = np.isfinite(values[:-1])
            if closed.any():
                columns[f"{axis}.{signal}_ref"] = np.where(np.isfinite(values), values, measured[f"{axis}.{signal}"])
            if closed.any() and not closed.all():
                open_rows.setdefault(int(np.count_nonzero(~closed)), []).append(f"{axis}.{signal}_ref")
    for count, names in open_rows.items():
        rows = "one row" if count == 1 else f"{count} rows"
        notes.append(f"no reference was followed in {rows}; taken as measured there: {', '.join(names)}")
    return columns


def _slow_columns(run: RecordedRun, sets: _FeedbackSets, first: int, count: int) -> dict[str, Floats]:
    """Base motion and winding temperatures, interpolated linearly from the rate at which they come to the rows."""
    wanted = [("base_attitude", angle, f"base.{angle}") for angle in ("roll", "pitch")]
    yaw = "base_attitude" if run.protocol.version == 1 else "base_heading"
    wanted.append((yaw, "yaw", "base.yaw"))
    wanted += [("base_rate", rate, f"base.{rate}") for rate in ("p", "q", "r")]
    names = zip(AXES, run.record.header.axes, strict=True)
    wanted += [(f"motor_status_{own}", "temperature", f"{axis}.temperature") for own, axis in names]
    columns: dict[str, Floats] = {}
    status_place = sets.status.place[sets.rows]
    for message, signal, name in wanted:
        received = columns_of(run.frames, message, run.protocol)
        in_set = np.searchsorted(status_place, received.place)
        kept = in_set < len(status_place)
        if kept.any():
            values = received.physical(signal)[kept]
            at = sets.tick[in_set[kept]] - first
            if (age := _age_ticks(received, sets, in_set)) is not None:
                at = at - age[kept]
            columns[name] = np.interp(np.arange(count + 1), at, np.unwrap(values) if name in BASE_ANGLES else values)
    return columns


def _age_ticks(received: MessageColumns, sets: _FeedbackSets, in_set: Integers) -> Integers | None:
    """How many ticks before its set a base attitude was true, where it says so."""
    own = sets.status.raw["tick"][sets.rows[np.minimum(in_set, len(sets.rows) - 1)]]
    for stamp, span in (("valid_tick", _DEVICE_TICKS), ("set", 16)):
        if stamp in received.raw:
            return np.mod(own - received.raw[stamp], span)
    return None


def _laps(run: RecordedRun, row_tick: Integers) -> Integers | None:
    """Lap numbers that segments of a plan carry as `repeat`; -1 in rows that belong to no lap; None without any."""
    marks = [(event.tick, event.data.get("repeat")) for event in run.events if event.kind is EventKind.SEGMENT]
    if not any(isinstance(lap, int) for _, lap in marks):
        return None
    starts = np.array([tick for tick, _ in marks])
    laps = np.array([lap if isinstance(lap, int) else -1 for _, lap in marks])
    order = np.searchsorted(starts, row_tick, side="right") - 1
    return np.where(order >= 0, laps[np.maximum(order, 0)], -1)
