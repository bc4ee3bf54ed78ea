"""From a model to the arrays that the compiled plant works on."""

from __future__ import annotations

import csv
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from firmware_protocol.compiling import interpreted
from firmware_protocol.elementary import sine_cosine
from firmware_protocol.errors import BadInputError
from sim_backend import layout
from sim_backend.base_motion import gravity_at
from sim_backend.effects import Hook, effects_at
from sim_backend.friction_in_force import derive_friction
from sim_backend.layout import BaseKind, GravityReading, PlantKind
from sim_backend.model.file import Angles, BaseMotionKind, BaseSection, ModelKind
from sim_backend.model.model import AntennaModel
from sim_backend.model.numbers import AXIS_NUMBERS, SlotBase, gyro_filter
from sim_backend.stribeck_expansion import put_bump_table
from sim_backend.thesis_slips import Slip

_KINDS = {ModelKind.GIMBAL: PlantKind.GIMBAL, ModelKind.ROTARY: PlantKind.ROTARY, ModelKind.LINEAR: PlantKind.LINEAR}
_FRICTION_SLOTS = (layout.TS, layout.TC, layout.VS, layout.SIGMA0, layout.SIGMA1, layout.SIGMA2, layout.DELTA)
#: deg/s about x, y, z of the base: tables 3.1 and 3.2 of the thesis
THESIS_BASE_CASES: dict[str, tuple[tuple[float, float, float], ...]] = {
    "3.1": ((0, 0, 0), (30, 30, 30), (30, 60, 60), (60, 60, 60), (60, 75, 85)),
    "3.2": ((0, 0, 0), (5, 5, 5), (10, 10, 10), (15, 15, 15)),
}


@dataclass(frozen=True)
class PlantArrays:
    """Parameters P, structure K and initial state X of a plant; X may be copied to start again."""

    P: np.ndarray
    K: np.ndarray
    X: np.ndarray


def plant_arrays(model: AntennaModel, rate_hz: float = 1000.0, seed: int = 0) -> PlantArrays:
    """Arrays for a model sampled at `rate_hz`, noise from `seed`; BadInputError when the tick is no whole number of
    plant steps.
    """
    steps = 1.0 / (rate_hz * model.file.plant_step_s)
    if abs(steps - round(steps)) > 1e-6 or round(steps) < 1:
        raise BadInputError(
            f"{model.where}: plant_step_s",
            f"{model.file.plant_step_s:g} s does not divide a tick of {1.0 / rate_hz:g} s",
            "a whole number of steps",
        )
    P = np.zeros(layout.P_SIZE)
    K = np.zeros(layout.K_SIZE, dtype=np.int64)
    P[layout.STEP_S], P[layout.GRAVITY_M_S2], P[layout.INCLINE_SIN] = (
        (1.0 / rate_hz) / round(steps),
        model.file.gravity_m_s2,
        model.file.incline_sine,
    )
    K[layout.KIND], K[layout.AXES] = _KINDS[model.kind], len(model.axes)
    K[layout.GRAVITY_READING] = GravityReading[model.file.gravity_reading.upper()]
    K[layout.STEPS_PER_TICK], K[layout.SEED] = round(steps), seed & 0x7FFFFFFF
    K[layout.SLIPS] = int(_slips(model))
    for index, axis in enumerate(model.axes):
        _fill_axis(P, model, index, axis)
    K[layout.TEMPERATURE_KNOTS] = len(next(iter(model.friction_over_temperature.values()), ()))
    states, programs = _place_effects(P, K, model)
    P = np.concatenate([P, programs])
    P = _place_base(P, K, model.file.base, model.where)
    X = np.zeros(layout.EFFECT_STATES + states)
    # cosines of the positions zero that stand there
    X[layout.EXPANSION + 2 : layout.EXPANSION + layout.MAX_AXES * layout.EXPANSION_SIZE : layout.EXPANSION_SIZE] = 1.0
    for index in range(len(model.axes)):
        _start_axis(P, K, X, index)
    return PlantArrays(P, K, X)


def _slips(model: AntennaModel) -> Slip:
    slips = Slip.NONE
    for i, name in enumerate(model.file.thesis_slips):
        if name.upper() not in Slip.__members__:
            raise BadInputError(
                f"{model.where}: thesis_slips.{i}",
                f"no slip {name!r}",
                "one of " + ", ".join(m.lower() for m in Slip.__members__),
            )
        slips |= Slip[name.upper()]
    return slips


def lag_decay(time_constant_s: float, step_s: float) -> tuple[float, float]:
    """exp(-h / tau) of a first-order lag and its mean over a step; zeros where there is no lag."""
    if time_constant_s <= 0.0:
        return 0.0, 0.0
    decay = math.exp(-step_s / time_constant_s)
    return decay, -math.expm1(-step_s / time_constant_s) * time_constant_s / step_s


def _fill_axis(P: np.ndarray, model: AntennaModel, index: int, axis: str) -> None:
    block = layout.axis_block(index)
    first = {
        SlotBase.AXIS: block,
        SlotBase.INERTIA: (layout.INERTIA_OUTER, layout.INERTIA_INNER)[index],
        SlotBase.COG: (layout.COG_OUTER, layout.COG_INNER)[index],
        SlotBase.MASS: (layout.MASS_OUTER, layout.MASS_INNER)[index],
    }
    for number in AXIS_NUMBERS:
        if number.block is not SlotBase.BUILD:
            P[first[number.block] + number.slot] = model.number(axis, number.path)
    put_bump_table(P, index, model.number(axis, "friction.shape"))
    time_constant = model.number(axis, "actuator.time_constant")
    P[block + layout.LAG_DECAY], P[block + layout.LAG_MEAN] = lag_decay(time_constant, P[layout.STEP_S])
    bandwidth = model.number(axis, "gyro.bandwidth")
    if bandwidth > 0.0:
        P[block + layout.GYRO_FILTER] = 1.0
        P[block + layout.GYRO_A11 : block + layout.GYRO_B2 + 1] = gyro_filter(
            bandwidth, model.number(axis, "gyro.damping"), P[layout.STEP_S]
        )
    for i, row in enumerate(model.friction_over_temperature.get(axis, ())):
        knot = layout.KNOTS + (index * layout.MAX_KNOTS + i) * layout.KNOT_SIZE
        P[knot] = row[0]
        # file order (FRICTION_ROW) to slot order
        for value, slot in zip(row[1:], _FRICTION_SLOTS, strict=True):
            P[knot + 1 + slot] = value


def _place_effects(P: np.ndarray, K: np.ndarray, model: AntennaModel) -> tuple[int, np.ndarray]:
    """Write the hook effects into K and P; answers how many effect states X needs, and the programs of the model's own
    laws, which go behind P as it is.
    """
    present = [entry for entry in model.effects if not entry.effect.is_number]
    if len(present) > layout.MAX_INSTANCES:
        raise BadInputError(f"{model.where}: effects", f"{len(present)} effects", f"at most {layout.MAX_INSTANCES}")
    states = 0
    programs: list[float] = []
    listed = layout.HOOK_LISTS
    K[layout.INSTANCES] = len(present)
    for hook in Hook:
        codes = [effect.name for effect in effects_at(hook)]
        members = sorted(
            (i for i, e in enumerate(present) if e.effect.hook == hook), key=lambda i: (present[i].effect.rank, i)
        )
        K[layout.HOOK_FIRST + hook], K[layout.HOOK_COUNT + hook] = listed, len(members)
        for i in members:
            entry = present[i]
            k = layout.INSTANCE + layout.INSTANCE_SIZE * i
            o = layout.EFFECT_PARAMETERS + layout.PARAMETERS_PER_INSTANCE * i
            K[k + layout.CODE], K[k + layout.AXIS] = codes.index(entry.effect.name), model.axes.index(entry.axis)
            K[k + layout.PARAMETERS], K[k + layout.STATES] = o, layout.EFFECT_STATES + states
            P[o : o + len(entry.parameters)] = entry.parameters
            if entry.law is not None:
                P[o : o + 3] = len(P) + len(programs), entry.law.operations, model.axes.index(entry.axis)
                programs += entry.law.program
            states += entry.states
            K[listed] = i
            listed += 1
    return states, np.array(programs)


def _place_base(P: np.ndarray, K: np.ndarray, base: BaseSection, where: str) -> np.ndarray:
    def three(angles: Angles) -> tuple[float, float, float]:
        return angles.roll, angles.pitch, angles.yaw

    P[layout.BASE_ATTITUDE : layout.BASE_ATTITUDE + 3] = three(base.attitude_rad)
    P[layout.INS_AGE_S] = base.ins_age_s
    turn = interpreted(sine_cosine)
    P[layout.FIXED_GRAVITY : layout.FIXED_GRAVITY + 3] = interpreted(gravity_at)(
        P[layout.GRAVITY_M_S2], turn(base.attitude_rad.roll), turn(base.attitude_rad.pitch)
    )
    if base.motion is BaseMotionKind.CONSTANT_RATE:
        K[layout.BASE_KIND] = BaseKind.CONSTANT_RATE
        P[layout.BASE_RATE : layout.BASE_RATE + 3] = base.rate_rad_s.p, base.rate_rad_s.q, base.rate_rad_s.r
    elif base.motion is BaseMotionKind.CASE:
        cases = THESIS_BASE_CASES.get(base.table or "", ())
        if base.case is None or not 1 <= base.case <= len(cases):
            raise BadInputError(
                f"{where}: base.case",
                f"no case {base.case} in table {base.table}",
                "table 3.1 with case 1-5, or 3.2 with case 1-4",
            )
        K[layout.BASE_KIND] = BaseKind.CONSTANT_RATE
        P[layout.BASE_RATE : layout.BASE_RATE + 3] = np.deg2rad(cases[base.case - 1])
    elif base.motion is BaseMotionKind.SINUSOID:
        K[layout.BASE_KIND] = BaseKind.SINUSOID
        P[layout.BASE_AMPLITUDE : layout.BASE_AMPLITUDE + 3] = three(base.amplitude_rad)
        P[layout.BASE_FREQUENCY : layout.BASE_FREQUENCY + 3] = three(base.frequency_hz)
        P[layout.BASE_PHASE : layout.BASE_PHASE + 3] = three(base.phase_rad)
    elif base.motion is BaseMotionKind.RECORDED:
        rows, period_s = _recorded(base, where)
        K[layout.BASE_KIND], K[layout.BASE_ROWS], K[layout.BASE_TABLE] = BaseKind.RECORDED, len(rows), len(P)
        P[layout.BASE_ROW_S] = period_s
        return np.concatenate([P, rows.ravel()])
    return P


#: columns of a recorded base motion that may be absent: acceleration of the pivot in base axes, m/s^2
_PIVOT = ("ax", "ay", "az")


def _recorded(base: BaseSection, where: str) -> tuple[np.ndarray, float]:
    if base.file is None:
        raise BadInputError(f"{where}: base.file", "is missing", "a CSV file with the columns time_s, roll, pitch, yaw")
    path = Path(where).parent / base.file
    try:
        with path.open(newline="") as handle:
            rows = list(csv.DictReader(handle))
        pushed = bool(rows) and any(name in rows[0] for name in _PIVOT)
        names = ("time_s", "roll", "pitch", "yaw", *(_PIVOT if pushed else ()))
        table = [[float(row[name]) for name in names] for row in rows]
    except FileNotFoundError:
        raise BadInputError(str(path), "no such file", "a recorded base motion") from None
    except (KeyError, ValueError, TypeError) as error:
        raise BadInputError(
            str(path),
            f"cannot be read: {error}",
            "numbers in the columns time_s, roll, pitch, yaw, and ax, ay, az where the pivot accelerates",
        ) from None
    data = np.array(table)
    if len(data) < 4:
        raise BadInputError(str(path), f"{len(data)} rows", "at least four")
    spacing = np.diff(data[:, 0])
    if np.any(spacing <= 0.0) or np.ptp(spacing) > 0.05 * spacing.mean():
        raise BadInputError(f"{path}: time_s", "rows are not equally spaced", "a constant rate")
    period_s = float(spacing.mean())
    return base_rows(data[:, 1:4], data[:, 4:7] if pushed else np.zeros((len(data), 3)), period_s), period_s


def base_rows(attitude_rad: np.ndarray, pivot_m_s2: np.ndarray, period_s: float) -> np.ndarray:
    """Rows (roll, pitch, yaw, p, q, r, p', q', r', ax, ay, az) from attitudes (n, 3), splined and differentiated, and
    accelerations of the pivot in base axes (n, 3), at a constant period.
    """
    from scipy.interpolate import CubicSpline

    times = period_s * np.arange(len(attitude_rad))
    spline = CubicSpline(times, np.unwrap(attitude_rad, axis=0))
    roll, pitch, _ = spline(times).T
    droll, dpitch, dyaw = spline(times, 1).T
    cr, sr, cp, sp = np.cos(roll), np.sin(roll), np.cos(pitch), np.sin(pitch)
    rates = np.column_stack([droll - dyaw * sp, dpitch * cr + dyaw * sr * cp, -dpitch * sr + dyaw * cr * cp])
    return np.column_stack([spline(times), rates, CubicSpline(times, rates)(times, 1), pivot_m_s2])


def _start_axis(P: np.ndarray, K: np.ndarray, X: np.ndarray, index: int) -> None:
    block = layout.axis_block(index)
    X[layout.POSITION + index], X[layout.RATE + index] = P[block + layout.START_POSITION], P[block + layout.START_RATE]
    X[layout.TEMPERATURE + index] = P[block + layout.AMBIENT]
    numbers = P[block : block + len(_FRICTION_SLOTS)]
    if K[layout.TEMPERATURE_KNOTS] > 0:
        knots = P[layout.KNOTS :].reshape(-1)[index * layout.MAX_KNOTS * layout.KNOT_SIZE :]
        table = knots[: K[layout.TEMPERATURE_KNOTS] * layout.KNOT_SIZE].reshape(-1, layout.KNOT_SIZE)
        temperature = X[layout.TEMPERATURE + index]
        numbers = np.array(
            [np.interp(temperature, table[:, 0], table[:, 1 + slot]) for slot in range(len(_FRICTION_SLOTS))]
        )
    put_friction(P, X, index, numbers)


def put_friction(P: np.ndarray, X: np.ndarray, index: int, numbers: np.ndarray) -> None:
    """Put friction's numbers (7,), in the order of an axis block, in force for an axis, with what steps want of
    them.
    """
    force = layout.IN_FORCE + index * layout.IN_FORCE_SIZE
    X[force : force + len(numbers)] = numbers
    # interpreted: compiling it for one call would cost a third of a second
    interpreted(derive_friction)(X, index, P[layout.STEP_S])
