"""A triggered scope on the ticks that pass by, at their full rate, with what came before the trigger.

It lives in the service process. Ticks are kept as the bytes they come in; only the signal that triggers is looked at
while it waits, so that a scope that is armed costs next to nothing, and one that is off nothing at all.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.errors import BadInputError
from firmware_protocol.json_object import Json
from gimbal_hil.data.runs import AXES, TICK_ROW, FrameDirection, columns_of, frames_of_blocks
from gimbal_hil.loop.host import HostState
from gimbal_hil.realtime.telemetry.records import Exchange

Floats = NDArray[np.float64]
#: longest stretch, and what a reversal has to pass on either side of rest (rad/s): gyro noise stays inside
LONGEST_S, REVERSAL_RAD_S = 20.0, 0.002
#: from the end of a capture to the next trigger, at least
LEAST_APART_S = 0.05
#: signals that one can trigger on and see, by axis, and of the host
BY_AXIS = ("position", "rate", "torque", "position_ref", "rate_ref")
OF_THE_HOST = ("wake_latency_us", "computing_us")


class ScopeMode(StrEnum):
    """Off; one capture; one after the other; the same, and without a trigger as soon as a screen is full."""

    OFF = "off"
    SINGLE = "single"
    NORMAL = "normal"
    AUTO = "auto"


class TriggerKind(StrEnum):
    """What ends the waiting: a signal passes a level, leaves a window, or something happens; `segment`: one begins."""

    EDGE = "edge"
    WINDOW = "window"
    FAULT = "fault"
    REVERSAL = "reversal"
    MISS = "miss"
    SEGMENT = "segment"


class Slope(StrEnum):
    """Which way a signal passes its level."""

    RISING = "rising"
    FALLING = "falling"
    EITHER = "either"


class ScopeState(StrEnum):
    """What the scope does."""

    OFF = "off"
    ARMED = "armed"
    TRIGGERED = "triggered"
    DONE = "done"


@dataclass(frozen=True)
class ScopeSettings:
    """`signal` in SI units (`rate_outer`, `wake_latency_us`); `before_s` and `after_s` around the trigger. With
    `segment`, the number that `watch` shows, nothing triggers outside that segment of a plan.
    """

    mode: ScopeMode = ScopeMode.OFF
    kind: TriggerKind = TriggerKind.EDGE
    signal: str = "rate_outer"
    #: of an edge; a signal has to leave `level` by `hysteresis` before it can pass it again
    level: float = 0.0
    hysteresis: float = 0.0
    slope: Slope = Slope.RISING
    #: of a window
    low: float = -1.0
    high: float = 1.0
    before_s: float = 0.5
    after_s: float = 0.5
    segment: int | None = None


def scope_settings(document: Json, axes: Sequence[str]) -> ScopeSettings:
    """Settings as somebody asks for them; BadInputError names the key."""
    given = dict(document)
    kinds: dict[str, type[StrEnum]] = {"mode": ScopeMode, "kind": TriggerKind, "slope": Slope}
    for key, value in document.items():
        if key not in ScopeSettings.__dataclass_fields__:
            raise BadInputError(key, "no such setting of the scope", ", ".join(ScopeSettings.__dataclass_fields__))
        if key in kinds:
            if value not in list(kinds[key]):
                raise BadInputError(key, f"is {value!r}", ", ".join(kinds[key]))
            given[key] = kinds[key](value)
        elif key == "signal":
            if value not in signal_names(axes):
                raise BadInputError(key, f"no signal {value!r}", ", ".join(signal_names(axes)))
        elif key == "segment":
            if value is not None and (isinstance(value, bool) or not isinstance(value, int) or value < 0):
                raise BadInputError(key, f"is {value!r}", "the number of a segment, 0 or more, or null for any")
        elif isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
            raise BadInputError(key, f"is {value!r}", "a number")
    settings = ScopeSettings(**given)
    if not (settings.before_s >= 0.0 and settings.after_s > 0.0 and settings.before_s + settings.after_s <= LONGEST_S):
        raise BadInputError(
            "before_s, after_s", f"{settings.before_s:g} and {settings.after_s:g}", f"together at most {LONGEST_S:g} s"
        )
    if settings.kind is TriggerKind.REVERSAL and not settings.signal.startswith("rate_"):
        raise BadInputError("signal", f"is {settings.signal}", "the rate of the axis that reverses")
    return settings


def signal_names(axes: Sequence[str]) -> list[str]:
    """Every signal that a capture holds."""
    return [*(f"{signal}_{axis}" for axis in axes for signal in BY_AXIS), *OF_THE_HOST]


@dataclass(frozen=True)
class Capture:
    """A stretch of ticks in their order around `trigger_tick` (None: nothing triggered, the screen was full)."""

    number: int
    trigger_tick: int | None
    exchanges: tuple[Exchange, ...]
    settings: ScopeSettings


class Scope:
    """Fed with every tick; `take` answers the captures that became whole."""

    def __init__(self, period_ns: int, axes: Sequence[str] = AXES) -> None:
        self._period_ns, self._axes = period_ns, tuple(axes)
        self.settings = ScopeSettings()
        self.state = ScopeState.OFF
        self._asked: ScopeSettings | None = None
        self._history: deque[Exchange] = deque()
        self._armed_tick, self._quiet_until = 0, 0
        self._trigger_tick: int | None = None
        self._count = 0
        #: last value of the signal, and on which side of its level it was seen last
        self._last, self._side = math.nan, 0
        #: segment of the tick before; None before the first
        self._segment: int | None = None

    def ask(self, settings: ScopeSettings) -> None:
        """Settings from the next tick on; may be called from another thread."""
        self._asked = settings

    def take(self, exchanges: Sequence[Exchange]) -> list[Capture]:
        """Ticks in their order."""
        if self._asked is not None:
            self.settings, self._asked = self._asked, None
            self._history.clear()
            self._quiet_until = 0
            self._last, self._side, self._segment = math.nan, 0, None
            self._arm(exchanges[0].tick if exchanges else 0)
        if not exchanges or self.state in (ScopeState.OFF, ScopeState.DONE):
            return []
        found: list[Capture] = []
        fired = self._in_its_segment(exchanges, self._fires(exchanges))
        before, after = self._ticks(self.settings.before_s), max(1, self._ticks(self.settings.after_s))
        for exchange, fires in zip(exchanges, fired, strict=True):
            self._history.append(exchange)
            tick = exchange.tick
            if self.state is ScopeState.ARMED and fires and tick >= self._quiet_until:
                self.state, self._trigger_tick = ScopeState.TRIGGERED, tick
            full = tick >= (self._trigger_tick if self._trigger_tick is not None else tick + 1) + after
            idle = self.state is ScopeState.ARMED and self.settings.mode is ScopeMode.AUTO
            if full or (idle and tick - self._armed_tick >= before + after):
                found.append(self._captured(before, after, tick))
            if self.state is ScopeState.DONE:
                break
        oldest = exchanges[-1].tick - before - after
        while self._history and self._history[0].tick < oldest:
            self._history.popleft()
        return found

    def _captured(self, before: int, after: int, tick: int) -> Capture:
        first = (self._trigger_tick if self._trigger_tick is not None else tick - after) - before
        self._count += 1
        kept = tuple(exchange for exchange in self._history if exchange.tick >= first)
        capture = Capture(self._count, self._trigger_tick, kept, self.settings)
        self._arm(tick)
        # no tick is kept twice: whatever triggers, captures take no more than the ticks that pass
        self._quiet_until = tick + max(before + after, self._ticks(LEAST_APART_S))
        if self.settings.mode is ScopeMode.SINGLE:
            self.state = ScopeState.DONE
        return capture

    def _arm(self, tick: int) -> None:
        self.state = ScopeState.OFF if self.settings.mode is ScopeMode.OFF else ScopeState.ARMED
        self._armed_tick, self._trigger_tick = tick, None

    def _ticks(self, seconds: float) -> int:
        return round(seconds * 1e9 / self._period_ns)

    def _in_its_segment(self, exchanges: Sequence[Exchange], fired: list[bool]) -> list[bool]:
        bound = self.settings.segment
        if bound is None:
            return fired
        return [
            one and number == bound for one, number in zip(fired, _rows(exchanges)["segment"].tolist(), strict=True)
        ]

    def _fires(self, exchanges: Sequence[Exchange]) -> list[bool]:
        """For each tick whether the trigger is met there."""
        wanted, rows = self.settings, _rows(exchanges)
        if wanted.kind is TriggerKind.MISS:
            return list(rows["skipped_ticks"] > 0)
        if wanted.kind is TriggerKind.FAULT:
            values = np.isin(rows["host_state"], (HostState.FAULT, HostState.STOPPING)).astype(float)
            return self._edges(values, 0.5, 0.0, Slope.RISING)
        if wanted.kind is TriggerKind.SEGMENT:
            numbers = rows["segment"].tolist()
            before = [numbers[0] if self._segment is None else self._segment, *numbers[:-1]]
            self._segment = numbers[-1]
            # what ends leads to none (-1), and that is no beginning
            return [now != was and now >= 0 for was, now in zip(before, numbers, strict=True)]
        values = column_of(wanted.signal, exchanges, rows, self._axes, self._last)
        if wanted.kind is TriggerKind.REVERSAL:
            return self._edges(values, 0.0, max(wanted.hysteresis, REVERSAL_RAD_S), Slope.EITHER)
        if wanted.kind is TriggerKind.WINDOW:
            outside = ((values < wanted.low) | (values > wanted.high)).astype(float)
            outside[np.isnan(values)] = np.nan
            self._last = float(values[-1])
            return self._edges(outside, 0.5, 0.0, Slope.RISING, keep=False)
        return self._edges(values, wanted.level, wanted.hysteresis, wanted.slope)

    def _edges(self, values: Floats, level: float, hysteresis: float, slope: Slope, keep: bool = True) -> list[bool]:
        found = []
        for value in values.tolist():
            side = 1 if value >= level + hysteresis else -1 if value < level - hysteresis else 0
            passed = side != 0 and self._side != 0 and side != self._side
            found.append(passed and (slope is Slope.EITHER or (side > 0) == (slope is Slope.RISING)))
            self._side = side or self._side
        if keep:
            self._last = float(values[-1])
        return found


def _rows(exchanges: Sequence[Exchange]) -> NDArray[np.void]:
    return np.frombuffer(b"".join(exchange.row for exchange in exchanges), TICK_ROW)


def column_of(
    signal: str, exchanges: Sequence[Exchange], rows: NDArray[np.void], axes: Sequence[str], last: float = math.nan
) -> Floats:
    """A signal at every tick, (n,); a measured one holds its last value (`last` at first) until a good frame comes."""
    if signal in OF_THE_HOST:
        return np.asarray(rows[signal.replace("_us", "_ns")], float) / 1e3
    name = next(name for name in BY_AXIS if signal in {f"{name}_{axis}" for axis in axes})
    own = AXES[list(axes).index(signal.removeprefix(f"{name}_"))]
    if name not in ("position", "rate"):
        return np.asarray(rows[f"{name}_{own}"], float)
    ticks = np.array([exchange.tick for exchange in exchanges], np.int64)
    received = np.full(len(ticks), FrameDirection.DEVICE_TO_HOST, np.int64)
    frames = frames_of_blocks(ticks, received, [exchange.received for exchange in exchanges])
    columns = columns_of(frames, f"feedback_{own}")
    measured = columns.physical(name)
    place = np.searchsorted(columns.tick, ticks, side="right") - 1
    return np.where(place >= 0, measured[np.maximum(place, 0)], last) if len(measured) else np.full(len(ticks), last)


def capture_columns(capture: Capture, axes: Sequence[str]) -> Json:
    """A capture for a screen: `time_s` from the trigger (or the end of the first part), and every signal, as lists."""
    rows = _rows(capture.exchanges)
    time_s = rows["time_ns"] * 1e-9
    ticks = rows["tick"]
    zero = float(time_s[np.searchsorted(ticks, capture.trigger_tick)]) if capture.trigger_tick is not None else None
    found: dict[str, object] = {
        "time_s": [round(t, 6) for t in (time_s - (time_s[0] if zero is None else zero)).tolist()]
    }
    for signal in signal_names(axes):
        values = column_of(signal, capture.exchanges, rows, axes)
        found[signal] = [float(f"{value:.6g}") if math.isfinite(value) else None for value in values.tolist()]
    return found
