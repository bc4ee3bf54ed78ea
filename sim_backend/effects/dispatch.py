"""From the catalogue to compiled code: for each hook one function that picks the law by its code.

The laws are chained at import time (`if code == 0: ... else: rest`), so one kernel holds every effect, a model with
other effects needs no new compilation, and an absent effect is never looked at: the plant loops over the instances
present.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from firmware_protocol.compiling import compiled
from sim_backend.effects.effect import Hook
from sim_backend.effects.registry import effects_at

Law = Callable[..., Any]


@compiled
def _command_unchanged(
    code: int, P: np.ndarray, o: int, X: np.ndarray, s: int, K: np.ndarray, u: float, q: float, v: float
) -> float:
    return u


def _command_chain(laws: tuple[Law, ...], code: int = 0) -> Law:
    if not laws:
        return _command_unchanged
    law, rest = laws[0], _command_chain(laws[1:], code + 1)

    @compiled
    def pick(
        c: int, P: np.ndarray, o: int, X: np.ndarray, s: int, K: np.ndarray, u: float, q: float, v: float
    ) -> float:
        return law(P, o, X, s, K, u, q, v) if c == code else rest(c, P, o, X, s, K, u, q, v)  # type: ignore[no-any-return]

    return pick


@compiled
def _levels_unchanged(
    c: int,
    P: np.ndarray,
    o: int,
    X: np.ndarray,
    s: int,
    q: float,
    v: float,
    torque: float,
    temperature: float,
    ts: float,
    tc: float,
    sigma2: float,
) -> tuple[float, float, float]:
    return ts, tc, sigma2


def _friction_chain(laws: tuple[Law, ...], code: int = 0) -> Law:
    if not laws:
        return _levels_unchanged
    law, rest = laws[0], _friction_chain(laws[1:], code + 1)

    @compiled
    def pick(
        c: int,
        P: np.ndarray,
        o: int,
        X: np.ndarray,
        s: int,
        q: float,
        v: float,
        torque: float,
        temperature: float,
        ts: float,
        tc: float,
        sigma2: float,
    ) -> tuple[float, float, float]:
        if c == code:
            return law(P, o, X, s, q, v, torque, temperature, ts, tc, sigma2)  # type: ignore[no-any-return]
        return rest(c, P, o, X, s, q, v, torque, temperature, ts, tc, sigma2)  # type: ignore[no-any-return]

    return pick


@compiled
def _no_torque(c: int, P: np.ndarray, o: int, X: np.ndarray, s: int, q: float, v: float, h: float) -> float:
    return 0.0


def _torque_chain(laws: tuple[Law, ...], code: int = 0) -> Law:
    if not laws:
        return _no_torque
    law, rest = laws[0], _torque_chain(laws[1:], code + 1)

    @compiled
    def pick(c: int, P: np.ndarray, o: int, X: np.ndarray, s: int, q: float, v: float, h: float) -> float:
        return law(P, o, X, s, q, v, h) if c == code else rest(c, P, o, X, s, q, v, h)  # type: ignore[no-any-return]

    return pick


@compiled
def _rigid(
    c: int, P: np.ndarray, o: int, X: np.ndarray, s: int, torque: float, inertia: float, bias: float
) -> tuple[float, float]:
    return torque, 0.0


def _structure_chain(laws: tuple[Law, ...], code: int = 0) -> Law:
    if not laws:
        return _rigid
    law, rest = laws[0], _structure_chain(laws[1:], code + 1)

    @compiled
    def pick(
        c: int, P: np.ndarray, o: int, X: np.ndarray, s: int, torque: float, inertia: float, bias: float
    ) -> tuple[float, float]:
        if c == code:
            return law(P, o, X, s, torque, inertia, bias)  # type: ignore[no-any-return]
        return rest(c, P, o, X, s, torque, inertia, bias)  # type: ignore[no-any-return]

    return pick


@compiled
def _nothing_hidden(
    c: int, P: np.ndarray, o: int, X: np.ndarray, s: int, torque: float, inertia: float, acceleration: float, h: float
) -> None:
    return


@compiled
def _no_hidden_state(
    P: np.ndarray, o: int, X: np.ndarray, s: int, torque: float, inertia: float, acceleration: float, h: float
) -> None:
    return


def _advance_chain(laws: tuple[Law, ...], code: int = 0) -> Law:
    if not laws:
        return _nothing_hidden
    law, rest = laws[0], _advance_chain(laws[1:], code + 1)

    @compiled
    def pick(
        c: int,
        P: np.ndarray,
        o: int,
        X: np.ndarray,
        s: int,
        torque: float,
        inertia: float,
        acceleration: float,
        h: float,
    ) -> None:
        if c == code:
            law(P, o, X, s, torque, inertia, acceleration, h)
        else:
            rest(c, P, o, X, s, torque, inertia, acceleration, h)

    return pick


@compiled
def _true_position(c: int, P: np.ndarray, o: int, X: np.ndarray, s: int, position: float) -> float:
    return 0.0


def _encoder_chain(laws: tuple[Law, ...], code: int = 0) -> Law:
    if not laws:
        return _true_position
    law, rest = laws[0], _encoder_chain(laws[1:], code + 1)

    @compiled
    def pick(c: int, P: np.ndarray, o: int, X: np.ndarray, s: int, position: float) -> float:
        return law(P, o, X, s, position) if c == code else rest(c, P, o, X, s, position)  # type: ignore[no-any-return]

    return pick


@compiled
def _true_rate(
    c: int, P: np.ndarray, o: int, X: np.ndarray, s: int, axis: int, wx: float, wy: float, wz: float
) -> float:
    return 0.0


def _gyro_chain(laws: tuple[Law, ...], code: int = 0) -> Law:
    if not laws:
        return _true_rate
    law, rest = laws[0], _gyro_chain(laws[1:], code + 1)

    @compiled
    def pick(c: int, P: np.ndarray, o: int, X: np.ndarray, s: int, axis: int, wx: float, wy: float, wz: float) -> float:
        return law(P, o, X, s, axis, wx, wy, wz) if c == code else rest(c, P, o, X, s, axis, wx, wy, wz)  # type: ignore[no-any-return]

    return pick


def _laws(hook: Hook) -> tuple[Law, ...]:
    return tuple(effect.law for effect in effects_at(hook) if effect.law is not None)


command_law = _command_chain(_laws(Hook.COMMAND))
friction_law = _friction_chain(_laws(Hook.FRICTION))
torque_law = _torque_chain(_laws(Hook.TORQUE))
structure_law = _structure_chain(_laws(Hook.STRUCTURE))
# one entry for each law, so that codes agree
structure_advance = _advance_chain(
    tuple(effect.advance or _no_hidden_state for effect in effects_at(Hook.STRUCTURE) if effect.law is not None)
)
encoder_law = _encoder_chain(_laws(Hook.ENCODER))
gyro_law = _gyro_chain(_laws(Hook.GYRO))
