"""A joint of a bench with cogging of 10 mN m and order 7, as a CSV file with columns and units of its own."""

from __future__ import annotations

from pathlib import Path

import numpy as np

INERTIA, COULOMB, VISCOUS, BRISTLE, COGGING, ORDER, PHASE = 0.02, 0.05, 0.02, 100.0, 0.010, 7.0, 0.4
STEP_S, EVERY, COUNT_RAD = 2e-4, 10, 9.6e-5


def bench_log(path: Path, swings: tuple[tuple[float, float], ...], seconds: float = 40.0) -> None:
    """A PD loop follows sines (rad, Hz); milliseconds, degrees and mN m at 500 Hz, semicolons and decimal commas."""
    t = np.arange(int(seconds / STEP_S)) * STEP_S
    reference = np.sum([size * np.sin(2.0 * np.pi * hertz * t) for size, hertz in swings], axis=0)
    slope = np.gradient(reference, STEP_S)
    q = v = z = torque = 0.0
    lines = ["t [ms];theta [deg];M [mNm];U [V]"]
    for k, wanted in enumerate(reference):
        if k % EVERY == 0:
            torque = 6.0 * (wanted - q) + 0.5 * (slope[k] - v) + 0.06 * float(np.tanh(slope[k] / 0.02))
            torque = round(torque, 4)
            shown = np.degrees(round(q / COUNT_RAD) * COUNT_RAD)
            lines.append(f"{1e3 * t[k]:.1f};{shown:.5f};{1e3 * torque:.3f};24".replace(".", ","))
        bending = v - abs(v) * z * BRISTLE / COULOMB
        z += STEP_S * bending
        friction = BRISTLE * z + 0.1 * bending + VISCOUS * v
        v += STEP_S * (torque + COGGING * float(np.sin(ORDER * q + PHASE)) - friction) / INERTIA
        q += STEP_S * v
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
