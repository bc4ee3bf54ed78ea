"""Logs in other units, with axes exchanged or mirrored, are refused by name; sound logs with a wrong model are not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.preflight import preflight
from gimbal_hil.data.preflight.channels import channels_of
from gimbal_hil.data.preflight.preflight import _check_attitude
from gimbal_hil.data.signals import SignalsTable, read_signals
from sim_backend.model import AntennaModel, load_model, shipped_model
from tests.blind.cases import tables_of
from tests.blind.draw import draw
from tests.cases.joint import BENCH, table_text
from tests.rigs import Rig, write_bam, write_dd2dof, write_emps, write_odrive
from tests.rigs.drawn import HIDDEN, drawn_joint, write_drawn

DEGREES = 180.0 / np.pi
AXES = ("outer", "inner")


@pytest.fixture(scope="module")
def logs() -> tuple[SignalsTable, ...]:
    """Two logs of the antenna, base moving, gyro there, nothing hidden."""
    case = draw(seed=20003, names=[])
    return tables_of(case.measured, case.axes)


def changed(logs: tuple[SignalsTable, ...], **factors: float) -> tuple[SignalsTable, ...]:
    """Columns times factors; a name without an axis means that signal of both, `base` and `rates` the base's angles and
    rates.
    """

    def factor(name: str) -> float:
        axis, _, signal = name.rpartition(".")
        group = ("base" if signal in ("roll", "pitch", "yaw") else "rates") if axis == "base" else signal
        return factors.get(group, 1.0) * factors.get(f"{axis}_{signal}", 1.0)

    return tuple(
        SignalsTable.of(
            t.axes,
            factors.get("time", 1.0) * t.time_s,
            {n: factor(n) * x for n, x in t.columns.items()},
            None,
            t.source,
        )
        for t in logs
    )


def swapped(logs: tuple[SignalsTable, ...], *signals: str) -> tuple[SignalsTable, ...]:
    pairs = {f"{a}.{s}": f"{b}.{s}" for a, b in (AXES, AXES[::-1]) for s in signals}
    return tuple(
        SignalsTable.of(t.axes, t.time_s, {n: t.columns[pairs.get(n, n)] for n in t.columns}, None, t.source)
        for t in logs
    )


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        (
            {"position": DEGREES, "rate": DEGREES},
            r"outer\.position, outer\.rate, inner\.position, inner\.rate: .*in degrees.*radians",
        ),
        ({"position": DEGREES}, r"log 0, log 1: outer\.position, inner\.position: .*in degrees"),
        ({"rate": DEGREES}, r"outer\.rate, inner\.rate: .*in degrees"),
        ({"inner_position": DEGREES}, r": inner\.position: .*in degrees"),
        (
            {"base": DEGREES, "rates": DEGREES},
            r"base\.roll, base\.pitch, base\.yaw, base\.p, base\.q, base\.r: .*in degrees",
        ),
        ({"base": DEGREES}, r"base\.roll, base\.pitch, base\.yaw: .*in degrees"),
        ({"rates": DEGREES}, r": base\.p, base\.q, base\.r: .*in degrees"),
        ({"outer_position": -1.0, "outer_rate": -1.0}, r": outer\.position, outer\.rate: .*mirrored"),
        ({"inner_torque": -1.0}, r": inner\.torque: .*mirrored"),
        (
            {"torque": 10.0},
            r"outer\.torque, inner\.torque: .*in amperes.*about 0\.1 N m/A on outer, 0\.1 N m/A on inner",
        ),
        ({"inner_torque": 10.0}, r": inner\.torque: .*in amperes.*about 0\.1 N m/A on inner"),
        (
            {"outer_torque": 5.0, "inner_torque": 20.0},
            r"outer\.torque, inner\.torque: .*about 0\.[23] N m/A on outer, 0\.0[56] N m/A on inner",
        ),
        ({"torque": 0.1}, r"outer\.torque, inner\.torque: .*in amperes"),
        ({"time": 1000.0}, r"log 0: time_s.*milliseconds.*seconds"),
    ],
)
def test_a_log_in_other_units_or_mirrored_is_refused_and_says_which(
    logs: tuple[SignalsTable, ...], wrong: dict[str, float], says: str
) -> None:
    with pytest.raises(BadInputError, match=says) as caught:
        preflight(shipped_model(), changed(logs, **wrong))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("which", [0, 1])
@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        ({"position": DEGREES, "rate": DEGREES}, "in degrees"),
        ({"inner_position": -1.0, "inner_rate": -1.0}, "mirrored"),
        ({"time": 1000.0}, "milliseconds"),
    ],
)
def test_one_log_of_two_that_is_misread_is_named_alone(
    logs: tuple[SignalsTable, ...], which: int, wrong: dict[str, float], says: str
) -> None:
    mixed = tuple(changed((log,), **wrong)[0] if k == which else log for k, log in enumerate(logs))
    with pytest.raises(BadInputError, match=rf"^log {which}: [^,]*.*{says}"):
        preflight(shipped_model(), mixed)


def test_a_base_that_is_pitched_by_more_than_a_quarter_turn_is_in_degrees(logs: tuple[SignalsTable, ...]) -> None:
    pitch = np.array([0.3, 17.0])[:, None] * np.sin(logs[0].time_s)
    for reaches, is_sound in zip(pitch, (True, False), strict=True):
        table = SignalsTable.of(logs[0].axes, logs[0].time_s, {**logs[0].columns, "base.pitch": reaches}, None, "log 0")
        if is_sound:
            _check_attitude(table)
        else:
            with pytest.raises(BadInputError, match=r"log 0: base\.pitch: reaches 17, .*degrees; expected radians"):
                _check_attitude(table)


@pytest.mark.parametrize("signals", [("torque", "position", "rate"), ("torque",), ("position", "rate")])
def test_swapped_axes_are_refused_and_say_so(logs: tuple[SignalsTable, ...], signals: tuple[str, ...]) -> None:
    with pytest.raises(BadInputError, match=r"swapped.*under its own name"):
        preflight(shipped_model(), swapped(logs, *signals))


def wrong_model(kind: str) -> AntennaModel:
    model = shipped_model()
    for axis in AXES:
        numbers = {path: model.number(axis, path) for (one, path) in model.numbers if one == axis}
        body = {path: value for path, value in numbers.items() if path.startswith(("body.inertia", "body.mass"))}
        level = {f"friction.{name}": numbers[f"friction.{name}"] for name in ("coulomb", "breakaway")}
        if kind in ("twice", "half"):
            factor = 2.0 if kind == "twice" else 0.5
            model = model.with_numbers(axis, {path: factor * value for path, value in (body | level).items()})
        if kind == "a third off":
            changes = {path: 1.33 * value for path, value in body.items()} | {
                path: value / 1.33 for path, value in level.items()
            }
            model = model.with_numbers(axis, changes)
        if kind == "without friction":
            names = ("coulomb", "breakaway", "viscous", "sigma0", "sigma1")
            model = model.with_numbers(axis, {f"friction.{name}": 0.0 for name in names})
        if kind == "without unbalance":
            model = model.with_numbers(axis, {f"body.cog.{key}": 0.0 for key in "xyz"})
    return model


@pytest.mark.parametrize("kind", ["right", "twice", "half", "a third off", "without friction", "without unbalance"])
def test_a_wrong_model_is_no_reason_to_refuse_a_sound_log(logs: tuple[SignalsTable, ...], kind: str) -> None:
    preflight(wrong_model(kind), logs)


@pytest.mark.parametrize("factor", [0.5, 0.67, 1.5, 2.0])
def test_a_gain_that_is_off_is_no_reason_to_refuse(logs: tuple[SignalsTable, ...], factor: float) -> None:
    preflight(shipped_model(), changed(logs, torque=factor))


@pytest.mark.heavy
def test_an_inertia_that_is_off_beside_steady_turns_is_no_reason_to_refuse(tmp_path: Path) -> None:
    joint = replace(drawn_joint(np.random.default_rng((9055, 3))), motion="turns")
    rig = write_drawn(tmp_path, joint, HIDDEN["inertia doubled"], 9055)
    model = load_model(rig.model)
    preflight(model, tuple(read_signals(path, model, resample=True) for path in rig.logs.values()))


@pytest.mark.parametrize("write", [write_odrive, write_bam, write_emps, write_dd2dof])
def test_every_log_of_the_measured_rigs_passes(write: Callable[[Path], Rig], tmp_path: Path) -> None:
    rig = write(tmp_path)
    model = load_model(rig.model)
    for path in rig.logs.values():
        preflight(model, (read_signals(path, model, resample=True),))


def test_a_carriage_in_millimetres_or_mirrored_is_refused(tmp_path: Path) -> None:
    rig = write_emps(tmp_path)
    model = load_model(rig.model)
    table = read_signals(rig.logs["DATA_EMPS"], model)
    for factor, word in ((1000.0, "millimetres"), (-1.0, "mirrored")):
        columns = dict(table.columns) | {"carriage.position": factor * table.position("carriage")}
        with pytest.raises(BadInputError, match=word):
            preflight(model, (SignalsTable.of(table.axes, table.time_s, columns, None, "log"),))


def test_an_axis_that_is_locked_or_not_driven_is_no_reason_to_refuse(logs: tuple[SignalsTable, ...]) -> None:
    preflight(shipped_model(), changed(logs, outer_torque=0.0, outer_position=0.0, outer_rate=0.0))


def test_an_axis_that_stands_while_the_other_moves_says_nothing_about_its_torque() -> None:
    model, t = shipped_model(), np.arange(8000) * 1e-2
    way = np.sign(np.sin(0.5 * t))
    moving = np.cumsum(1e-2 * way * np.where(t < 40.0, 1e-2, 0.3))
    dice = np.random.default_rng(0)
    standing, held = 1e-6 * dice.choice([-1.0, 0.0, 1.0], len(t)), 1e-3 * dice.normal(size=len(t))
    logs = []
    for position, torque in ((moving, 0.2 * way), (standing, held)):
        columns = {f"{axis}.{signal}": np.sin(t) for axis in model.axes for signal in ("position", "torque")}
        columns |= {"outer.position": position, "outer.torque": torque}
        logs.append(SignalsTable.of(model.axes, t, columns))
    assert channels_of(model, tuple(logs))["outer.torque"].misfit(3.0) < 0.4


@pytest.mark.parametrize(
    ("times", "says"),
    [
        (10.0, r"time_s: fits .* at about [456]\d0 a second .*--rate with the rows"),
        # all torque then is inertia's, which another unit explains as well
        (0.1, r"joint\.torque: seems .*; or another --rate, if the rows did not come at the one stated"),
    ],
)
def test_a_rate_that_was_stated_ten_times_too_high_or_low_is_told(tmp_path: Path, times: float, says: str) -> None:
    (tmp_path / "model.yaml").write_text(BENCH.model_text())
    log = BENCH.log("a", 16.0)
    (tmp_path / "log.csv").write_text(table_text({"joint.torque": log.torque, "joint.position": log.position}))
    model = load_model(tmp_path / "model.yaml")
    table = read_signals(tmp_path / "log.csv", model, rate_hz=500.0 * times)
    with pytest.raises(BadInputError, match=says):
        preflight(model, (table,))
    preflight(model, (read_signals(tmp_path / "log.csv", model, rate_hz=500.0),))


@pytest.mark.parametrize(
    ("column", "times", "what"),
    [
        ("position", DEGREES, "position: seems to be in degrees"),
        ("position", 0.5 / np.pi, "in radians, which turns"),
        ("torque", 0.1, "torque: seems to be in amperes"),
    ],
)
def test_a_rate_that_is_right_is_not_told_in_place_of_a_unit(
    tmp_path: Path, column: str, times: float, what: str
) -> None:
    (tmp_path / "model.yaml").write_text(BENCH.model_text())
    log = BENCH.log("a", 16.0)
    columns = {"joint.torque": log.torque, "joint.position": log.position}
    columns[f"joint.{column}"] = times * columns[f"joint.{column}"]
    (tmp_path / "log.csv").write_text(table_text(columns))
    model = load_model(tmp_path / "model.yaml")
    with pytest.raises(BadInputError) as refused:
        preflight(model, (read_signals(tmp_path / "log.csv", model, rate_hz=500.0),))
    assert what in str(refused.value) and "time_s: fits" not in str(refused.value)
