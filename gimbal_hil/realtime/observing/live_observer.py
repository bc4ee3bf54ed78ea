"""The model led along what the antenna measures, fed with the exchanges that pass by the service."""

from __future__ import annotations

import math
import threading
from collections.abc import Sequence

import numpy as np

from firmware_protocol import schema
from firmware_protocol.enumerations import DriveState
from firmware_protocol.errors import BadInputError
from firmware_protocol.json_object import Json
from gimbal_hil.data.runs import AXES, TICK_ROW
from gimbal_hil.loop.host import HostState
from gimbal_hil.loop.settings import DaemonSettings
from gimbal_hil.realtime.observing.change import AxisWatch, ObserverState, WatchState
from gimbal_hil.realtime.observing.frame_values import FieldReader, frames_in
from gimbal_hil.realtime.observing.suspicion import CONFIRMED_BY, Suspected, SuspicionWatch
from gimbal_hil.realtime.telemetry import Exchange
from sim_backend import observer as columns
from sim_backend.layout import BASE_COLUMNS
from sim_backend.model import AntennaModel, model_named
from sim_backend.observer import ModelObserver

_FREE = (HostState.ACTIVE, HostState.STOPPING)
_WINDOW_S = 1.0
#: after so many time constants a triple pole has 1.4 % left
_SETTLED = 8.0
#: and by so many what it tells is late
_LATE = 3.0
_SEQUENCES, _DEVICE_TICKS = 1024, 4096
#: share of a new difference in the base's angular acceleration: its rates come in whole steps
_BASE_SHARE = 0.2
_FEEDBACK = tuple(schema.BY_NAME[f"feedback_{axis}"].can_id for axis in AXES)
_MEASURED = tuple((FieldReader.of(f"feedback_{a}", "position"), FieldReader.of(f"feedback_{a}", "rate")) for a in AXES)
_STATUS = schema.BY_NAME["drive_status"].can_id
_STATE, _ECHO, _DEVICE_TICK = (FieldReader.of("drive_status", name) for name in ("state", "last_sequence", "tick"))
#: messages of the base, and where in its row their fields go; rates come last and carry the row along
_BASE = {
    schema.BY_NAME[name].can_id: tuple((FieldReader.of(name, field), place) for field, place in fields)
    for name, fields in {
        "base_attitude": (("roll", 0), ("pitch", 1)),
        "base_heading": (("yaw", 2),),
        "base_acceleration": (("ax", 9), ("ay", 10), ("az", 11)),
        "base_rate": (("p", 3), ("q", 4), ("r", 5)),
    }.items()
}
_BASE_RATE = schema.BY_NAME["base_rate"].can_id


def observed_model(settings: DaemonSettings) -> AntennaModel | None:
    """The model beside the antenna; BadInputError where it is none of this antenna."""
    name = settings.observed_model
    if name is None:
        return None
    own = settings.observer.model is not None
    model = model_named(name, "observer.model" if own else "link.embedded.model")
    names = settings.axis_names[: len(model.axes)]
    if own and tuple(model.axes) != names:
        expected = f"a model of {' and '.join(settings.axis_names)}"
        raise BadInputError("observer.model", f"{name} has the axes {' and '.join(model.axes)}", expected)
    return model


def _give_rad(model: AntennaModel, axis: str) -> float:
    """How far a joint moves on its bristles before it slides."""
    stiffness = model.number(axis, "friction.sigma0")
    return model.number(axis, "friction.breakaway") / stiffness if stiffness > 0.0 else 0.0


def _told(suspected: Suspected | None) -> Json | None:
    """What is suspected of an axis, for people and programs."""
    if suspected is None:
        return None
    return {
        "cause": suspected.cause.value,
        "probability": round(suspected.probability, 3),
        "size": suspected.size,
        "order": suspected.order,
        "text": suspected.text,
        "confirmed_by": CONFIRMED_BY[suspected.cause],
    }


class LiveObserver:
    """`take` answers the missing torques of every exchange, NaN while nothing is known."""

    def __init__(self, settings: DaemonSettings, at_once: bool = False) -> None:
        """Its kernel is loaded (or compiled) beside the work of the service, unless `at_once`."""
        self._settings = settings
        self.model_name = settings.observed_model
        self._observer: ModelObserver | None = None
        self._problem = ""
        self._bandwidth_rad_s = 2.0 * math.pi * settings.observer_bandwidth_hz
        window = max(1, round(_WINDOW_S * settings.rate_hz))
        settling = math.ceil(_SETTLED / self._bandwidth_rad_s * settings.rate_hz)
        least = [settings.observer.least_share * axis.limits.torque_nm for axis in settings.axes.values()]
        self.watches = {n: AxisWatch(window, settling, nm) for n, nm in zip(settings.axis_names, least, strict=True)}
        self.suspicions = {
            n: SuspicionWatch(settings.rate_hz, nm, _LATE / self._bandwidth_rad_s)
            for n, nm in zip(settings.axis_names, least, strict=True)
        }
        self._suspected: list[tuple[str, Suspected]] = []
        self._torques = np.zeros((_SEQUENCES, 2))
        self._measured = np.zeros((2, 2))
        self._base = np.zeros(BASE_COLUMNS)
        self._base_s: float | None = None
        self._torque_before = np.zeros(2)
        self._device_tick: int | None = None
        self._was_free = False
        self._changed: list[tuple[str, AxisWatch]] = []
        self._missing, self._gyro_error = [math.nan, math.nan], [math.nan, math.nan]
        self._loading = self.model_name is None
        if at_once and not self._loading:
            self._loading = True
            self._load()

    def _load(self) -> None:
        try:
            model = observed_model(self._settings)
            assert model is not None
            made = ModelObserver(model, self._settings.rate_hz, self._bandwidth_rad_s)
            made.observe(np.zeros((1, columns.INPUTS)))
        except BadInputError as refused:
            self._problem = str(refused)
            return
        for axis, watch in zip(model.axes, self.watches.values(), strict=False):
            watch.give_rad = _give_rad(model, axis)
        self._observer = made

    def take(self, exchanges: Sequence[Exchange]) -> list[tuple[float, float]]:
        """Exchanges in their order; answers (outer, inner) missing torque after each, N m."""
        if not self._loading and exchanges:
            # only now: before its first tick the control process has had everything compiled
            self._loading = True
            threading.Thread(target=self._load, daemon=True).start()
        observer = self._observer
        if observer is None or not exchanges:
            return [(math.nan, math.nan)] * len(exchanges)
        found: list[tuple[float, float]] = []
        rows: list[list[float]] = []
        ticks = np.frombuffer(b"".join(exchange.row for exchange in exchanges), TICK_ROW)
        states, rejected = ticks["host_state"].tolist(), ticks["rejected_frames"].tolist()
        numbers, times = ticks["tick"].tolist(), (ticks["time_ns"] * 1e-9).tolist()
        for index, exchange in enumerate(exchanges):
            free = states[index] in _FREE
            row, base_moved = self._row(exchange.received, free, bool(rejected[index]), times[index])
            if base_moved:
                found += self._observed(observer, rows)
                rows = []
                observer.base_is(self._base)
            rows.append(row)
            self._torques[numbers[index] % _SEQUENCES] = ticks["torque_outer"][index], ticks["torque_inner"][index]
        return found + self._observed(observer, rows)

    def _row(self, received: bytes, free: bool, rejected: bool, time_s: float) -> tuple[list[float], bool]:
        """What the observer is given for one exchange, and whether the base was heard."""
        fresh, base_moved, status = 0, False, None
        for identifier, word in frames_in(received):
            if identifier == _STATUS:
                status = word
            elif identifier in _FEEDBACK:
                axis = _FEEDBACK.index(identifier)
                position, rate = _MEASURED[axis]
                self._measured[axis] = position.value(word), rate.value(word)
                fresh |= 1 << axis
            elif identifier in _BASE:
                self._hear_base(identifier, word, time_s)
                base_moved = base_moved or identifier == _BASE_RATE
        elapsed, torque = 0.0, self._torque_before
        if status is not None and not rejected:
            tick = int(_DEVICE_TICK.value(status))
            if self._device_tick is not None:
                elapsed = float((tick - self._device_tick) % _DEVICE_TICKS)
            self._device_tick = tick
            torque = self._torques[int(_ECHO.value(status))].copy()
            free = free and _STATE.value(status) == DriveState.OPERATION_ENABLED
        before, self._torque_before = self._torque_before, torque
        measured = fresh == 3 and status is not None and not rejected
        row = [elapsed, *torque, *before, *self._measured[:, 0], *self._measured[:, 1], float(measured), float(free)]
        return [float(value) for value in row], base_moved

    def _hear_base(self, identifier: int, word: int, time_s: float) -> None:
        before = self._base[3:6].copy()
        for reader, place in _BASE[identifier]:
            self._base[place] = reader.value(word)
        if identifier == _BASE_RATE:
            if self._base_s is not None and time_s > self._base_s:
                grown = (self._base[3:6] - before) / (time_s - self._base_s)
                self._base[6:9] += _BASE_SHARE * (grown - self._base[6:9])
            self._base_s = time_s

    def _observed(self, observer: ModelObserver, rows: list[list[float]]) -> list[tuple[float, float]]:
        if not rows:
            return []
        told = observer.observe(np.array(rows)).tolist()
        found: list[tuple[float, float]] = []
        for row, out in zip(rows, told, strict=True):
            free = row[columns.FREE] != 0.0
            if free and not self._was_free:
                for watch in self.watches.values():
                    watch.settle()
                for suspicion in self.suspicions.values():
                    suspicion.forget()
            self._was_free = free
            if not np.all(np.isfinite(out)):
                self._observer, self._problem = None, "the observer has diverged: its estimates are beyond all bounds"
                self._missing, self._gyro_error = [math.nan, math.nan], [math.nan, math.nan]
                return found + [(math.nan, math.nan)] * (len(rows) - len(found))
            if free and row[columns.MEASURED] != 0.0:
                self._missing = out[columns.MISSING : columns.MISSING + 2]
                self._gyro_error = out[columns.GYRO_ERROR : columns.GYRO_ERROR + 2]
                for place, (name, watch) in enumerate(list(self.watches.items())[: observer.axes]):
                    if watch.take(self._missing[place], row[columns.ENCODER + place]):
                        self._changed.append((name, watch))
                    self._suspect(name, place, row)
            elif not free:
                self._missing, self._gyro_error = [math.nan, math.nan], [math.nan, math.nan]
            found.append((self._missing[0], self._missing[1]))
        return found

    def _suspect(self, name: str, place: int, row: list[float]) -> None:
        watch = self.suspicions[name]
        position, torque = row[columns.ENCODER + place], row[columns.TORQUE + place]
        if watch.take(self._missing[place], position, torque, self._gyro_error[place]):
            assert watch.suspected is not None
            self._suspected.append((name, watch.suspected))

    def suspects(self) -> list[tuple[str, Suspected]]:
        """What has come to be suspected of an axis since the last call."""
        found, self._suspected = self._suspected, []
        return found

    def changes(self) -> list[tuple[str, AxisWatch]]:
        """Axes that went over to changed, or back, since the last call."""
        found, self._changed = self._changed, []
        return found

    def learn_anew(self) -> None:
        """What comes from now on is usual."""
        for watch in self.watches.values():
            watch.learn_anew()
        for suspicion in self.suspicions.values():
            suspicion.learn_anew()

    def status(self) -> Json:
        """For people: `state` is off, loading, failed, waiting (no axis under torque) or watching."""
        if self.model_name is None:
            state = ObserverState.OFF
        elif self._problem:
            state = ObserverState.FAILED
        elif self._observer is None:
            state = ObserverState.LOADING
        else:
            state = ObserverState.WATCHING if self._was_free else ObserverState.WAITING
        axes = {}
        for place, (name, watch) in enumerate(self.watches.items()):
            now = self._missing[place]
            axes[name] = {
                "missing_torque_nm": now if math.isfinite(now) else None,
                "gyro_error_rad_s": self._gyro_error[place] if math.isfinite(now) else None,
                "rms_nm": watch.rms_nm,
                "usual_nm": watch.usual_nm,
                "state": watch.state.value,
                "suspected": _told(self.suspicions[name].suspected),
            }
        changed = any(watch.state is WatchState.CHANGED for watch in self.watches.values())
        return {"state": state, "model": self.model_name, "problem": self._problem, "changed": changed, "axes": axes}
