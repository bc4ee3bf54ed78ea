"""Nonsense is refused with one line that names the log, the column and the expectation."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.discrepancy.inquiry.preflight import check_alike, check_logs
from sim_backend.model import shipped_model

T = np.arange(6000) * 1e-3


#: motion of several frequencies, so that position, rate and acceleration are three things
TONES = ((0.3, 3.0), (0.1, 7.1), (0.05, 11.3))


def table(
    scale: float = 1.0,
    seconds: float = 6.0,
    torque: float = 1.0,
    rate: float = 1.0,
    time: float = 1.0,
    late: float = 0.0,
) -> SignalsTable:
    """Frictionless motion of the shipped antenna's inertias, each column times a factor that is 1 in sound data."""
    t = late + T[: int(seconds * 1000)]
    model = shipped_model()
    position = sum(a * np.sin(w * t) for a, w in TONES)
    columns: dict[str, np.ndarray] = {}
    for axis in model.axes:
        inertia = model.number(axis, model.own_inertia_path(axis))
        columns[f"{axis}.torque"] = torque * inertia * -sum(a * w**2 * np.sin(w * t) for a, w in TONES) + 0.01 * np.sin(
            31.0 * t
        )
        columns[f"{axis}.position"] = scale * position
        columns[f"{axis}.rate"] = rate * sum(a * w * np.cos(w * t) for a, w in TONES)
    return SignalsTable.of(model.axes, time * (t - late), columns, source="log.csv")


def test_sound_logs_pass() -> None:
    check_logs(shipped_model(), (table(), table(seconds=5.5, late=10.0)))


def test_a_log_that_is_given_twice_is_refused_since_a_copy_judges_nothing() -> None:
    with pytest.raises(BadInputError, match="the same rows"):
        check_logs(shipped_model(), (table(), table()))


def log_of(columns: dict[str, np.ndarray], like: SignalsTable, source: str = "other.csv") -> SignalsTable:
    """Another log of the same axes and period."""
    time_s = like.time_s[0] + 1e-3 * np.arange(len(next(iter(columns.values()))))
    axes = tuple(dict.fromkeys(name.split(".")[0] for name in columns))
    return SignalsTable.of(axes, time_s, columns, source=source)


def signed_zeros(values: np.ndarray) -> np.ndarray:
    return np.where(values == 0.0, -0.0, values)


@pytest.mark.parametrize("part", [slice(0, 5999), slice(1000, 4000), slice(3000, None)])
@pytest.mark.parametrize(
    "written", [np.float64, np.float32, lambda x: np.array([float(f"{v:.6g}") for v in x]), signed_zeros]
)
def test_a_piece_of_another_log_is_refused_with_whatever_digits(part: slice, written: Any) -> None:
    whole = table()
    piece = log_of({name: np.asarray(written(x[part]), float) for name, x in whole.columns.items()}, whole)
    for logs in ((whole, piece), (piece, whole)):
        with pytest.raises(BadInputError, match="the same rows"):
            check_logs(shipped_model(), logs)


def test_a_copy_that_has_one_axis_only_is_a_copy() -> None:
    whole = table()
    one = log_of({name: x for name, x in whole.columns.items() if name.startswith("outer")}, whole)
    with pytest.raises(BadInputError, match="the same rows"):
        check_alike((whole, one))


def test_two_logs_that_begin_alike_or_stand_alike_are_two_logs() -> None:
    whole, other = table(), table(late=20.0)
    begun = {name: np.where(np.arange(6000) < 1200, x, other.columns[name]) for name, x in whole.columns.items()}
    check_logs(shipped_model(), (whole, log_of(begun, whole)))
    # both stand for five seconds of six, where neither moves nor is driven
    stood = [{n: np.where(np.arange(6000) < 5000, 0.0, x) for n, x in one.columns.items()} for one in (whole, other)]
    check_logs(shipped_model(), tuple(log_of(one, whole) for one in stood))


def triangle(size: float, rows: int = 20000) -> dict[str, np.ndarray]:
    """Constant speed there and back with a torque that only changes its sign, and nothing noisy, coarse encoder."""
    way = np.abs((np.arange(rows) * 1e-4 + size) % (4.0 * size) - 2.0 * size) - size
    return {"pan.position": np.round(way / 1e-3) * 1e-3, "pan.torque": 0.2 * np.sign(np.gradient(way))}


def steps(dwell: int, size: float) -> dict[str, np.ndarray]:
    """Quick moves by one size, and rests between them: nothing noisy."""
    at = np.arange(6000)
    number, within = np.divmod(at, 12 + dwell)
    share = np.clip(within / 12.0, 0.0, 1.0)
    push = np.where(within < 6, 0.3, np.where(within < 12, -0.3, 0.0))
    return {"pan.position": np.round(size * (number % 20 + share), 4), "pan.torque": push}


@pytest.mark.parametrize(
    "pair", [(triangle(0.5), triangle(0.8)), (steps(40, 0.2), steps(55, 0.2)), (steps(40, 0.2), steps(55, 0.3))]
)
def test_motion_of_the_same_pieces_without_noise_is_no_copy(pair: tuple[dict[str, np.ndarray], ...]) -> None:
    like = table()
    check_alike(tuple(log_of(columns, like) for columns in pair))


def test_an_axis_that_is_locked_or_not_driven_is_no_reason_to_refuse() -> None:
    sound = table()
    for column in ("outer.torque", "outer.position", "outer.rate"):
        columns = dict(sound.columns) | {column: np.zeros(len(sound))}
        check_logs(shipped_model(), (SignalsTable.of(sound.axes, sound.time_s, columns, source="log.csv"),))


@pytest.mark.parametrize("band_hz", [0.5, 150.0])
def test_a_band_that_the_rows_do_not_hold_is_refused(band_hz: float) -> None:
    check_logs(shipped_model(), (table(),), 100.0)
    with pytest.raises(BadInputError, match="--band"):
        check_logs(shipped_model(), (table(),), band_hz)


def test_a_log_without_motion_or_of_no_length_is_refused() -> None:
    with pytest.raises(BadInputError, match="never changes"):
        check_logs(shipped_model(), (table(scale=0.0),))
    with pytest.raises(BadInputError, match="lasts"):
        check_logs(shipped_model(), (table(seconds=1.2),))
