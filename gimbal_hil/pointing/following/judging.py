"""How well a direction was held, from the log of a run: the angle that the host saw, where the base's true motion is
known the true one, and whether what the host followed was the target at all.

Target and reference are computed apart: the target from the sky at the time of each tick, the reference by the host
from its table.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.json_object import Json
from gimbal_hil.data.runs import AXES, MessageColumns, RecordedRun, columns_of
from gimbal_hil.loop.host import EventCode, PointingState, word_of
from gimbal_hil.pointing.arena import between, boresight
from gimbal_hil.pointing.following.base import BaseTruth, in_base
from gimbal_hil.pointing.following.geodesy import Table
from gimbal_hil.pointing.following.targets import Target
from gimbal_hil.pointing.following.way import joints_seen
from sim_backend.boresight import Boresight

_DEVICE_TICKS = 4096
#: turns of the device's tick counter that are tried for where its time began
_MOST_LAPS = 400
#: the end of the way there, which is no error of holding, is over so long after the acquisition
_SETTLED_S = 5.0
#: share of the ticks that `reference_off_urad` speaks of: attitudes are told in steps and late
_MOST_OF_ALL = 0.95
#: microradians: a reference further off was not the target's; attitudes told a tenth of a second apart on a base that
#: turns by 5 deg/s leave 4 mrad
REFERENCE_TOLERANCE_URAD = 10_000.0
_POINTING = word_of(EventCode.POINTING)
_COASTING = word_of(PointingState.COASTING)


@dataclass(frozen=True)
class MuteChange:
    """What a POINTING event told."""

    tick: int
    state: str
    muted: bool
    error_rad: float


@dataclass(frozen=True)
class HeldTrace:
    """Tick by tick from the first to the last that a direction was followed: rad, NaN where no sample came."""

    tick: NDArray[np.int64]
    time_s: Table
    #: as host and encoders see it
    error: Table
    #: by the base's true motion; all NaN where it is not known
    true_error: Table
    #: joints (n, 2) as measured, and those that look there
    joints: Table
    towards: Table
    #: between the reference and the target, which is turned into the base by the attitude that the antenna told
    reference_off: Table
    muted: NDArray[np.bool_]


@dataclass(frozen=True)
class PointingFigures:
    """Errors in microradians, over the ticks in which the antenna was not muted; those that are settled from 5 s after
    the acquisition on. Times in seconds.
    """

    duration_s: float
    acquired_after_s: float
    rms_urad: float
    peak_urad: float
    true_rms_urad: float
    true_peak_urad: float
    settled_rms_urad: float
    settled_peak_urad: float
    settled_true_rms_urad: float
    settled_true_peak_urad: float
    muted_s: float
    muted_after_acquisition_s: float
    mutes_after_acquisition: int
    beyond_without_mute_s: float
    longest_beyond_without_mute_s: float
    coasting_s: float
    #: what the reference was off the target in all but a twentieth of the ticks
    reference_off_urad: float
    ticks: int
    ticks_without_sample: int
    ticks_skipped: int

    @property
    def followed_the_target(self) -> bool:
        """Whether what the host followed was the target."""
        return not self.reference_off_urad > REFERENCE_TOLERANCE_URAD

    def as_dict(self) -> dict[str, float | int | None]:
        """For JSON: what is not known is null."""
        return {
            key: None if isinstance(value, float) and not math.isfinite(value) else value
            for key, value in asdict(self).items()
        }


def mute_changes(events: Sequence[tuple[int, Json]]) -> list[MuteChange]:
    """Those of the events (tick, data) that are about pointing."""
    return [
        MuteChange(tick, str(data["state"]), bool(data["muted"]), float(data["error_rad"]))
        for tick, data in events
        if data.get("code") == _POINTING
    ]


def held_trace(
    run: RecordedRun,
    target: Target,
    first_row_tick: int,
    span: tuple[int, int],
    changes: Sequence[MuteChange],
    truth: BaseTruth | None = None,
    looks: Boresight = Boresight.AHEAD,
) -> HeldTrace:
    """The trace of ticks `span` (first, last) of a run that followed a target whose first row stands at a tick."""
    step_s = run.record.header.period_ns * 1e-9
    rows = run.ticks[(run.ticks["tick"] >= span[0]) & (run.ticks["tick"] <= span[1])]
    tick = rows["tick"].astype(np.int64)
    joints = np.column_stack([_sampled(run, f"feedback_{axis}", "position", tick) for axis in AXES])
    towards = np.column_stack([rows[f"position_ref_{axis}"] for axis in AXES])
    error = between(boresight(joints), boresight(towards))
    sky = boresight(joints_seen(target, np.maximum(0.0, (tick - first_row_tick) * step_s), looks))
    reference_off = between(boresight(towards), in_base(sky, _attitude_told(run, tick)))
    true_error = np.full(len(tick), np.nan)
    if truth is not None:
        wanted = in_base(sky, truth.at(_device_time(run, tick, step_s, truth)))
        true_error = between(boresight(joints), wanted)
    muted = np.ones(len(tick), dtype=np.bool_)
    for change in changes:
        muted[tick >= change.tick] = change.muted
    return HeldTrace(
        tick,
        step_s * np.asarray(tick - first_row_tick, dtype=np.float64),
        error,
        true_error,
        joints,
        towards,
        reference_off,
        muted,
    )


def pointing_figures(trace: HeldTrace, changes: Sequence[MuteChange], beyond_rad: float) -> PointingFigures:
    """Figures of a trace; errors are those of the ticks in which the antenna was not muted."""
    step_s = float(np.median(np.diff(trace.time_s))) if len(trace.tick) > 1 else 0.0
    held, known = ~trace.muted, np.isfinite(trace.error)
    acquired = int(np.argmax(held)) if held.any() else len(held)
    after = np.arange(len(held)) >= acquired
    beyond = held & known & (trace.error > beyond_rad)
    coasting = np.zeros(len(held), dtype=np.bool_)
    for change in changes:
        coasting[trace.tick >= change.tick] = change.state == _COASTING
    truly = held & np.isfinite(trace.true_error)
    first = int(trace.tick[0]) if len(trace.tick) else 0
    settled = np.arange(len(held)) * step_s >= acquired * step_s + _SETTLED_S
    mutes = sum(
        1
        for before, change in pairwise(changes)
        if change.muted and not before.muted and (len(trace.tick) and change.tick < trace.tick[-1])
    )
    return PointingFigures(
        duration_s=len(held) * step_s,
        acquired_after_s=acquired * step_s if held.any() else math.inf,
        rms_urad=_rms(trace.error[held & known]),
        peak_urad=_peak(trace.error[held & known]),
        true_rms_urad=_rms(trace.true_error[truly]),
        true_peak_urad=_peak(trace.true_error[truly]),
        settled_rms_urad=_rms(trace.error[held & known & settled]),
        settled_peak_urad=_peak(trace.error[held & known & settled]),
        settled_true_rms_urad=_rms(trace.true_error[truly & settled]),
        settled_true_peak_urad=_peak(trace.true_error[truly & settled]),
        muted_s=float((~held).sum() * step_s),
        muted_after_acquisition_s=float((~held & after).sum() * step_s),
        mutes_after_acquisition=mutes,
        beyond_without_mute_s=float(beyond.sum() * step_s),
        longest_beyond_without_mute_s=_longest(beyond) * step_s,
        coasting_s=float(coasting.sum() * step_s),
        reference_off_urad=_most(trace.reference_off),
        ticks=len(held),
        ticks_without_sample=int((~known).sum()),
        ticks_skipped=int(trace.tick[-1] - first + 1 - len(held)) if len(held) else 0,
    )


def _sampled(run: RecordedRun, message: str, name: str, tick: NDArray[np.int64]) -> Table:
    """A signal as received at each tick, NaN where none was."""
    found: MessageColumns = columns_of(run.frames, message, run.protocol)
    values = np.full(len(tick), np.nan)
    place = np.searchsorted(tick, run.frames["tick"][found.place])
    inside = place < len(tick)
    inside[inside] = tick[place[inside]] == run.frames["tick"][found.place][inside]
    values[place[inside]] = found.physical(name)[inside]
    return values


def _attitude_told(run: RecordedRun, tick: NDArray[np.int64]) -> Table:
    """Roll, pitch and yaw (n, 3) of the base as the antenna told them, straight between; level where it told none."""
    columns = []
    for message, name in (("base_attitude", "roll"), ("base_attitude", "pitch"), ("base_heading", "yaw")):
        told = _sampled(run, message, name, tick)
        known = np.isfinite(told)
        columns.append(np.interp(tick, tick[known], np.unwrap(told[known])) if known.any() else np.zeros(len(tick)))
    return np.column_stack(columns)


def _device_time(run: RecordedRun, tick: NDArray[np.int64], step_s: float, truth: BaseTruth) -> Table:
    """Time (s) of the virtual antenna at the sample of each tick: its tick counter without its turns, which begin where
    the attitude that it told fits the truth best.
    """
    counted = _sampled(run, "drive_status", "tick", tick)
    known = np.isfinite(counted)
    counted = np.interp(tick, tick[known], np.unwrap(counted[known], period=_DEVICE_TICKS))
    roll, pitch = (_sampled(run, "base_attitude", name, tick) for name in ("roll", "pitch"))
    told = np.flatnonzero(np.isfinite(roll) & np.isfinite(pitch))[::7][:4000]
    best, laps = math.inf, 0
    for lap in range(_MOST_LAPS):
        true = truth.at((counted[told] + lap * _DEVICE_TICKS) * step_s)
        off = float(np.mean((true[:, 0] - roll[told]) ** 2 + (true[:, 1] - pitch[told]) ** 2))
        if off < best:
            best, laps = off, lap
    return np.asarray((counted + laps * _DEVICE_TICKS) * step_s)


def _rms(values: Table) -> float:
    return 1e6 * float(np.sqrt(np.mean(values**2))) if len(values) else math.nan


def _most(values: Table) -> float:
    known = values[np.isfinite(values)]
    return 1e6 * float(np.quantile(known, _MOST_OF_ALL)) if len(known) else math.nan


def _peak(values: Table) -> float:
    return 1e6 * float(values.max()) if len(values) else math.nan


def _longest(flags: NDArray[np.bool_]) -> int:
    """Length of the longest row of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], flags.astype(np.int8), [0]])))
    return int((edges[1::2] - edges[::2]).max()) if len(edges) else 0
