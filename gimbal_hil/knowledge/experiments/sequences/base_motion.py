"""Base motion: how well both axes hold still while the base moves: the cases of tables 3.1 and 3.2, or a recorded
motion.

On the virtual antenna the experiment brings its base motion with it (`Experiment.base`); on a real one the base moves
by itself.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from firmware_protocol.errors import BadInputError
from firmware_protocol.json_object import Json
from gimbal_hil.knowledge.experiments import Experiment, Row, Signals, Step, axes_of, move_to, position_hold, step_of
from gimbal_hil.knowledge.experiments.sequences.options import SequenceOptions
from gimbal_hil.pages.plots import Drawing
from gimbal_hil.pages.report import Block, Callout, Plot, Table

DEFAULT_BASE = "3.2/4"
HOLD_S, SHORT_HOLD_S, SETTLING_S = 30.0, 6.0, 3.0
#: pairs of joint positions that are held, rad
POSES = ((0.0, 0.0), (0.0, 0.8), (0.8, 0.0))


def build(options: SequenceOptions) -> Experiment:
    """Each pose held for a while."""
    base = base_section(options.base or DEFAULT_BASE)
    steps: list[Step] = []
    for number, (outer, inner) in enumerate(POSES[:1] if options.short else POSES):
        to_pose = move_to(outer, 2.0), move_to(inner, 2.0)
        steps.append(step_of(f"to pose {number + 1}", options.rate_hz, SETTLING_S, to_pose))
        hold = (position_hold(outer), position_hold(inner))
        meaning = {
            "pose": number + 1,
            **{f"{axis}_rad": value for axis, value in options.by_axis((outer, inner)).items()},
            "base": options.base or DEFAULT_BASE,
        }
        steps.append(
            step_of(
                f"pose {number + 1}", options.rate_hz, SHORT_HOLD_S if options.short else HOLD_S, hold, meaning, True
            )
        )
    drawn = frozenset(step.name for step in steps if step.measured)
    return Experiment(
        "base_motion",
        "Holding still on a moving base",
        tuple(steps),
        measure,
        conclude,
        drawn,
        options.every or 1,
        base,
    )


def base_section(name: str) -> Json:
    """`table/case` of the thesis or a CSV file, as the `base:` section of a model; BadInputError when it is neither."""
    case = re.fullmatch(r"(3\.1|3\.2)/(\d+)", name)
    if case is not None:
        most = 5 if case[1] == "3.1" else 4
        if not 1 <= int(case[2]) <= most:
            raise BadInputError(f"base {name!r}", f"table {case[1]} has no case {case[2]}", f"1 to {most}")
        return {"motion": "case", "table": case[1], "case": int(case[2])}
    if not Path(name).is_file():
        raise BadInputError(
            f"base {name!r}", "is no case and no file", "3.1/1 to 3.1/5, 3.2/1 to 3.2/4, or a CSV file with a motion"
        )
    return {"motion": "recorded", "file": str(Path(name).resolve())}


def measure(step: Step, signals: Signals) -> Row:
    """For each axis: rms and largest position error, rms of the inertial rate, rms and largest torque; size of the base
    rate.
    """
    row: Row = {"base_rate_rad_s": float(np.sqrt(np.mean(sum(signals[f"base.{rate}"] ** 2 for rate in "pqr"))))}
    for axis in axes_of(signals):
        error = signals[f"{axis}.position"] - step.meaning[f"{axis}_rad"]
        torque = signals[f"{axis}.torque"]
        row |= {
            f"{axis}_error_rms_rad": float(np.sqrt(np.mean(error**2))),
            f"{axis}_error_max_rad": float(np.max(np.abs(error))),
            f"{axis}_inertial_rate_rms_rad_s": float(np.sqrt(np.mean(signals[f"{axis}.rate"] ** 2))),
            f"{axis}_torque_rms_nm": float(np.sqrt(np.mean(torque**2))),
            f"{axis}_torque_max_nm": float(np.max(np.abs(torque))),
        }
    return row


def conclude(rows: Sequence[Row], drawn: Mapping[str, Signals]) -> list[Block]:
    """A figure of each pose, then the table over all."""
    axes = [
        name.removesuffix("_error_rms_rad") for name in (rows[0] if rows else ()) if name.endswith("_error_rms_rad")
    ]
    worst = max((max(row[f"{axis}_error_rms_rad"] for axis in axes) for row in rows), default=0.0)
    base = rows[0]["base"] if rows else ""
    said = f"Base motion {base}: the largest rms position error is {1e3 * worst:.3f} mrad."
    header = ("Step", "Base rate [rad/s]") + tuple(
        f"{axis} {word}"
        for axis in axes
        for word in ("error rms [mrad]", "error max [mrad]", "torque rms [N m]", "torque max [N m]")
    )
    lines = []
    for row in rows:
        cells = [row["step"], f"{row['base_rate_rad_s']:.3f}"]
        for axis in axes:
            cells += [f"{1e3 * row[f'{axis}_error_{word}_rad']:.3f}" for word in ("rms", "max")]
            cells += [f"{row[f'{axis}_torque_{word}_nm']:.2f}" for word in ("rms", "max")]
        lines.append(tuple(cells))
    plots = [
        Plot(_figure(name, signals), f"{name}: position error, torque, and the base's attitude.")
        for name, signals in drawn.items()
    ]
    return [Callout(said), *plots, Table(header, lines)]


def _figure(name: str, signals: Signals) -> Drawing:
    from gimbal_hil.pages.plots import ALERT, AXIS_COLOURS, REFERENCE, SECOND, stacked, thinned

    drawn = stacked(("", "", ""), "time [s]", ("error [mrad]", "torque [N m]", "base [rad]"), 190)
    few = thinned(len(signals["time_s"]))
    time_s = (signals["time_s"] - signals["time_s"][0])[few]
    for axis, colour in zip(axes_of(signals), AXIS_COLOURS, strict=True):
        line = dict(color=colour)
        error = 1e3 * (signals[f"{axis}.position"] - signals[f"{axis}.position_ref"])
        drawn.add_scatter(x=time_s, y=error[few], name=axis, line=line, row=1)
        drawn.add_scatter(x=time_s, y=signals[f"{axis}.torque"][few], name=axis, line=line, showlegend=False, row=2)
    for angle, line in (("roll", dict(color=SECOND)), ("pitch", dict(color=REFERENCE)), ("yaw", dict(color=ALERT))):
        # roll and yaw of a case may be the same: one is dashed, so that both are seen
        line |= dict(dash="dash") if angle == "yaw" else {}
        drawn.add_scatter(x=time_s, y=np.unwrap(signals[f"base.{angle}"])[few], name=angle, line=line, row=3)
    return drawn
