"""One drawn case before its sizes are set: antenna, hidden causes, motion, sensors, loop; simulates any of its logs at
given sizes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.random import Generator

from tests.blind import motion, weather
from tests.blind.antenna import COLUMNS, IX, simulate
from tests.blind.causes import Array, Cause
from tests.blind.rig import Axes, Rig

#: columns of the antenna that are torques (times whatever), and those that are inertias: both grow with the rig
_TORQUES = (
    "s2",
    "Tc",
    "Ts",
    "s0",
    "quad",
    "cog_a",
    "spring_k",
    "offset",
    "emf",
    "bump_a",
    "dead",
    "hyst_a",
    "jump_s2",
    "cross_c",
)
_TORQUES += ("sine_a", "field_a", "stop_k", "snag_a", "grease_a", "grease_p", "dwell_a")
_INERTIAS = ("rotor", "slosh_j")
_ADDED = ("Ts", "Tc", "s0", "s1", "s2")
#: numbers of the model that may be off, in the order in which their moves are drawn
MOVED = ("Tc", "Ts", "vs", "s0", "s1", "s2")
#: rows of a log that is long enough to set a cause's size by
TRIAL_S = 20.0


@dataclass(frozen=True)
class Scene:
    """Everything about a case but the sizes of its causes."""

    seed: int
    rig: Rig
    causes: tuple[Cause, ...]
    base: Array
    references: tuple[Array, ...]
    #: how often a log repeats its reference; 0 for none
    laps: int
    gains: Array
    gyro_noise: float
    torque_noise: Array
    #: K by which the joints warm up, and the time constant, s; no warming with 0
    warming: tuple[float, float]
    use_gyro: bool
    #: known numbers off by up to this share, and by which part of it each
    off: float
    moves: Array
    #: per axis, as `weather.add_wander` takes it; none for an antenna that stays as it is
    wander: tuple[tuple[float, float, float], ...] = ()

    def rows(self, scales: list[float], *, moved: bool = True) -> tuple[Array, Array, dict[str, Array]]:
        """Rows of the model's antenna, rows of the true one with every cause at its scale (0: absent), the true
        bodies.
        """
        nominal = np.zeros((2, len(COLUMNS)))
        nominal[:, IX["limit"]] = 1e9
        bodies = {a: self.rig.bodies[a].copy() for a in ("outer", "inner")}
        for a, axis in enumerate(("outer", "inner")):
            for k, v in self.rig.friction[axis].items():
                nominal[a, IX[k]] = v
        true = nominal.copy()
        true[:2, IX["limit"]] = self.rig.limits
        for cause, scale in zip(self.causes, scales, strict=True):
            if scale:
                _put(cause, scale, true, bodies, self.rig)
        if self.off and moved:
            self._move(nominal, true, bodies)
        return nominal, true, bodies

    def _move(self, nominal: Array, true: Array, bodies: dict[str, Array]) -> None:
        """Every known number off by half to all of `off`, but those that are a hidden cause by themselves."""
        far = [(c.axis, key) for c in self.causes if c.number for key in (*c.row, *c.body)]
        for a, axis in enumerate(("outer", "inner")):
            part = np.sign(self.moves[a]) * (0.5 + 0.5 * np.abs(self.moves[a])) * self.off
            for j, key in enumerate(MOVED):
                if (axis, key) not in far:
                    true[a, IX[key]] += nominal[a, IX[key]] * part[j]
            true[a, IX["Ts"]] = max(true[a, IX["Ts"]], true[a, IX["Tc"]] * 1.02)
            change = np.array([0.0 if (axis, i) in far else part[10 + i] for i in range(10)])
            moved = bodies[axis] * (1.0 + change)
            if not is_body(moved):  # moments that no body has: all six move alike
                own = 2 if axis == "outer" else 1
                moved[:6] = bodies[axis][:6] * (1.0 + change[own])
            bodies[axis] = moved

    def run(self, log: int, scales: list[float], noise_seed: int, *, trial: bool = False) -> Array:
        """The columns of `simulate` for one log, then temperatures and references; a trial is short, with the model's
        own numbers.
        """
        reference = self.references[log]
        dt = self.rig.step_s
        if self.laps:
            reference = np.concatenate([closed(reference, dt)] * self.laps)
        if trial:
            reference = reference[: round(TRIAL_S / dt)]
        n = len(reference)
        nominal, true, bodies = self.rows(scales, moved=not trial)
        true[:, IX["torque_noise"]] = self.torque_noise
        gain, tau = self.warming
        time = np.arange(n) * dt
        heat = np.tile((20.0 + (gain * (1 - np.exp(-time / tau)) + 3.0 * log if gain else 0.0 * time))[:, None], (1, 2))
        known = self.rig.bodies["outer"], self.rig.bodies["inner"]
        sensors = np.tile([self.rig.encoder_step, self.gyro_noise, 0.0], (2, 1))
        sky = self._weather(log, scales, n, trial)
        columns = simulate(self.rig.axes.value, true, nominal, bodies["outer"], bodies["inner"], *known, self.base,
        reference, heat,
                           sky, self.gains, sensors, noise_seed, dt, self.use_gyro)  # fmt: skip
        return np.column_stack([columns, heat, reference[:, :, 0]])

    def _weather(self, log: int, scales: list[float], n: int, trial: bool) -> Array:
        rng = np.random.default_rng([self.seed, 7, log])
        sky = weather.still(n)
        if self.wander and not trial:
            weather.add_wander(sky, rng, self.rig.step_s, list(self.wander))
        for cause, scale in zip(self.causes, scales, strict=True):
            if scale and "weather" in cause.row:
                vary = weather.add_dropouts if cause.name == "torque_dropouts" else weather.add_switching
                vary(sky, rng, self.rig.step_s, 0 if cause.axis == "outer" else 1, cause.row["weather"] * scale)
        return sky


def _put(cause: Cause, scale: float, true: Array, bodies: dict[str, Array], rig: Rig) -> None:
    a = 0 if cause.axis == "outer" else 1
    torque = rig.heft if rig.axes is Axes.LINEAR and not cause.number else 1.0
    inertia = 1.0 if cause.number else rig.heft
    before = true[a, IX["s0"]]
    for key, value in cause.row.items():
        if key == "weather":
            continue
        size = value * (torque if key in _TORQUES else inertia if key in _INERTIAS else 1.0)
        if key == "limit" or key in cause.scaled:
            size *= scale
        if key in _ADDED:
            true[a, IX[key]] += size
        else:
            true[a, IX[key]] = size
    if cause.name == "presliding":  # damped as before
        true[a, IX["s1"]] *= np.sqrt(true[a, IX["s0"]] / before)
    for i, value in cause.body.items():
        bodies[cause.axis][i] += value * (1.0 if cause.number else scale * (inertia if i not in (6, 7, 8) else 1.0))


def is_body(row: Array) -> bool:
    """Whether a body can have these moments and products of inertia."""
    xx, yy, zz, xy, xz, yz = row[:6]
    moments = np.linalg.eigvalsh(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]))
    return bool(moments[0] >= 0.0 and moments[0] + moments[1] >= moments[2])


def closed(reference: Array, dt: float) -> Array:
    """A lap brought back to its start so that laps join."""
    back = round(1.5 / dt)
    out = reference.copy()
    s = np.clip(np.arange(len(reference)) - (len(reference) - back), 0, back) / back
    blend = (1 - (10 * s**3 - 15 * s**4 + 6 * s**5))[:, None]
    out[:, :, 0] = reference[0, :, 0] + (reference[:, :, 0] - reference[0, :, 0]) * blend
    out[:, :, 1] = np.gradient(out[:, :, 0], dt, axis=0)
    out[:, :, 2] = np.gradient(out[:, :, 1], dt, axis=0)
    return out


_SHAPES = (("mixed", "points", "multisine"), ("points", "mixed", "multisine"))


def reference_of(log: int, seconds: float, rng: Generator, rig: Rig, inner_centre: float) -> Array:
    """(n, 2, 3): position, rate and acceleration of both axes for one log (or lap)."""
    n = round(seconds / rig.step_s)
    t = np.arange(n) * rig.step_s
    out = np.zeros((n, 2, 3))
    for a in range(2):
        if a == 0:
            fast, travel = float(rng.uniform(0.6, 1.6)), float(rng.uniform(1.0, 2.5))
        else:
            fast, travel = float(rng.uniform(0.8, 2.0)), float(rng.uniform(0.4, 0.9))
        shape = _SHAPES[log % 2][int(rng.integers(3))] if a else _SHAPES[log % 2][0 if rng.random() < 0.6 else 1]
        top_hz = float(rng.uniform(4, 14))
        shape = "few" if rig.poor_motion else shape
        out[:, a] = motion.reference(
            shape, t, rng, fast, travel, 0.0 if a == 0 else inner_centre, top_hz, min(seconds, 20.0)
        )
    return out
