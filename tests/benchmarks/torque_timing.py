"""Do the intervals of a regression hold the truth when torque and position were not logged at the same time?

A joint by exact inverse dynamics (nothing of the product in it) on fresh trajectories; its torque is logged late,
sampled, behind a low-pass, or beside positions that are refreshed every fifth row; or the joint cogs; or columns were
smoothed to both sides before they were saved.

    python -m tests.benchmarks.torque_timing --repeats 20 held late1 late5 sampled low_pass second_order refreshed
"""

from __future__ import annotations

import argparse

import numpy as np
from scipy.signal import butter, filtfilt, lfilter, savgol_filter

from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.data.signals.refreshed import on_refreshed_rows
from gimbal_hil.knowledge.identification import RigidAxisRule, fit_rigid_axis

TRUE = {"inertia": 0.02, "viscous": 0.02, "coulomb": 0.05, "offset": 0.0}
RATE_HZ, SECONDS, FINE = 500.0, 30.0, 10
STEP, NOISE = 2.0 * np.pi / 65536, 1e-3
KINDS = ("held", "late1", "late2", "late3", "late5", "sampled", "low_pass", "second_order", "refreshed", "cogging",
         "cogging_late5", "smoothed_5hz", "smoothed_10hz", "mean_50ms", "mean_100ms", "savgol", "both_5hz",
         "position_5hz", "cogging_smoothed_5hz")  # fmt: skip
#: cogging as large as the Coulomb level, drawn order
COGGING = 0.05


def logged(kind: str, seed: int) -> SignalsTable:
    """A log of one kind on a trajectory of its own."""
    random = np.random.default_rng(seed)
    n = int(SECONDS * RATE_HZ)
    time = np.arange(n) / RATE_HZ
    swing = np.array([0.9, 0.5, 0.25]) * random.uniform(0.7, 1.3, 3)
    turns = 2.0 * np.pi * np.array([0.23, 0.71, 1.9]) * random.uniform(0.7, 1.3, 3)
    phase = random.uniform(0.0, 6.28, 3)
    order = float(np.random.default_rng(seed).integers(5, 25))

    def motion(at: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        angle = np.outer(at, turns) + phase
        q = (swing * (np.sin(angle) - np.sin(phase))).sum(axis=1)
        v, a = (swing * turns * np.cos(angle)).sum(axis=1), (-swing * turns**2 * np.sin(angle)).sum(axis=1)
        x = np.clip(at, 0.0, 1.0)
        s, ds, dds = x**3 * (10 - 15 * x + 6 * x * x), 30 * x**2 * (1 - x) ** 2, 60 * x - 180 * x**2 + 120 * x**3
        return s * q, ds * q + s * v, dds * q + 2.0 * ds * v + s * a

    def torque(at: np.ndarray) -> np.ndarray:
        q, v, a = motion(at)
        cogs = COGGING * np.sin(order * q + 0.4) if kind.startswith("cogging") else 0.0
        return TRUE["inertia"] * a + TRUE["coulomb"] * np.sign(v) + TRUE["viscous"] * v + cogs

    late = float(kind.rpartition("late")[2]) / RATE_HZ if "late" in kind else 0.0
    held = torque((np.arange(n * FINE) + 0.5) / (RATE_HZ * FINE) - late).reshape(n, FINE).mean(axis=1)
    decay = np.exp(-2.0 * np.pi * 20.0 / RATE_HZ)
    column = {
        "sampled": lambda: torque(time),
        "low_pass": lambda: lfilter([1.0 - decay], [1.0, -decay], torque(time)),
        "second_order": lambda: lfilter(*butter(2, 20.0 / (0.5 * RATE_HZ)), torque(time)),
    }.get(kind, lambda: held)()
    position = np.round(motion(time)[0] / STEP) * STEP
    if kind == "refreshed":
        position = position[np.arange(n) // 5 * 5]
    if kind.startswith(("both", "position")):
        position = smoothed(position, 5.0)
    columns = {"joint.torque": _saved(kind, column + random.normal(0.0, NOISE, n)), "joint.position": position}
    return on_refreshed_rows(SignalsTable.of(("joint",), time, columns, None, f"{kind} {seed}"))


def smoothed(values: np.ndarray, hertz: float) -> np.ndarray:
    """Behind a filter of second order forwards and backwards."""
    return np.asarray(filtfilt(*butter(2, hertz / (0.5 * RATE_HZ)), values))


def _saved(kind: str, torque: np.ndarray) -> np.ndarray:
    """The torque as somebody saved it."""
    if kind.endswith("5hz") and not kind.startswith("position"):
        return smoothed(torque, 5.0)
    if kind == "smoothed_10hz":
        return smoothed(torque, 10.0)
    if kind.startswith("mean"):
        rows = 25 if kind == "mean_50ms" else 51
        return np.convolve(np.pad(torque, rows // 2, mode="edge"), np.full(rows, 1.0 / rows), "valid")
    return savgol_filter(torque, 51, 3) if kind == "savgol" else torque


def main() -> None:
    """Prints a line a kind: how many intervals hold the truth, and how far off and how wide they are."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kinds", nargs="*", default=list(KINDS))
    parser.add_argument("--repeats", type=int, default=20)
    parser.add_argument("--seed", type=int, default=5000)
    asked = parser.parse_args()
    for kind in asked.kinds:
        held = dict.fromkeys(TRUE, 0)
        error, width, late, told = [], [], [], 0
        for seed in range(asked.seed, asked.seed + asked.repeats):
            table = logged(kind, seed)
            rule = RigidAxisRule(min(20.0, 0.05 / table.period_s))
            fit = fit_rigid_axis(table.time_s, table.position("joint"), table.torque("joint"), rule)
            told += bool(fit.smoothed)
            for one in fit.estimates:
                held[one.name] += one.interval.covers(TRUE[one.name])
            viscous = next(one for one in fit.estimates if one.name == "viscous")
            error.append(viscous.fitted / TRUE["viscous"] - 1.0)
            width.append(viscous.interval.half_width / TRUE["viscous"])
            late.append(1e3 * fit.timing.late_s)
        print(
            f"{kind}: {held} of {asked.repeats}; viscous {100 * np.median(error):+.2f} %, half width "
            f"{100 * np.median(width):.2f} %; torque {np.median(late):.3f} ms late; "
            f"smoothed in {told}",
            flush=True,
        )


if __name__ == "__main__":
    main()
