"""MuJoCo's system identification: structures of its own model, fitted by its optimiser, added while BIC falls.

The antenna stands as two hinges on a base that turns; joints, bodies and actuators have the numbers that MuJoCo has for
them, and nothing else can be named. Torque is compared by inverse dynamics: what a structure changes comes on top of
what the known model says, so that MuJoCo need not know its friction.
"""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import dataclass

import mujoco
import numpy as np
from mujoco import sysid

from tests.benchmarks.naming.rivals.answers import EVERY, asked, write_answer
from tests.benchmarks.naming.rivals.columns import Case, Log, own_turning, read_case

Array = np.ndarray
#: rows of a fit are thinner than for a regression: each is an inverse dynamics of its own
THINNED = 2 * EVERY
MOST = 4
_JOINTS = ("viscous", "coulomb", "cable_spring", "inertia")
_BODIES = ("static_unbalance", "dynamic_unbalance")
_ACTUATORS = ("torque_gain", "torque_offset", "transport_delay")
_GYROS = ("gyro_bias", "gyro_scale")
NAMES = (*_JOINTS, *_BODIES, *_ACTUATORS, *_GYROS)
#: of changes that would leave no body, or none that MuJoCo takes
_BOUNDS = {"inertia": 0.4, "dynamic_unbalance": 2.0, "static_unbalance": 0.5, "coulomb": 1.0, "torque_gain": 0.9}
Structure = tuple[tuple[str, int], ...]


@dataclass(frozen=True)
class Rows:
    """Rows of one or more logs: motion as MuJoCo has it, and what was measured, (n, axes) each."""

    qpos: Array
    qvel: Array
    qacc: Array
    model: Array
    slope: Array
    torque: Array
    gyro_error: Array
    turning: Array

    @classmethod
    def of(cls, case: Case, log: Log, every: int) -> Rows:
        """Of a log, its ends cut off where it is thinned."""
        step_s, raw = case.about["step_s"], log.raw
        model = np.stack([raw[f"{axis}.torque_model"] for axis in case.axes], axis=1)
        torque = model if log.lack is None else model + log.lack
        base = np.stack([raw.get(f"base.{name}", np.zeros(len(model))) for name in "pqr"], axis=1)
        roll, pitch = (raw.get(f"base.{name}", np.zeros(len(model))) for name in ("roll", "pitch"))
        kept = slice(len(model) // 20, -(len(model) // 20), every) if every > 1 else slice(None)
        columns = (
            np.column_stack([_attitude(roll, pitch), log.position]),
            np.column_stack([base, log.rate]),
            np.column_stack([np.gradient(base, step_s, axis=0), log.acceleration]),
            model, np.gradient(torque, step_s, axis=0), torque,
            np.zeros_like(model) if log.rate_error is None else log.rate_error,
            np.stack([own_turning(log, k) for k in range(2)], axis=1),
        )  # fmt: skip
        return cls(*(column[kept] for column in columns))

    def joined(self, other: Rows) -> Rows:
        """These rows, then the others."""
        return Rows(*(np.concatenate([getattr(self, key), getattr(other, key)]) for key in vars(self)))


def _attitude(roll: Array, pitch: Array) -> Array:
    """Unit quaternion (n, 4) of roll after pitch; heading turns nothing."""
    cr, sr, cp, sp = np.cos(roll / 2), np.sin(roll / 2), np.cos(pitch / 2), np.sin(pitch / 2)
    return np.stack([cp * cr, cp * sr, sp * cr, -sp * sr], axis=1)


def antenna(about: dict) -> mujoco.MjSpec:
    """The known model without its friction, which stands in the torque that the case states."""
    spec = mujoco.MjSpec()
    spec.option.gravity = [0.0, 0.0, -9.81]
    spec.compiler.balanceinertia = True
    parent = spec.worldbody.add_body(name="base", mass=1.0, inertia=[1.0, 1.0, 1.0], explicitinertial=True)
    parent.add_joint(type=mujoco.mjtJoint.mjJNT_BALL)
    for name, axis in zip(about["axes"], ([0, 0, 1], [0, 1, 0]), strict=True):
        row = np.array(about["bodies"][name])
        parent = parent.add_body(name=name, explicitinertial=True)
        parent.mass, parent.ipos = row[9], row[6:9]
        parent.fullinertia = row[:6] - _about_pivot(row[9], row[6:9])
        joint = parent.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_HINGE, axis=axis)
        # only changes count: a number that MuJoCo wants positive starts high enough to be able to fall
        law = about["friction"][name]
        joint.armature, joint.damping[0], joint.frictionloss = 0.5 * row[2], 20.0 * law["s2"], 2.0 * law["Tc"]
        joint.stiffness[0] = 20.0 * law["Tc"]
    return spec


def _about_pivot(mass: float, centre: Array) -> Array:
    """What a body's mass adds to xx yy zz xy xz yz about a point that is `centre` away from its centre of mass."""
    x, y, z = centre
    return mass * np.array([y * y + z * z, x * x + z * z, x * x + y * y, -x * y, -x * z, -y * z])


def parameters(case: Case, structure: Structure) -> sysid.ParameterDict:
    """Numbers of a structure, all of them changes, one where as large as what the model has."""
    found = sysid.ParameterDict()
    for name, k in structure:
        zero = np.zeros(2 if name in (*_BODIES, "cable_spring") else 1)
        bound = zero + _BOUNDS.get(name, 10.0)
        found.add(sysid.Parameter(f"{name}.{k}", zero, -bound, bound, modifier=_modifier(case, name, k)))
    return found


def _modifier(case: Case, name: str, k: int) -> Callable[[mujoco.MjSpec, sysid.Parameter], None]:
    """What a number does to MuJoCo's model; those of actuators and gyros do nothing to it."""
    axis = case.axes[k]
    law, row, inertia = case.about["friction"][axis], case.about["bodies"][axis], case.about["inertia"][k]

    def modify(spec: mujoco.MjSpec, parameter: sysid.Parameter) -> None:
        joint, body, value = spec.joint(axis), spec.body(axis), parameter.value
        if name == "viscous":
            joint.damping[0] += law["s2"] * value[0]
        elif name == "coulomb":
            joint.frictionloss += law["Tc"] * value[0]
        elif name == "cable_spring":
            joint.stiffness[0] += law["Tc"] * value[0]
        elif name == "inertia":
            joint.armature += inertia * value[0]
        elif name == "static_unbalance":
            body.ipos[list((0, 1) if k == 0 else (0, 2))] += 0.1 * value
        elif name == "dynamic_unbalance":
            body.fullinertia[list((4, 5) if k == 0 else (3, 5))] += 0.1 * row[2] * value

    return modify


def _inverse(model: mujoco.MjModel, rows: Rows) -> Array:
    """Torque of both hinges, (n, 2)."""
    data, found = mujoco.MjData(model), np.empty((len(rows.qpos), 2))
    for k, (qpos, qvel, qacc) in enumerate(zip(rows.qpos, rows.qvel, rows.qacc, strict=True)):
        data.qpos, data.qvel, data.qacc = qpos, qvel, qacc
        mujoco.mj_inverse(model, data)
        found[k] = data.qfrc_inverse[3:]
    return found


class Search:
    """A case's equations, and how well a structure does on them."""

    def __init__(self, case: Case, independent: float) -> None:
        first, second = (Rows.of(case, log, THINNED) for log in case.measured)
        self.case, self.rows = case, first.joined(second)
        self.known = _inverse(antenna(case.about).compile(), self.rows)
        # rows are counted as those of the regressions
        self.count = len(self.rows.torque) * THINNED / EVERY / independent
        self.size = np.sqrt(np.mean(self._rest(sysid.ParameterDict()) ** 2, axis=0)) + 1e-12

    def predicted(self, numbers: sysid.ParameterDict, rows: Rows, known: Array) -> tuple[Array, Array]:
        """Torque and gyro error that the model with these numbers says, (n, axes) each."""
        model = sysid.apply_param_modifiers(numbers, antenna(self.case.about))
        torque, error = rows.model + _inverse(model, rows) - known, np.zeros_like(rows.model)
        for key, parameter in numbers.items():
            (name, k), value = key.split("."), parameter.value
            k, level = int(k), self.case.about["friction"][self.case.axes[int(k)]]["Tc"]
            if name in ("torque_offset", "cable_spring"):
                torque[:, k] += level * value[-1]
            elif name == "torque_gain":
                torque[:, k] /= 1.0 + value[0]
            elif name == "transport_delay":
                torque[:, k] += rows.slope[:, k] * 0.01 * value[0]
            elif name == "gyro_bias":
                error[:, k] += 0.01 * value[0]
            elif name == "gyro_scale":
                error[:, k] += rows.turning[:, k] * value[0]
        return torque, error

    def _rest(self, numbers: sysid.ParameterDict) -> Array:
        torque, error = self.predicted(numbers, self.rows, self.known)
        return np.column_stack([self.rows.torque - torque, self.rows.gyro_error - error])

    def fitted(self, structure: Structure) -> tuple[float, sysid.ParameterDict]:
        """BIC of a structure and its numbers."""

        def residual(x: Array, numbers: sysid.ParameterDict) -> tuple[list[Array], list, list]:
            found = []
            for point in np.reshape(x, (len(x), -1)).T:
                numbers.update_from_vector(point)
                found.append(np.ravel(self._rest(numbers) / self.size))
            return [np.stack(found, axis=1) if x.ndim > 1 else found[0]], [], []

        numbers = parameters(self.case, structure)
        if structure:
            # nearly linear: two or three steps; by default a hundred more follow that change nothing
            quick = {"max_iters": 4, "xtol": 1e-3, "gtol": 1e-2, "mu_factor": 10.0}
            numbers, _ = sysid.optimize(numbers, residual, verbose=False, output=io.StringIO(), **quick)
        squares = np.mean(self._rest(numbers) ** 2, axis=0) + 1e-24
        return self.count * float(np.sum(np.log(squares))) + numbers.size * np.log(self.count), numbers


def by_structures(case: Case, knob: float) -> tuple[dict[tuple[str, str], float], dict[str, Array]]:
    """Probability by name and axis, and torque on the challenge by axis."""
    search = Search(case, knob)
    chosen, told = (), {}
    best, numbers = search.fitted(chosen)
    while len(chosen) < MOST:
        left = [(name, k) for k in range(2) for name in NAMES if (name, k) not in chosen]
        trials = {one: search.fitted((*chosen, one)) for one in left}
        one = min(trials, key=lambda one: trials[one][0])
        if trials[one][0] >= best:
            break
        # Schwarz, as for the regression
        weights = sum(np.exp(-0.5 * (value - trials[one][0])) for value, _ in trials.values())
        told[one[0], case.axes[one[1]]] = 1.0 / (weights + np.exp(-0.5 * (best - trials[one][0])))
        chosen, (best, numbers) = (*chosen, one), trials[one]
    rows = Rows.of(case, case.challenge, 1)
    torque, _ = search.predicted(numbers, rows, _inverse(antenna(case.about).compile(), rows))
    return told, {axis: torque[:, k] for k, axis in enumerate(case.axes)}


def main() -> None:
    """The command line of an adapter; `--knob` is how many rows count as one."""
    chosen = asked(400.0)
    write_answer(chosen.answer, *by_structures(read_case(chosen.case), chosen.knob))


if __name__ == "__main__":
    main()
