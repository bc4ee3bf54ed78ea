"""The plant as Python sees it: a model's arrays, stepped by compiled code."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from firmware_protocol.compiling import entry_point
from sim_backend import layout
from sim_backend.layout import APPLIED, AXES, BODY_RATE, FRICTION, POSITION, RATE, STEPS, STEPS_PER_TICK
from sim_backend.model import AntennaModel, plant_arrays
from sim_backend.rigid_body import equations_of_motion
from sim_backend.step import advance, begin_tick, plant_tick, read_encoder, read_gyro, true_rates


@dataclass(frozen=True)
class Simulation:
    """An open-loop simulation, n rows at the tick rate: row k is sampled at t_k, its torque acts over [t_k, t_k+1)."""

    #: joint position (rad or m) and rate (rad/s or m/s), true values, (n, axes)
    position: np.ndarray
    rate: np.ndarray
    #: sensor readings, (n, axes)
    encoder: np.ndarray
    gyro: np.ndarray
    #: torque at the joint and opposing friction, means over the last step before t_k, (n, axes)
    applied: np.ndarray
    friction: np.ndarray


@entry_point
def run_open_loop(P: np.ndarray, K: np.ndarray, X: np.ndarray, torque: np.ndarray, rows: np.ndarray) -> None:
    """Simulate torque (n, 2), N m, from state X; fills rows (n, 12): position, rate, encoder, gyro, applied, friction,
    two each.
    """
    for k in range(torque.shape[0]):
        true_rates(P, K, X)
        tick = int(X[STEPS]) // K[STEPS_PER_TICK]
        for axis in range(K[AXES]):
            rows[k, axis] = X[POSITION + axis]
            rows[k, 2 + axis] = X[RATE + axis]
            rows[k, 4 + axis] = read_encoder(P, K, X, axis, tick)
            rows[k, 6 + axis] = read_gyro(P, K, X, axis, tick)
            rows[k, 8 + axis] = X[APPLIED + axis]
            rows[k, 10 + axis] = X[FRICTION + axis]
        plant_tick(P, K, X, (torque[k, 0], torque[k, 1]))


@entry_point
def run_steps(
    P: np.ndarray, K: np.ndarray, X: np.ndarray, torque_outer: float, torque_inner: float, steps: int
) -> None:
    """Advance by plant steps under constant torques (N m)."""
    done = 0
    while done < steps:
        begin_tick(P, K, X)
        stretch = min(K[STEPS_PER_TICK], steps - done)
        advance(P, K, X, (torque_outer, torque_inner), stretch)
        done += stretch


@entry_point
def joint_accelerations(
    P: np.ndarray,
    K: np.ndarray,
    q: np.ndarray,
    v: np.ndarray,
    torque: np.ndarray,
    gravity: np.ndarray,
    rate: np.ndarray,
    acceleration: np.ndarray,
) -> np.ndarray:
    """Joint accelerations (2,) of the rigid body alone for net joint torques and a base state given in base axes."""
    base = (
        (gravity[0], gravity[1], gravity[2]),
        (rate[0], rate[1], rate[2]),
        (acceleration[0], acceleration[1], acceleration[2]),
    )
    mass, bias, _, _, _ = equations_of_motion(P, K, (q[0], q[1]), (v[0], v[1]), base)
    b0, b1 = torque[0] + bias[0], torque[1] + bias[1]
    determinant = mass[0] * mass[2] - mass[1] * mass[1]
    return np.array([(mass[2] * b0 - mass[1] * b1) / determinant, (mass[0] * b1 - mass[1] * b0) / determinant])


class Plant:
    """A simulated antenna (or axis) without its firmware: open-loop torque in, motion and sensor readings out."""

    def __init__(self, model: AntennaModel, rate_hz: float = 1000.0, seed: int = 0) -> None:
        self.model, self.rate_hz = model, rate_hz
        arrays = plant_arrays(model, rate_hz, seed)
        self.P, self.K, self.X = arrays.P, arrays.K, arrays.X

    def run(self, torque: np.ndarray) -> Simulation:
        """Simulate commanded torques (n, axes) in N m, one row a tick, from the present state on."""
        given = np.zeros((len(torque), layout.MAX_AXES))
        axes = len(self.model.axes)
        given[:, :axes] = torque
        rows = np.zeros((len(torque), 12))
        run_open_loop(self.P, self.K, self.X, given, rows)
        return Simulation(*(rows[:, i : i + axes].copy() for i in range(0, 12, 2)))

    @property
    def position(self) -> np.ndarray:
        """Joint positions now, (axes,)."""
        return self.X[POSITION : POSITION + len(self.model.axes)].copy()

    @property
    def body_rates(self) -> np.ndarray:
        """Inertial body rates as last computed, (2, 3) rad/s, each in its body's axes."""
        return self.X[BODY_RATE : BODY_RATE + 6].reshape(2, 3).copy()
