"""Fault Diagnosis Toolbox: which parts of an antenna can be told apart by its equations' structure, and which part
these logs accuse.

It knows parts, not names: a fault enters the torque of an axis, its encoder or its gyro. Each name of a part that is
accused alone gets an equal share of its probability.
"""

from __future__ import annotations

import faultdiagnosistoolbox
import numpy as np

from tests.benchmarks.naming.rivals.answers import asked, write_answer
from tests.benchmarks.naming.rivals.columns import Case, read_case

#: what can be wrong with a gyro or an encoder; every other name of a case is of a torque
PARTS = {"gyro": ("gyro_bias", "gyro_misalignment", "gyro_scale"), "encoder": ("encoder_eccentricity",)}
FAULTS = tuple(f"{part}_{k}" for part in ("torque", "encoder", "gyro") for k in (0, 1))


def model() -> faultdiagnosistoolbox.DiagnosisModel:
    """Who appears in which equation: q, v, a are unknown; u, y, w measured torque, encoder, gyro; b the base."""
    motion = [f"{letter}{k}" for k in (0, 1) for letter in "qva"]
    relations: list[object] = [[f"u{k}", "b", f"torque_{k}", *motion] for k in (0, 1)]
    relations += [["w0", "v0", "b", "gyro_0"], ["w1", "v1", "q0", "b", "gyro_1"]]
    relations += [[f"y{k}", f"q{k}", f"encoder_{k}"] for k in (0, 1)]
    for k in (0, 1):
        for rate, variable in ((f"v{k}", f"q{k}"), (f"a{k}", f"v{k}")):
            # a derivative has a name of its own, and is what the next variable is
            relations += [faultdiagnosistoolbox.DiffConstraint(f"d{variable}", variable), [f"d{variable}", rate]]
    unknown = [*motion, *(f"d{letter}{k}" for k in (0, 1) for letter in "qv")]
    measured = [f"{letter}{k}" for k in (0, 1) for letter in "uyw"]
    return faultdiagnosistoolbox.DiagnosisModel(
        {"type": "VarStruc", "x": unknown, "f": list(FAULTS), "z": [*measured, "b"], "rels": relations}, name="antenna"
    )


def signatures() -> dict[str, tuple[bool, ...]]:
    """By fault, which of four residuals it moves: torques of both axes by the encoders, gyros by the encoders."""
    antenna = model()
    sets = antenna.MSO()
    # the first four equations are torques and gyros: a residual has one of them, the rest of it is encoders
    own = [next(one for one in sets if [k for k in range(4) if k in one] == [wanted]) for wanted in range(4)]
    moved = np.asarray(antenna.FSM(own)) > 0
    return {fault: tuple(bool(hit) for hit in moved[:, FAULTS.index(fault)]) for fault in FAULTS}


def accused(case: Case, threshold: float) -> str | None:
    """The one fault that moves just the residuals that stand above `threshold` of what they are a difference of."""
    moved = [share > threshold for share in shares(case)]
    # without a gyro there are the two torques alone
    fitting = [fault for fault, pattern in signatures().items() if list(pattern[: len(moved)]) == moved]
    return fitting[0] if len(fitting) == 1 and any(moved) else None


def shares(case: Case) -> list[float]:
    """Root mean square of each residual over that of its signal, in both logs: torques, then gyros if there are any."""
    pairs = [
        (lack, log.raw[f"{axis}.{name}"], k)
        for name, of in (("torque_model", "lack"), ("rate", "rate_error"))
        for k, axis in enumerate(case.axes)
        for log in case.measured
        if (lack := getattr(log, of)) is not None
    ]
    edge = len(case.measured[0].rate) // 20
    each = [float(np.sqrt(np.mean(lack[edge:-edge, k] ** 2) / np.mean(signal[edge:-edge] ** 2)))
            for lack, signal, k in pairs]  # fmt: skip
    return [0.5 * (first + second) for first, second in zip(each[::2], each[1::2], strict=True)]


def by_structure(case: Case, knob: float) -> tuple[dict[tuple[str, str], float], dict[str, np.ndarray]]:
    """Probability by name and axis, and torque on the challenge by axis: that of the known model, it has no other."""
    torque = {axis: case.challenge.raw[f"{axis}.torque_model"] for axis in case.axes}
    fault = accused(case, knob)
    if fault is None:
        return {}, torque
    part, k = fault.split("_")
    others = [name for names in PARTS.values() for name in names]
    names = PARTS.get(part, tuple(name for name in case.about["names"] if name not in others))
    return {(name, case.axes[int(k)]): 1.0 / len(names) for name in names}, torque


def main() -> None:
    """The command line of an adapter; `--knob` is from which share of its signal on a residual counts as moved."""
    chosen = asked(0.002)
    write_answer(chosen.answer, *by_structure(read_case(chosen.case), chosen.knob))


if __name__ == "__main__":
    main()
