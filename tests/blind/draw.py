"""Draw a blind case from a seed: antenna, hidden causes, magnitude, trajectories, sensors, columns."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.random import Generator

from tests.blind import motion
from tests.blind.antenna import IX
from tests.blind.causes import NUMBERS, Array, Cause, catalogue, outside, wrong_number
from tests.blind.magnitude import scaled_to, torque_floors
from tests.blind.rig import Axes, Rig, rig_named
from tests.blind.scene import Scene, is_body, reference_of

#: effects that show in gyro minus encoder
SENSOR_EFFECTS = ("gyro_bias", "gyro_scale", "gyro_misalignment", "encoder_eccentricity")


class Unstable(Exception):
    """The drawn antenna's loop does not stand what is hidden in it, or no antenna can have it."""


@dataclass(frozen=True)
class Case:
    """Signals by log name, the antenna as its model states it, and the truth, which only the scorer may see."""

    measured: list[dict[str, Array]]
    holdout: list[dict[str, Array]]
    rig: Rig
    truth: dict[str, object]

    @property
    def axes(self) -> tuple[str, ...]:
        """Axis names in model and logs."""
        return self.rig.names


@dataclass(frozen=True)
class Wrong:
    """Numbers of the model that are wrong by themselves: how many, and by which share at least and at most."""

    count: int
    least: float
    most: float


def draw(
    seed: int,
    names: list[str] | None = None,
    *,
    outside_cause: bool = False,
    field_on_null: bool = False,
    off: float = 0.0,
    magnitude: float | None = None,
    rig: str = "thesis",
    duration_s: float = 45.0,
    axis: str | None = None,
    count: int = 1,
    apart: bool = False,
    wrong: Wrong | None = None,
    wander: bool = False,
    plugged_in: bool = False,
    pool: Callable[[Generator, str], list[Cause]] | None = None,
) -> Case:
    """Draw and simulate a case. `names` fixes the causes ([] is a null), `off` moves the known numbers by up to that
    share, `apart` puts one cause in each axis' torque and one in a sensor, `wander` lets friction levels and offsets
    drift, `plugged_in` makes a cause of no catalogue one that somebody has plugged in, so that it can be named. `pool`
    is another list of causes to draw from.
    """
    rng = np.random.default_rng(seed)
    late = rng.spawn(1)[0]  # what was added to the draws later has a stream of its own
    antenna = rig_named(rig, late)
    moving = antenna.axes is Axes.GIMBAL and rng.random() < 0.6
    chosen = (
        _apart(rng) if apart else _chosen(rng, antenna, names, count, pool or _pool_of(antenna, outside_cause), axis)
    )
    if plugged_in:
        chosen = [replace(c, inside=True) for c in chosen]
    if any(c.base for c in chosen):
        moving = True
    if field_on_null:
        chosen.append(next(c for c in outside(rng, str(rng.choice(("outer", "inner")))) if c.name == "random_field"))
    effects = len(chosen)
    if wrong is not None:
        chosen += _wrong_numbers(late, antenna, wrong, [(c.name, c.axis) for c in chosen])
    scene, gyro_in_table = _scene(rng, late, seed, antenna, chosen, moving, duration_s, off, wander)
    goals = [
        magnitude if magnitude is not None else float(np.exp(rng.uniform(np.log(3), np.log(30))))
        for _ in range(effects)
    ]
    if field_on_null and not outside_cause:
        goals[-1] = float(rng.uniform(0.5, 1.2))
    floors = torque_floors(scene)
    scales = scaled_to(scene, goals, floors)
    if not all(is_body(body) for body in scene.rows([s for s, _ in scales])[2].values()):
        raise Unstable(f"seed {seed}: no body has what is hidden in it")
    logs = [scene.run(i, [s for s, _ in scales], _noise_seed(seed, i)) for i in range(3)]
    if not all(np.isfinite(x).all() and np.abs(x[:, 2:4]).max() < 1e3 for x in logs):
        raise Unstable(f"seed {seed}: the loop does not stand its causes")
    tables = [_table(x, scene, gyro_in_table, rng) for x in logs]
    return Case(tables[:2], tables[2:], antenna, _truth(scene, scales, rig, logs))


def _noise_seed(seed: int, log: int) -> int:
    return (seed * 10 + log) % 2**32


def _chosen(
    rng: Generator,
    rig: Rig,
    names: list[str] | None,
    count: int,
    pool_on: Callable[[Generator, str], list[Cause]],
    axis: str | None,
) -> list[Cause]:
    axes = ("outer", "inner") if rig.axes is Axes.GIMBAL else ("outer",)
    chosen: list[Cause] = []
    for k in range(count if names is None else len(names)):
        where = axis or str(rng.choice(axes))
        pool = [
            c
            for c in pool_on(rng, where)
            if (names is None or c.name == names[k]) and (c.name, c.axis) not in [(d.name, d.axis) for d in chosen]
        ]
        chosen.append(pool[int(rng.integers(len(pool)))])
    return chosen


def _pool_of(rig: Rig, outside_cause: bool) -> Callable[[Generator, str], list[Cause]]:
    return outside if outside_cause else lambda rng, axis: catalogue(rng, axis, rig.axes.value)


def _apart(rng: Generator) -> list[Cause]:
    chosen = []
    for axis in ("outer", "inner", str(rng.choice(("outer", "inner")))):
        wanted = len(chosen) == 2
        pool = [c for c in catalogue(rng, axis, 0) if (c.name in SENSOR_EFFECTS) == wanted]
        chosen.append(pool[int(rng.integers(len(pool)))])
    return chosen


def _wrong_numbers(rng: Generator, rig: Rig, wrong: Wrong, taken: list[tuple[str, str]]) -> list[Cause]:
    pool = [(name, axis) for axis in ("outer", "inner") for name in NUMBERS if (name, axis) not in taken]
    found = []
    for i in rng.choice(len(pool), wrong.count, replace=False):
        name, axis = pool[int(i)]
        change = float(rng.uniform(wrong.least, wrong.most) * rng.choice([-1.0, 1.0]))
        friction, body = rig.friction[axis], rig.bodies[axis]
        cause = wrong_number(name, axis, rig.axes.value, change, friction, body)
        moved = body + np.array([cause.body.get(k, 0.0) for k in range(10)])
        found.append(
            cause if is_body(moved) else wrong_number(name, axis, rig.axes.value, -abs(change), friction, body)
        )
    return found


def _scene(
    rng: Generator,
    late: Generator,
    seed: int,
    rig: Rig,
    chosen: list[Cause],
    moving: bool,
    duration_s: float,
    off: float,
    wander: bool,
) -> tuple[Scene, bool]:
    """The scene, and whether the gyro stands in the logs."""
    gimbal = rig.axes is Axes.GIMBAL
    base = motion.base_motion(rng, moving, tilted=gimbal and rng.random() < 0.4)
    repeats = bool(rng.random() < 0.5) and rig.lengths == (1.0, 1.0, 1.0)
    laps = int(rng.integers(3, 5))
    lap_s = duration_s / laps if repeats else duration_s
    gyro_in_table = (rng.random() < 0.8 or any(c.name in SENSOR_EFFECTS for c in chosen)) and rig.has_gyro
    inner_centre = float(rng.uniform(0.2, 0.6))
    stiff = rng.uniform(0.6, 1.4, 2) * rig.heft * (0.5 if rig.step_s > 1e-3 else 1.0)
    feed = 0.5 * rig.heft, 0.07 * rig.heft
    gains = np.zeros((2, 5))
    gains[0] = [rng.uniform(5, 12), 35 * stiff[0], 200 * stiff[0], feed[0] * rng.uniform(0, 1), rig.limits[0]]
    gains[1] = [rng.uniform(6, 14), 5.0 * stiff[1], 35 * stiff[1], feed[1] * rng.uniform(0, 1), rig.limits[1]]
    gyro_noise = float(10 ** rng.uniform(-4, -3.2))
    torque_noise = rng.uniform(0.5, 4.0) * np.array([2e-3, 8e-4]) * (rig.heft if rig.axes is Axes.LINEAR else 1.0)
    warming = float(rng.uniform(8, 25)), float(rng.uniform(15, 40))
    warm = rng.random() < 0.5 or any(c.name == "temperature_viscosity" for c in chosen)
    coarse = rig.encoder_step > 1e-5 and gimbal  # differences of a coarse encoder are no rate to close a loop on
    use_gyro = bool(rng.random() < 0.4 and not moving) or coarse
    references = tuple(reference_of(i, lap_s * rig.lengths[i], rng, rig, inner_centre) for i in range(3))
    moves = rng.uniform(-1, 1, (2, 40))
    shapes = tuple(_wander(late, friction["Tc"]) for friction in rig.friction.values())
    scene = Scene(
        seed,
        rig,
        tuple(chosen),
        base,
        references,
        laps if repeats else 0,
        gains,
        gyro_noise,
        torque_noise,
        warming if warm else (0.0, 1.0),
        use_gyro,
        off,
        moves,
        shapes if wander else (),
    )
    return scene, gyro_in_table


def _wander(rng: Generator, coulomb: float) -> tuple[float, float, float]:
    """Share of the friction level that wanders, its time constant in s, and how far the torque's offset drifts."""
    time_constant_s = float(np.exp(rng.uniform(np.log(0.5), np.log(20.0))))
    return float(rng.uniform(0.002, 0.01)), time_constant_s, float(rng.uniform(0.001, 0.005)) * coulomb


_COLUMN_PATH = {
    "s2": "viscous",
    "Tc": "coulomb",
    "Ts": "breakaway",
    "vs": "stribeck_velocity",
    "s0": "sigma0",
    "s1": "sigma1",
}
_BODY_PATH = (
    "inertia.xx",
    "inertia.yy",
    "inertia.zz",
    "inertia.xy",
    "inertia.xz",
    "inertia.yz",
    "cog.x",
    "cog.y",
    "cog.z",
    "mass",
)


def _akin(cause: Cause, logs: list[Array]) -> tuple[str, ...]:
    """A dead zone under a torque that hardly ever changes its sign is an offset, on that data."""
    if cause.name == "torque_dead_zone":
        pushed = np.concatenate([x[:, 0 if cause.axis == "outer" else 1] for x in logs]) > 0.0
        return ("torque_offset",) if min(pushed.mean(), 1.0 - pushed.mean()) < 0.05 else ()
    return cause.akin


def _truth(scene: Scene, scales: list[tuple[float, float]], rig: str, logs: list[Array]) -> dict[str, object]:
    nominal, true, bodies = scene.rows([s for s, _ in scales])
    called = dict(zip(("outer", "inner"), scene.rig.names, strict=False))
    numbers = []
    for a, axis in enumerate(called):
        for column, path in _COLUMN_PATH.items():
            numbers.append((axis, f"friction.{path}", nominal[a, IX[column]], true[a, IX[column]]))
        for i, path in enumerate(_BODY_PATH):
            numbers.append((axis, f"body.{path}", scene.rig.bodies[axis][i], bodies[axis][i]))
    causes = [
        {
            "name": c.name,
            "axis": called[c.axis],
            "inside": c.inside,
            "number": c.number,
            "magnitude_floors": m,
            "akin": list(_akin(c, logs)),
            "row": {k: float(true[0 if c.axis == "outer" else 1, IX[k]]) for k in c.row if k in IX},
            "body": {str(k): float(bodies[c.axis][k]) for k in c.body},
        }
        for c, (_, m) in zip(scene.causes, scales, strict=True)
    ]
    return {
        "seed": scene.seed,
        "causes": causes,
        "moving": bool(np.any(scene.base[:, 1] != 0.0)),
        "off": scene.off,
        "rig": rig,
        "repeats": scene.laps > 0,
        "wander": [list(w) for w in scene.wander],
        # a model without a bristle lacks one, whatever else is hidden
        "lacking": [] if scene.rig.states_bristle else [["presliding", name] for name in scene.rig.names],
        "off_numbers": [
            {"axis": called[a], "path": p, "model": float(m), "true": float(t)} for a, p, m, t in numbers if m != t
        ],
    }


def _table(x: Array, scene: Scene, gyro: bool, rng: Generator) -> dict[str, Array]:
    """docs/reference/signals-table.md columns, optional ones left out at random."""
    out: dict[str, Array] = {
        "time_s": np.round(np.arange(len(x)) * scene.rig.step_s + float(rng.choice([0.0, 12.5])), 9)
    }
    refs = rng.random() < 0.5
    for a, axis in enumerate(scene.rig.names):
        out[f"{axis}.torque"], out[f"{axis}.position"] = x[:, a], x[:, 2 + a]
        if gyro:
            out[f"{axis}.rate"] = x[:, 4 + a]
        if scene.warming[0]:
            out[f"{axis}.temperature"] = x[:, 18 + a]
        if refs:
            out[f"{axis}.position_ref"] = x[:, 20 + a]
    if scene.base.any():
        for j, name in enumerate(("roll", "pitch", "yaw", "p", "q", "r")):
            out[f"base.{name}"] = x[:, 6 + j]
    if scene.laps:
        out["repeat"] = np.minimum(np.arange(len(x)) // (len(x) // scene.laps), scene.laps - 1)
    return out
