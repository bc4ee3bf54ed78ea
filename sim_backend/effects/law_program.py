"""The laws of a model file that no effect of the catalogue has, as programs that compiled code runs.

A program is a list of operations on a stack, (code, number) each, followed by the tables that they read; it lies in P
behind everything else. The stack and the memory of its operators lie among the states of its effect in X. So a model
with another law needs no new compilation, replays bit for bit, and nothing that a file says is ever executed as code.
"""

from __future__ import annotations

from enum import IntEnum

import numpy as np

from firmware_protocol.compiling import compiled
from firmware_protocol.elementary import exponential, logarithm_of_two, power_of_two, sine_cosine
from sim_backend.layout import STEP_S, STEPS


class Operation(IntEnum):
    """What one operation does: takes its arguments off the stack and puts its value there."""

    NUMBER = 0
    #: one of `Given`
    VARIABLE = 1
    ADD = 2
    SUBTRACT = 3
    MULTIPLY = 4
    DIVIDE = 5
    #: of the modulus of the first: a whole power of a signed number is a product
    POWER = 6
    NEGATE = 7
    ABS = 8
    SIGN = 9
    SINE = 10
    COSINE = 11
    EXPONENTIAL = 12
    TANH = 13
    SQUARE_ROOT = 14
    LEAST = 15
    MOST = 16
    #: cubic spline; the number is where its table begins
    SPLINE = 17
    #: straight between the knots of two variables
    SURFACE = 18
    #: play: how far what is dragged along with slack hangs back; the number is the slack
    HANGS_BACK = 19
    #: relaxation: mean speed of late; the number is the time over which it is forgotten
    RECENT_SPEED = 20
    #: which way the joint goes, turned from one to the other over a travel: between -1 and 1; the number is half the
    #: travel, 0 the sign of the rate
    DIRECTION = 21
    #: time since the number's last multiple
    PHASE_TIME = 22
    #: Bouc and Wen's: as play, but it gives way before its slack; the power of the shoulder lies on the stack
    GIVES_WAY = 23


class Given(IntEnum):
    """What a law may be written over."""

    POSITION = 0
    RATE = 1
    #: the torque that is commanded, or (friction) applied
    TORQUE = 2
    TEMPERATURE = 3
    TIME = 4


#: floats of an operation, deepest stack, and parameters of the instance: where the program begins in P, its length
OPERATION_SIZE, STACK = 2, 12
PROGRAM, OPERATIONS = range(2)
_MEMORY = tuple(
    int(one) for one in (Operation.HANGS_BACK, Operation.RECENT_SPEED, Operation.DIRECTION, Operation.GIVES_WAY)
)
(
    _NUMBER, _VARIABLE, _ADD, _SUBTRACT, _MULTIPLY, _DIVIDE, _POWER, _NEGATE, _ABS, _SIGN, _SINE, _COSINE, _EXPONENTIAL,
    _TANH, _SQUARE_ROOT, _LEAST, _MOST, _SPLINE, _SURFACE, _HANGS_BACK, _RECENT_SPEED, _DIRECTION, _PHASE_TIME,
    _GIVES_WAY,
) = (int(operation) for operation in Operation)  # fmt: skip
_POSITION, _RATE, _TORQUE, _TEMPERATURE, _TIME = (int(given) for given in Given)


def states_of(codes: tuple[Operation, ...]) -> int:
    """States in X that a program of these operations needs: its stack, and one for each that has memory."""
    return STACK + sum(int(code) in _MEMORY for code in codes)


@compiled
def _sign(x: float) -> float:
    return 1.0 if x > 0.0 else (-1.0 if x < 0.0 else 0.0)


@compiled
def _cell(P: np.ndarray, first: int, count: int, x: float) -> int:
    """Which of the `count` - 1 intervals between knots that begin at P[first] holds x, by halving."""
    low, high = 0, count - 1
    while high - low > 1:
        middle = (low + high) // 2
        if x >= P[first + middle]:
            low = middle
        else:
            high = middle
    return low


@compiled
def spline_value(P: np.ndarray, table: int, x: float) -> float:
    """Cubic Hermite through (count, knots, values, slopes) at P[table]; outside the knots it stays as at the last
    one.
    """
    count = int(P[table])
    knots, values, slopes = table + 1, table + 1 + count, table + 1 + 2 * count
    x = min(max(x, P[knots]), P[knots + count - 1])
    i = _cell(P, knots, count, x)
    width = P[knots + i + 1] - P[knots + i]
    t = (x - P[knots + i]) / width
    rest = 1.0 - t
    return float(
        rest * rest * ((1.0 + 2.0 * t) * P[values + i] + t * width * P[slopes + i])
        + t * t * ((1.0 + 2.0 * rest) * P[values + i + 1] - rest * width * P[slopes + i + 1])
    )


@compiled
def surface_value(P: np.ndarray, table: int, x: float, y: float) -> float:
    """Straight in both variables through (counts, knots of each, values by the first) at P[table]; held at its edge."""
    across, along = int(P[table]), int(P[table + 1])
    first, second, values = table + 2, table + 2 + across, table + 2 + across + along
    x = min(max(x, P[first]), P[first + across - 1])
    y = min(max(y, P[second]), P[second + along - 1])
    i, j = _cell(P, first, across, x), _cell(P, second, along, y)
    s = (x - P[first + i]) / (P[first + i + 1] - P[first + i])
    t = (y - P[second + j]) / (P[second + j + 1] - P[second + j])
    at = values + i * along + j
    return float(
        (1.0 - s) * ((1.0 - t) * P[at] + t * P[at + 1]) + s * ((1.0 - t) * P[at + along] + t * P[at + along + 1])
    )


@compiled
def _of_one(code: int, x: float) -> float:
    if code == _NEGATE:
        return -x
    if code == _ABS:
        return abs(x)
    if code == _SIGN:
        return _sign(x)
    if code == _SINE:
        return sine_cosine(x)[0]
    if code == _COSINE:
        return sine_cosine(x)[1]
    if code == _EXPONENTIAL:
        return exponential(min(x, 300.0))
    if code == _TANH:
        fades = exponential(-2.0 * abs(x))
        return _sign(x) * (1.0 - fades) / (1.0 + fades)
    return float(np.sqrt(max(x, 0.0)))


@compiled
def _of_two(code: int, x: float, y: float) -> float:
    if code == _ADD:
        return x + y
    if code == _SUBTRACT:
        return x - y
    if code == _MULTIPLY:
        return x * y
    if code == _DIVIDE:
        return x / y if y != 0.0 else 0.0
    if code == _LEAST:
        return min(x, y)
    if code == _MOST:
        return max(x, y)
    return power_of_two(min(max(y * logarithm_of_two(abs(x)), -1000.0), 200.0)) if x != 0.0 else 0.0


@compiled
def _dragged(back: float, step: float, slack: float, power: float) -> float:
    """How far something hangs back after one more step: the nearer its slack, the more of the step it comes along."""
    full = abs(back) / slack
    comes = power_of_two(min(max(power * logarithm_of_two(full), -1000.0), 0.0)) if full > 0.0 else 0.0
    return float(min(max(back + step - abs(step) * _sign(back) * comes, -slack), slack))


@compiled
def law_value(
    P: np.ndarray, o: int, X: np.ndarray, s: int, q: float, v: float, torque: float, temperature: float
) -> float:
    """What the law whose program P[o] names answers where the joint is; its memory advances by one step."""
    first, h = int(P[o + PROGRAM]), P[STEP_S]
    top, memory = s - 1, s + STACK
    for i in range(int(P[o + OPERATIONS])):
        code, number = int(P[first + OPERATION_SIZE * i]), P[first + OPERATION_SIZE * i + 1]
        if code == _NUMBER:
            top += 1
            X[top] = number
        elif code == _VARIABLE:
            top += 1
            which = int(number)
            if which == _POSITION:
                X[top] = q
            elif which == _RATE:
                X[top] = v
            elif which == _TORQUE:
                X[top] = torque
            elif which == _TEMPERATURE:
                X[top] = temperature
            else:
                X[top] = X[STEPS] * h
        elif code == _SPLINE:
            X[top] = spline_value(P, first + int(number), X[top])
        elif code == _SURFACE:
            top -= 1
            X[top] = surface_value(P, first + int(number), X[top], X[top + 1])
        elif code == _HANGS_BACK:
            X[memory] = min(max(X[memory] + v * h, -number), number)
            top += 1
            X[top] = X[memory]
            memory += 1
        elif code == _RECENT_SPEED:
            X[memory] += (abs(v) - X[memory]) * h / (number + h)
            top += 1
            X[top] = X[memory]
            memory += 1
        elif code == _DIRECTION:
            X[memory] = min(max(X[memory] + v * h / number, -1.0), 1.0) if number > 0.0 else _sign(v)
            top += 1
            X[top] = X[memory]
            memory += 1
        elif code == _PHASE_TIME:
            top += 1
            X[top] = X[STEPS] * h - number * np.floor(X[STEPS] * h / number)
        elif code == _GIVES_WAY:
            X[memory] = _dragged(X[memory], v * h, number, X[top])
            X[top] = X[memory]
            memory += 1
        elif code >= _NEGATE and code <= _SQUARE_ROOT:
            X[top] = _of_one(code, X[top])
        else:
            top -= 1
            X[top] = _of_two(code, X[top], X[top + 1])
    return float(X[s])


__all__ = ["Given", "Operation", "law_value", "spline_value", "states_of", "surface_value"]
