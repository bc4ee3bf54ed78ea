"""The same kinds of fault on joints of another size, kind and rate, in other units: refused where they are, made up and
told, or no fault.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.preflight import preflight, questioned
from gimbal_hil.data.signals import ColumnMap, SignalsTable, read_signals
from gimbal_hil.knowledge.identification import Determination, fit_rigid_axis, regression_rule
from sim_backend.model import load_model
from tests.cases.joint import CARRIAGE, MAST, Floats, Joint, JointLog, table_text

JOINTS = {"mast": MAST, "carriage": CARRIAGE}
LOGS = {name: joint.log(seconds=8.0) for name, joint in JOINTS.items()}


def some(log: JointLog, count: int, seed: int) -> np.ndarray:
    rows = len(log.time)
    return np.sort(np.random.default_rng(seed).choice(np.arange(rows // 20, rows - rows // 20), count, replace=False))


def way(log: JointLog) -> float:
    return float(np.ptp(log.position))


def moved(log: JointLog, rows: np.ndarray, by: float) -> JointLog:
    return log.but(position=log.position + by * way(log) * np.isin(np.arange(len(log.time)), rows))


def held(values: Floats, seconds: float, rate_hz: float) -> Floats:
    rows = np.arange(len(values))
    first = len(rows) // 2
    return np.where((rows >= first) & (rows < first + seconds * rate_hz), values[first], values)


def counted(joint: Joint, log: JointLog, bits: int, start: int) -> tuple[str, str]:
    """A counter of few bits, and the words that read it."""
    counts = np.round(log.position / (0.1 * joint.step)).astype(np.int64) + start
    text = table_text({"time_s": log.time, "u": log.torque, "c": counts % 2**bits}, forms={"c": "d"})
    unit = "0.1*um" if joint.is_linear else "turn/655360"
    return text, f"joint.position=c{{}}:{unit}"


def current(joint: Joint, log: JointLog, kept: Callable[[np.ndarray], np.ndarray]) -> str:
    counts = kept(np.round(log.torque / joint.torque_constant / 0.01).astype(np.int64))
    return table_text({"time_s": log.time, "joint.position": log.position, "i": counts}, forms={"i": "d"})


def asked(folder: Path, joint: Joint, content: str, *words: str, **options: bool) -> SignalsTable:
    """The log as the commands take it in."""
    (folder / "model.yaml").write_text(joint.model_text())
    (folder / "log.csv").write_text(content)
    model = load_model(folder / "model.yaml")
    repair = options.pop("repair", False)
    table = read_signals(folder / "log.csv", model, columns=ColumnMap.of_words(words), **options)  # type: ignore[arg-type]
    tables = questioned(model, [table], repair)
    preflight(model, tables)
    return tables[0]


#: a log with a fault, and what the refusal says
FAULTS: dict[str, tuple[Callable[[Joint, JointLog], JointLog], str]] = {
    "one read in thousands": (lambda _, log: moved(log, some(log, 1, 7), 0.4), "cannot have been; .*--repair"),
    "15 reads, 2 % of the way off": (lambda _, log: moved(log, some(log, 15, 7), 0.02), r"\(15 rows in all\)"),
    "the first read": (lambda _, log: moved(log, np.array([0]), 0.3), "row 1 at 0 s: reads .*--repair"),
    "the last two reads": (
        lambda _, log: log.but(position=np.where(np.arange(len(log.time)) < len(log.time) - 2, log.position, 0.0)),
        r"row \d+ at .* reads 0 and jumps",
    ),
    "no value": (
        lambda _, log: log.but(
            position=np.where(np.isin(np.arange(len(log.time)), some(log, 2, 9)), 65.535, log.position)
        ),
        "reads 65.535, where",
    ),
    "torques that did nothing": (
        lambda joint, log: log.but(
            torque=np.where(np.isin(np.arange(len(log.time)), some(log, 8, 8)), 0.8 * joint.limit, log.torque)
        ),
        "which did nothing to the motion",
    ),
    "stuck for a fifth of a second": (
        lambda joint, log: log.but(position=held(log.position, 0.2, joint.rate_hz)),
        "is the same in .* rows and (stops|moves off) within one row",
    ),
    "rows exchanged": (
        lambda _, log: moved(log, some(log, len(log.time) // 40, 3), 0.05),
        r"row \d+ at ",
    ),
    "mirrored": (lambda _, log: log.but(torque=-log.torque), "mirrored"),
    "ten times the torque": (lambda _, log: log.but(torque=10.0 * log.torque), "another unit than torque's"),
}


@pytest.mark.parametrize("fault", FAULTS)
@pytest.mark.parametrize("name", JOINTS)
def test_a_fault_is_seen_on_a_joint_of_any_size(tmp_path: Path, name: str, fault: str) -> None:
    joint = JOINTS[name]
    spoil, said = FAULTS[fault]
    with pytest.raises(BadInputError, match=said) as refused:
        asked(tmp_path, joint, spoil(joint, LOGS[name]).text())
    assert "log.csv" in str(refused.value) and len(str(refused.value)) < 700


@pytest.mark.parametrize("name", JOINTS)
def test_reads_that_are_off_are_made_up_where_one_step_of_two_is_possible(tmp_path: Path, name: str) -> None:
    """Few of their steps stand out both ways: of a small one only that against the motion does."""
    joint, log = JOINTS[name], LOGS[name]
    for size in (0.003, 0.004, 0.006):
        rows = some(log, 40, 11)
        table = asked(tmp_path, joint, moved(log, rows, size).text(), repair=True)
        changed = np.flatnonzero(np.abs(table.position("joint") - moved(log, rows, size).position) > joint.step)
        assert len(changed) and set(changed) <= set(rows.tolist())
        assert any("made up from their neighbours" in note for note in table.notes)


@pytest.mark.parametrize("name", JOINTS)
def test_a_counter_of_few_bits_is_refused_and_read_with_its_wrap(tmp_path: Path, name: str) -> None:
    joint, log = JOINTS[name], LOGS[name]
    text, column = counted(joint, log, 17, 3000)
    with pytest.raises(BadInputError, match=r"joint.position, row \d+ at .* jumps by .*%WRAP"):
        asked(tmp_path, joint, text, "joint.torque=u", column.format(""))
    table = asked(tmp_path, joint, text, "joint.torque=u", column.format("%2^17"))
    assert np.ptp(table.position("joint")) == pytest.approx(way(log), rel=1e-3)


def begins_again(raw: np.ndarray, most: int) -> np.ndarray:
    return (raw + most) % (2 * most) - most


CURRENTS: dict[str, tuple[Callable[[np.ndarray], np.ndarray], str]] = {
    "twelve bits unsigned": (lambda raw: raw % 4096, "read without its sign"),
    "some without their sign": (
        lambda raw: np.where(np.arange(len(raw)) % 53 == 5, raw % 65536, raw),
        "read without its sign",
    ),
    "only the size": (np.abs, "without its sign"),
    "begins again at both ends": (
        lambda raw: begins_again(raw, int(np.max(np.abs(raw))) // 2),
        "begins again at the other end of its range",
    ),
}


@pytest.mark.parametrize("fault", CURRENTS)
@pytest.mark.parametrize("name", JOINTS)
def test_a_current_that_lost_its_sign_or_range_is_refused_whatever_is_asked_for(
    tmp_path: Path, name: str, fault: str
) -> None:
    joint = JOINTS[name]
    kept, said = CURRENTS[fault]
    with pytest.raises(BadInputError, match=said):
        asked(tmp_path, joint, current(joint, LOGS[name], kept), "joint.current=i:10*mA", repair=True)


#: torques and positions that are not the same column all over the log
MIXED: dict[str, Callable[[JointLog], JointLog]] = {
    "another gain from the middle on": lambda log: log.but(
        torque=np.where(log.time > 0.5 * log.time[-1], 1.3 * log.torque, log.torque)
    ),
    "larger one way": lambda log: log.but(torque=np.where(log.torque < 0.0, 3.0 * log.torque, log.torque)),
    "no angle of the joint": lambda log: log.but(position=log.position * np.abs(log.position)),
}


@pytest.mark.parametrize("fault", MIXED)
@pytest.mark.parametrize("name", JOINTS)
def test_no_inertia_is_told_narrowly_that_only_the_whole_log_has(name: str, fault: str) -> None:
    joint, log = JOINTS[name], MIXED[fault](JOINTS[name].log())
    rule = regression_rule(1.0 / joint.rate_hz)
    fit = fit_rigid_axis(log.time, log.position, log.torque, rule, smoothed=())
    inertia = fit.estimates[0]
    told = inertia.verdict is Determination.IDENTIFIED
    assert not told or inertia.interval.covers(joint.inertia), inertia
    assert fit.parts is not None or fit.unexplained("joint") or not told
    if fit.parts is not None:
        assert "asks for an inertia of" in fit.parts.finding("joint").text


@pytest.mark.parametrize("name", JOINTS)
def test_the_parts_of_one_joint_agree(name: str) -> None:
    joint, log = JOINTS[name], JOINTS[name].log(cogging=0.2 * JOINTS[name].coulomb)
    for torque in (log.torque, np.roll(log.torque, 4), log.torque + 0.5 * joint.coulomb * log.position / way(log)):
        fit = fit_rigid_axis(log.time, log.position, torque, regression_rule(1.0 / joint.rate_hz), smoothed=())
        assert fit.parts is None


def test_a_drive_of_two_levels_is_no_number_that_begins_again(tmp_path: Path) -> None:
    """Its torque goes across its whole range in one row, and the motion follows."""
    joint = MAST
    time = np.arange(4000) / joint.rate_hz
    torque = np.where(np.sin(2.0 * np.pi * 0.3 * time) > 0.0, 40.0, -40.0)
    position, rate = np.zeros(len(time)), 0.0
    for k in range(1, len(time)):
        friction = joint.coulomb * np.tanh(rate / 1e-3) + joint.viscous * rate
        rate += (torque[k - 1] - friction) / joint.inertia / joint.rate_hz
        position[k] = position[k - 1] + rate / joint.rate_hz
    log = JointLog(time, torque, np.round(position / joint.step) * joint.step, np.gradient(position, time))
    assert len(asked(tmp_path, joint, log.text())) == len(time)
