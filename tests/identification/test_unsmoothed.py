"""Logs that somebody smoothed before they were saved are searched as they were."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import butter, filtfilt

from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.identification import Unsmoothed, unsmoothed
from gimbal_hil.surface.library import SearchScope
from gimbal_hil.surface.library.finding import question_of
from sim_backend.model import load_model
from tests.cases.joint import BENCH, MODEL, Floats, JointLog, swinging
from tests.parts import heavy_but

LOGS = (swinging("a", cogging=0.03), swinging("b", cogging=0.03, seed=2))
Spoil = Callable[[JointLog], JointLog]


def both_ways(values: Floats, hertz: float = 5.0) -> Floats:
    return np.asarray(filtfilt(*butter(2, hertz / (0.5 * BENCH.rate_hz)), values))


def table_of(log: JointLog) -> SignalsTable:
    columns = {"joint.torque": log.torque, "joint.position": log.position}
    return SignalsTable.of(("joint",), log.time, columns, None, "log")


def asked(folder: Path, spoil: Spoil) -> Unsmoothed:
    (folder / "model.yaml").write_text(MODEL)
    return unsmoothed(load_model(folder / "model.yaml"), [table_of(spoil(log)) for log in LOGS])


SMOOTHED: dict[str, tuple[Spoil, tuple[str, ...]]] = {
    "the position column seems": (lambda log: log.but(position=both_ways(log.position)), ("position",)),
    "the torque column seems": (lambda log: log.but(torque=both_ways(log.torque)), ("torque",)),
    "torque and position seem": (
        lambda log: log.but(position=both_ways(log.position), torque=both_ways(log.torque)),
        ("position", "torque"),
    ),
}


@pytest.mark.parametrize("said", heavy_but(("the position column seems",), SMOOTHED))
def test_what_was_smoothed_is_taken_back_in_all_logs_and_told(tmp_path: Path, said: str) -> None:
    spoil, columns = SMOOTHED[said]
    found = asked(tmp_path, spoil)
    assert found.to_hz == pytest.approx(5.0, rel=0.15)
    inside = slice(600, -600)
    for log, table in zip(LOGS, found.tables, strict=True):
        assert said in table.notes[-1] and "scored to there" in table.notes[-1]
        for column in columns:
            true, was = both_ways(getattr(log, column), 4.0), both_ways(getattr(spoil(log), column), 4.0)
            now = both_ways(table.columns[f"joint.{column}"], 4.0)
            assert np.std((now - true)[inside]) < 0.5 * np.std((was - true)[inside])


SOUND: dict[str, Spoil] = {
    "as logged": lambda log: log,
    "off the grid of the encoder": lambda log: log.but(
        position=log.position + np.random.default_rng(3).normal(0.0, 2e-5, len(log.position))
    ),
    "late": lambda log: log.but(torque=np.roll(log.torque, 5)),
    "a spring": lambda log: log.but(torque=log.torque + 0.1 * log.position),
    "drag": lambda log: log.but(torque=log.torque + 0.004 * log.rate * np.abs(log.rate)),
}


@pytest.mark.parametrize("case", SOUND)
def test_logs_that_nobody_smoothed_stay_as_they_are(tmp_path: Path, case: str) -> None:
    found = asked(tmp_path, SOUND[case])
    assert found.to_hz is None and all(table.notes == () for table in found.tables)


def test_seconds_at_constant_speeds_say_nothing_of_a_slow_filter(tmp_path: Path) -> None:
    # a third of a hertz has fewer independent rows in five seconds than the regression has numbers
    (tmp_path / "model.yaml").write_text(MODEL)
    model, random, row_s = load_model(tmp_path / "model.yaml"), np.random.default_rng(3), 0.015
    step, logs = model.number("joint", "encoder.step"), []
    for speed in (0.087, -0.17, 1.05, -1.57, 0.17, -1.05):
        time = row_s * np.arange(int(min(5.0, 3.2 / abs(speed)) / row_s))
        position = step * np.round(speed * time / step)
        rough = np.convolve(random.normal(0.0, 0.02, len(time) + 20), np.ones(21) / 21, "valid")
        torque = 0.3 * np.sign(speed) + 0.05 * speed + 0.2 * np.sin(position) + 0.02 * np.sin(9.0 * position) + rough
        columns = {"joint.torque": torque, "joint.position": position}
        logs.append(SignalsTable.of(("joint",), time, columns, None, "log"))
    found = unsmoothed(model, logs)
    assert found.to_hz is None and all(table.notes == () for table in found.tables)


@pytest.mark.heavy
def test_a_search_gets_them_so_and_scores_up_to_where_half_was_left(tmp_path: Path) -> None:
    spoil, _ = SMOOTHED["the position column seems"]
    (tmp_path / "model.yaml").write_text(MODEL)
    paths = []
    for place, log in enumerate(LOGS):
        paths.append(tmp_path / f"{place}.csv")
        paths[-1].write_text(spoil(log).text())
    model = load_model(tmp_path / "model.yaml")
    question = question_of(model, paths[:1], paths[1:])
    assert question.request.band_hz == pytest.approx(5.0, rel=0.15)
    assert any("seems to be smoothed" in note for note in question.notes)
    stated = question_of(model, paths[:1], paths[1:], scope=SearchScope(band_hz=8.0))
    assert stated.request.band_hz == 8.0
