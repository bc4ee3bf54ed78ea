"""Drawn flights: what navigation gets wrong reaches the truth, and figures are those of the truth."""

from __future__ import annotations

import json
import math
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_protocol.errors import BadInputError
from gimbal_hil.loop.settings import shipped_settings
from gimbal_hil.pages.report import Callout, Table
from gimbal_hil.pointing.certifying import (
    FLOWN_FILE,
    Certificate,
    FlightTask,
    FlownFile,
    FlownFlight,
    NavigationErrors,
    PointingRequirement,
    certificate_blocks,
    certified,
    fly,
    judged,
    of_all,
    of_time,
    summary,
)
from gimbal_hil.realtime.lockstep import SILENT
from gimbal_hil.surface.cli.app import run
from sim_backend.model import shipped_model

RIGHT = NavigationErrors(
    roll_bias_deg=0.0,
    pitch_bias_deg=0.0,
    heading_bias_deg=0.0,
    wander_deg=0.0,
    noise_deg=0.0,
    rate_noise_deg_s=0.0,
    latency_s=0.0,
    dropouts_per_hour=0.0,
)


def task(duration_s: float = 6.0, **errors: float | tuple[float, float]) -> FlightTask:
    model = shipped_model("realistic")
    chosen = shipped_settings().for_axes(model.axes, model.where).looking(model)
    return FlightTask(chosen, model, RIGHT.model_copy(update=errors), PointingRequirement(), duration_s)


TASK = task()


@pytest.mark.heavy
def test_a_navigation_without_errors_points_as_the_arena_says() -> None:
    flight = fly(task(), 1)
    assert flight.acquired_s < 4.0 and flight.stops == () and flight.mutes == flight.excursions == 0
    assert flight.within_s / flight.transmitting_s > 0.995
    # half of the time nearer than a hundredth of a degree
    assert flight.histogram[0] + flight.histogram[1] > 0.5 * flight.transmitting_s


@pytest.mark.heavy
def test_the_same_seed_is_the_same_flight() -> None:
    one, other = (fly(task(3.0, heading_bias_deg=0.1), 7) for _ in range(2))
    assert replace(one, computed_s=0.0) == replace(other, computed_s=0.0)
    assert fly(task(3.0, heading_bias_deg=0.1), 8).elevation_rad != one.elevation_rad


class Turned(NavigationErrors):
    """A navigation whose heading is off by so much, and nothing else."""

    by_deg: float = 0.0

    def drawn(self, duration_s: float, draw: np.random.Generator) -> tuple[np.ndarray, float]:
        errors, _ = RIGHT.drawn(duration_s, draw)
        errors[:, 2] = round(math.radians(self.by_deg) / 2e-6)
        return errors, 0.0


@pytest.mark.heavy
@pytest.mark.parametrize(("by_deg", "in_time"), [(0.3, True), (-0.3, True), (1.5, False)])
def test_a_heading_that_is_off_turns_the_beam_where_no_host_sees_it(by_deg: float, in_time: bool) -> None:
    flight = fly(replace(task(), navigation=Turned(by_deg=by_deg)), 2)
    middle_deg = (np.argmax(flight.histogram) + 0.5) * 0.005
    expected = abs(by_deg) * math.cos(flight.elevation_rad)
    assert middle_deg == pytest.approx(expected, abs=0.01) or expected > 1.0
    assert (flight.slowest_mute_s <= 0.1) == in_time


def test_attitude_that_is_older_than_it_says_costs_what_the_base_turns_meanwhile() -> None:
    def mean(flight: FlownFlight) -> float:
        return float(np.average(np.arange(len(flight.histogram)), weights=flight.histogram))

    assert mean(fly(task(12.0, latency_s=0.05), 4)) > 1.2 * mean(fly(task(12.0), 4))


def test_a_navigation_that_falls_silent_for_long_mutes_in_time() -> None:
    flight = fly(task(20.0, dropouts_per_hour=720.0, dropout_s=(1.5, 2.5)), 11)
    assert flight.silences > 0 and flight.stops == ("attitude_lost",) and flight.mutes > 0
    assert flight.slowest_mute_s <= 0.1


@given(st.lists(st.tuples(st.floats(0.0, 0.02), st.booleans()), min_size=1, max_size=60))
def test_figures_of_a_flight_are_those_of_counting(ticks: list[tuple[float, bool]]) -> None:
    error, on = np.array([e for e, _ in ticks]), np.array([t for _, t in ticks])
    need = PointingRequirement()
    found = judged(error, on, 0.01, need)
    assert found["transmitting_s"] == pytest.approx(0.01 * on.sum())
    assert found["within_s"] == pytest.approx(0.01 * sum(1 for e, t in ticks if t and e <= need.within_rad))
    assert sum(found["histogram"]) == pytest.approx(found["transmitting_s"])
    longest = current = 0
    for e, t in ticks:
        current = current + 1 if t and e > need.mute_beyond_rad else 0
        longest = max(longest, current)
    assert found["slowest_mute_s"] == pytest.approx(0.01 * longest)
    assert math.isinf(found["acquired_s"]) == (not on.any())


def test_intervals_are_those_of_the_books() -> None:
    # Clopper and Pearson: none of n failed -> (alpha / 2) ** (1 / n)
    assert of_all(100, 100).low == pytest.approx(0.025**0.01) and of_all(100, 100).high == 1.0
    assert of_all(0, 10).high == pytest.approx(1.0 - 0.025**0.1)
    draw = np.random.default_rng(3)
    covered = 0
    for _ in range(200):
        bad = draw.exponential(0.5, 60)
        found = of_time((10.0 - bad).tolist(), [10.0] * 60)
        covered += found.low <= 0.95 <= found.high
    assert covered > 170


def test_errors_are_drawn_with_the_sizes_that_the_file_says() -> None:
    errors = NavigationErrors(dropouts_per_hour=3600.0, dropout_s=(0.2, 0.2))
    rows = [errors.drawn(10.0, np.random.default_rng(seed)) for seed in range(200)]
    biases = np.degrees(np.array([table[:, 2].mean() for table, _ in rows]) * 2e-6)
    assert biases.std() == pytest.approx(0.05, rel=0.15)
    assert min(hidden for _, hidden in rows) >= 0.0 and max(hidden for _, hidden in rows) <= 0.004
    assert np.mean([table[:, SILENT].mean() for table, _ in rows]) == pytest.approx(0.19, abs=0.03)


def test_the_command_writes_a_certificate(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    navigation = tmp_path / "nav.yaml"
    navigation.write_text("schema: 1\nheading_bias_deg: 0.2\n")
    words = ["--duration", "3", "--navigation", str(navigation), "--out", str(tmp_path / "out"), "--json"]
    run("point", ["--certify", "2", *words])
    capsys.readouterr()
    code = run("point", ["--certify", "3", "--resume", *words])
    found = json.loads(capsys.readouterr().out)
    assert code == (0 if found["keeps"] else 1)
    assert [one["seed"] for one in found["each"]] == [1, 2, 3] and found["navigation_errors"]["heading_bias_deg"] == 0.2
    assert "47 CFR 25.228" in (tmp_path / "out" / "report.html").read_text()
    with pytest.raises(SystemExit) as end:
        from gimbal_hil.surface.cli import main

        main(["point", "--certify", "3", "--target", "azel:1,2"])
    assert end.value.code == 2
    for wrong in (["--target", "azel:1,2", "--resume"], ["--certify", "3", "--resume"]):
        with pytest.raises(SystemExit) as end:
            main(["point", *wrong])
        assert end.value.code == 2 and "--resume" in capsys.readouterr().err


def test_a_certificate_that_was_stopped_goes_on_where_it_was_and_is_the_same(tmp_path: Path) -> None:
    asked = task(3.0)
    whole = certified(asked, 4, 1, 1, lambda: 0.0, lambda flights: None)
    FlownFile(tmp_path, asked, resume=False).keep(whole.flights[1:3])
    with (tmp_path / FLOWN_FILE).open("a") as file:
        file.write('{"seed": 4, "gust')  # killed in the middle of a line
    flown: list[FlownFlight] = []
    again = FlownFile(tmp_path, asked, resume=True)
    assert again.kept == whole.flights[1:3]

    def done(flights: list[FlownFlight]) -> None:
        flown.extend(flights)
        again.keep(flights)

    found = certified(asked, 4, 1, 1, lambda: 0.0, done, again.kept)
    assert [one.seed for one in flown] == [1, 4]
    assert [replace(one, computed_s=0.0) for one in found.flights] == [
        replace(one, computed_s=0.0) for one in whole.flights
    ]
    assert {one.seed for one in FlownFile(tmp_path, asked, resume=True).kept} == {1, 2, 3, 4}
    with pytest.raises(BadInputError, match="another configuration, model, navigation or duration"):
        FlownFile(tmp_path, replace(asked, duration_s=4.0), resume=True)


flown_flights = st.builds(
    FlownFlight,
    seed=st.integers(0, 2**31),
    acquired_s=st.floats(0.0, 1e4) | st.just(math.inf),
    stops=st.lists(st.sampled_from(("attitude_lost", "deadman")), unique=True).map(tuple),
    histogram=st.lists(st.floats(0.0, 10.0), min_size=201, max_size=201).map(tuple),
    **{name: st.floats(0.0, 100.0) for name in ("gust_m_s", "flown_s", "transmitting_s", "within_s", "slowest_mute_s")},
    **{name: st.floats(-4.0, 4.0) for name in ("bank_rad", "elevation_rad")},
    **{name: st.integers(0, 99) for name in ("mutes", "excursions", "silences")},
    **{name: st.floats(0.0, 3.0) for name in ("worst_rad", "computed_s")},
)


@settings(max_examples=20, deadline=None)
@given(st.lists(flown_flights, max_size=3, unique_by=lambda one: one.seed))
def test_flights_are_read_as_they_were_kept(flights: list[FlownFlight]) -> None:
    with tempfile.TemporaryDirectory() as folder:
        FlownFile(Path(folder), TASK, resume=False).keep(flights)
        assert FlownFile(Path(folder), TASK, resume=True).kept == tuple(flights)


@pytest.mark.parametrize("line", ["nonsense", "[1]", '{"seed": 1}', '{"seed": NaN}', '{"seed": 1, "seed": 2}'])
def test_a_line_that_is_no_flight_is_refused_with_its_number(tmp_path: Path, line: str) -> None:
    FlownFile(tmp_path, TASK, resume=False)
    with (tmp_path / FLOWN_FILE).open("a") as file:
        file.write(line + "\n")
    with pytest.raises(BadInputError, match=r"flights\.jsonl: line 2"):
        FlownFile(tmp_path, TASK, resume=True)


def test_a_certificate_that_is_not_kept_says_which_flight() -> None:
    found = certified(task(3.0), 2, 1, 1, lambda: 0.0, lambda flights: None)
    worse = (replace(found.flights[0], slowest_mute_s=0.3), found.flights[1])
    broken = Certificate(found.task, worse, 1, 0.0)
    assert found.keeps and not broken.keeps and [one.seed for one in broken.late] == [1]
    assert "no excursion beyond 0.5 degrees in 2 flights" in summary(found)
    # by Clopper and Pearson 72 good flights of 72 show 95 % of them at 95 %, 71 do not
    many = [replace(found, flights=found.flights[:1] * count) for count in (71, 72)]
    assert [one.is_shown for one in (found, *many, broken)] == [False, False, True, False]
    said = [next(b for b in certificate_blocks(one) if isinstance(b, Callout)) for one in (many[1], found, broken)]
    assert [one.tone for one in said] == ["good", "warning", "bad"]
    assert "so few flights only show that at least 15 % of flights keep it" in summary(found)
    one = replace(found.flights[1], excursions=1)
    assert "the one excursion beyond 0.5 degrees in 2 flights was muted" in summary(
        Certificate(found.task, (found.flights[0], one), 1, 0.0)
    )
    for flights in (found.flights[:1], found.flights):
        blocks = certificate_blocks(Certificate(found.task, flights, 1, 0.0))
        groups = next(block for block in blocks if isinstance(block, Table) and block.header[0] == "Flights")
        whole = [row for row in groups.rows if row[1] == str(len(flights))]
        # of one flight there is a share and no interval
        assert whole and all(row[2].endswith(" %") and (row[3] == "-") is (len(flights) == 1) for row in whole)
    assert "in 1 of 2 flights" in summary(broken) and "0.30 s (seed 1)" in summary(broken)
