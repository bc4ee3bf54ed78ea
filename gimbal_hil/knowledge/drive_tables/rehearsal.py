"""The tables tried on simulated drives that close their own loops, on the antenna that the model describes.

Twice the same motion, without and with the tables: an even slow speed, whose ripple is measured, and a slow swing,
whose largest error about its reversals is. Weight and inertia are in no table: the bodies are balanced for the
rehearsal, and the host sends the torque of the inertia both times.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import chain

import numpy as np

from firmware_protocol.links import AdapterLinkConfig
from gimbal_hil.knowledge.drive_tables.friction import FrictionFeed
from gimbal_hil.knowledge.drive_tables.players import PLAYERS, Player
from gimbal_hil.knowledge.drive_tables.ripple import is_over_position
from gimbal_hil.knowledge.drive_tables.tables import AxisTables
from sim_backend.drives import DrivenGimbal
from sim_backend.layout import RATE
from sim_backend.model import ENDLESS, AntennaModel

_RATE_HZ = 1000.0
_BANDWIDTH_RAD_S = 2.0 * math.pi * 3.0
#: ripples a second, and how many are looked at after the loops have settled
_RIPPLES_HZ, _RIPPLES = 2.0, 6
_SETTLE_S = 2.5
#: the swing: its amplitude in travels of a reversal and at least, rad; its period and how many are looked at
_TRAVELS, _LEAST_SWING_RAD = 20.0, 0.02
_PERIOD_S, _SWINGS = 6.0, 1.0

#: position, rate and acceleration of a reference at a time, rad from the middle
Motion = Callable[[float], tuple[float, float, float]]


@dataclass(frozen=True)
class Rehearsed:
    """One axis without and with its tables: ripple of the speed (rms, rad/s; None without a ripple in the table) and
    largest error about a reversal (rad).
    """

    axis: str
    speed_rad_s: float | None
    ripple_rad_s: tuple[float, float] | None
    reversal_rad: tuple[float, float]


def rehearse(model: AntennaModel, link: AdapterLinkConfig, tables: tuple[AxisTables, ...], place: int) -> Rehearsed:
    """Try one axis (its place in the model)."""
    axis = model.axes[place]
    balanced = _balanced(model)
    orders = [
        entry.value("order")
        for entry in model.effects
        if entry.axis == axis and is_over_position(entry) and any(p.name == "order" for p in entry.effect.parameters)
    ]
    ripple = speed = None
    if tables[place].ripple.holds_something and orders:
        speed = 2.0 * math.pi * _RIPPLES_HZ / min(orders)
        seconds = _SETTLE_S + _RIPPLES / _RIPPLES_HZ
        even = _even(speed, seconds)
        runs = [_run(balanced, link, tables, place, even, seconds, use) for use in (False, True)]
        ripple = _ripple(runs[0], seconds), _ripple(runs[1], seconds)
    amplitude = max(_TRAVELS * tables[place].friction.reversal_travel, _LEAST_SWING_RAD)
    seconds = _PERIOD_S * (1.0 + _SWINGS)
    swing = _swing(amplitude)
    without, used = (_largest(_run(balanced, link, tables, place, swing, seconds, use)) for use in (False, True))
    return Rehearsed(axis, speed, ripple, (without, used))


def _even(speed: float, seconds: float) -> Motion:
    """An even speed about the middle, begun smoothly over half the time for settling."""
    begun = 0.5 * _SETTLE_S
    start = -0.5 * speed * (seconds - 0.5 * begun)

    def at(time_s: float) -> tuple[float, float, float]:
        if time_s < begun:
            return start + 0.5 * speed * time_s**2 / begun, speed * time_s / begun, speed / begun
        return start + speed * (time_s - 0.5 * begun), speed, 0.0

    return at


def _swing(amplitude: float) -> Motion:
    turn = 2.0 * math.pi / _PERIOD_S
    return lambda t: (
        amplitude * (1.0 - math.cos(turn * t)),
        amplitude * turn * math.sin(turn * t),
        amplitude * turn**2 * math.cos(turn * t),
    )


def _run(
    model: AntennaModel,
    link: AdapterLinkConfig,
    tables: tuple[AxisTables, ...],
    place: int,
    motion: Motion,
    seconds: float,
    use: bool,
) -> np.ndarray:
    """Rows (time, error in position, rate) of the axis in motion, true values; the others stand."""
    middle = [0.5 * sum(_travel(model, axis)) for axis in model.axes]
    starts = [middle[at] + (motion(0.0)[0] if at == place else 0.0) for at in range(len(model.axes))]
    for axis, start in zip(model.axes, starts, strict=True):
        model = model.with_number(axis, "start.position", start)
    players = [_player(model, link.drive, tables, at) for at in range(len(model.axes))]
    gimbal = DrivenGimbal(model, [player.drive for player in players], link.drives[: len(players)], _RATE_HZ)
    feeds = [FrictionFeed(one.friction, 1.0 / _RATE_HZ) for one in tables]
    if use:
        for player, one in zip(players, tables, strict=True):
            if one.ripple.holds_something:
                player.load(one.ripple)
    gimbal.hear(list(chain.from_iterable(player.begin() for player in players)))
    rows = np.zeros((round(seconds * _RATE_HZ), 3))
    for tick in range(len(rows)):
        now = tick / _RATE_HZ
        position, rate, acceleration = motion(now)
        for at, player in enumerate(players):
            asked = (middle[at] + position, rate) if at == place else (starts[at], 0.0)
            torque = feeds[at].torque_nm(*asked) if use else 0.0
            torque += _inertia(model, at) * acceleration if at == place else 0.0
            drive = tables[at].drive
            shaft = drive.shaft_turns(asked[0]), drive.shaft_turns_s(asked[1]), torque * drive.shaft_per_joint
            gimbal.hear(player.go(*shaft))
        rows[tick] = now, middle[place] + position - gimbal.plant.position[place], gimbal.plant.X[RATE + place]
        gimbal.tick()
    return rows


def _player(model: AntennaModel, drive: str, tables: tuple[AxisTables, ...], at: int) -> Player:
    """Loops of one bandwidth for what the drive moves: its body, and what that carries."""
    gear = tables[at].drive.section.gear
    player: Player = PLAYERS[drive](tables[at].drive, _inertia(model, at) / gear**2, _BANDWIDTH_RAD_S)
    return player


def _inertia(model: AntennaModel, at: int) -> float:
    """About an axis, of its own body and of what that carries, kg m^2; near enough for loops."""
    return sum(model.number(axis, model.own_inertia_path(axis)) for axis in model.axes[at:])


def _ripple(rows: np.ndarray, seconds: float) -> float:
    rate = rows[rows[:, 0] >= seconds - _RIPPLES / _RIPPLES_HZ, 2]
    return float(np.std(rate))


def _largest(rows: np.ndarray) -> float:
    """Over whole swings, the first one, which begins from rest, left out."""
    return float(np.max(np.abs(rows[rows[:, 0] >= _PERIOD_S, 1])))


def _balanced(model: AntennaModel) -> AntennaModel:
    for axis in model.axes:
        model = model.with_numbers(axis, {f"body.cog.{k}": 0.0 for k in "xyz"})
    return model


def _travel(model: AntennaModel, axis: str) -> tuple[float, float]:
    low, high = model.number(axis, "travel.low"), model.number(axis, "travel.high")
    return (low, high) if low > -ENDLESS and high < ENDLESS else (0.0, 0.0)
