"""The separating run is the one on which two explanations would differ most, and none where they would not differ."""

from __future__ import annotations

from typing import cast

import pytest

from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.discrepancy import Request, Result, diagnose
from gimbal_hil.knowledge.discrepancy.inquiry.inquiry import State
from gimbal_hil.knowledge.discrepancy.verdict.separating import CHANCE, all_sequences
from gimbal_hil.knowledge.experiments.sequences import SequenceOptions, breakaway_torques, build_experiment
from gimbal_hil.knowledge.experiments.sequences.survey import SHORT_SURVEY_S, survey_motion
from gimbal_hil.knowledge.improvement.choosing import (
    WORTH,
    Option,
    Pair,
    menu_of,
    open_end,
    person_needed,
    weighed,
    worth_running,
)
from gimbal_hil.knowledge.improvement.rehearsal import rehearse
from gimbal_hil.loop.settings import shipped_settings
from sim_backend.model import AntennaModel, shipped_model


def diagnosed(antenna: AntennaModel) -> Result:
    """On two short surveys."""
    options, settings = SequenceOptions(1000.0), shipped_settings()
    tables = [
        rehearse(survey_motion(options, number, SHORT_SURVEY_S), settings, antenna, seed=3 + number).table
        for number in (0, 1)
    ]
    assert tables[0] is not None and tables[1] is not None
    return diagnose(Request(shipped_model(), (tables[0],), (tables[1],)))


def pair_of(diagnosis: Result, *names: str) -> Pair:
    """The cause that was found, and the rival among these names."""
    one = diagnosis.told[0]
    rival = next(r for r in one.standing.rivals if r.label[0] in names and r.label != one.standing.label)
    return Pair(diagnosis.best, rival.state, (one.standing.label, rival.label))


def on_model(option: Option, model: AntennaModel) -> SignalsTable | None:
    """What an option would measure."""
    options = SequenceOptions(1000.0, (option.axis,), short=True, every=1, breakaway_nm=breakaway_torques(model))
    experiment = build_experiment(option.sequence, options)
    return rehearse(experiment, shipped_settings(), model).table


def named(*names: tuple[str, str]) -> Pair:
    """A pair of which only the names are asked."""
    one, other = names
    nobody = cast(State, None)
    return Pair(nobody, nobody, (one, other))


def test_against_chance_the_own_entries_of_a_cause_come_first_and_all_others_once_they_are_used_up() -> None:
    pair = named(("structural_resonance", "inner"), (CHANCE, "inner"))
    assert pair.against_chance
    assert [(option.sequence, option.axis) for option in menu_of(pair, done=[])] == [
        ("sweep", "inner"),
        ("reversals", "inner"),
    ]
    rest = menu_of(pair, done=[("sweep", "inner"), ("reversals", "inner")])
    assert {option.sequence for option in rest} == set(all_sequences()) - {"sweep", "reversals"}
    # a cause without an entry, and a pair that is not against chance
    assert len(menu_of(named(("saturation", "inner"), (CHANCE, "inner")), done=[])) == len(all_sequences())
    assert (
        menu_of(
            named(("viscous", "outer"), ("back_emf", "outer")), done=[("plateaus", "outer"), ("warm_and_cool", "outer")]
        )
        == []
    )


def test_against_chance_the_shortest_run_that_plainly_shows_it_is_made() -> None:
    long, short, faint = (
        Option(name, "inner", expected * WORTH, seconds)
        for name, expected, seconds in (
            ("warm_and_cool", 900.0, 103.0),
            ("one_locked", 40.0, 23.0),
            ("sweep", 2.0, 5.0),
        )
    )
    chance, rivals = (
        named(("saturation", "inner"), (CHANCE, "inner")),
        named(("stribeck", "inner"), ("presliding", "inner")),
    )
    assert worth_running(chance, [long, short, faint]) is short
    assert worth_running(rivals, [long, short, faint]) is long
    assert worth_running(chance, [faint]) is faint
    assert worth_running(chance, [Option("sweep", "inner", 0.5 * WORTH, 5.0)]) is None


def test_what_stays_open_says_why() -> None:
    pair = named(("saturation", "inner"), (CHANCE, "inner"))
    assert "no run fits the budgets (sweep on inner needs 60 s" in open_end(
        pair, [], ["sweep on inner needs 60 s of antenna time"], 1.2
    )
    assert "suspected, not shown" in open_end(pair, [], [], 1.2)
    assert "A person could tell" in open_end(named(("viscous", "outer"), ("back_emf", "outer")), [], [], 1.0)


@pytest.mark.heavy
def test_a_spring_is_told_from_an_unbalance_by_the_whole_travel() -> None:
    names = ("cable_spring", "static_unbalance")
    antenna = shipped_model().with_effect("cable_spring", "inner", {"stiffness": 0.02, "rest_position": 0.1})
    diagnosis = diagnosed(antenna)
    pair = pair_of(diagnosis, *names)
    assert {name for name, _ in pair.names} == set(names)
    menu = menu_of(pair, done=())
    assert menu[0].sequence == "full_turn"
    found = weighed(diagnosis, pair, menu, on_model)
    expected = {option.sequence: option.expected for option in found}
    assert found[0].sequence == "full_turn"
    assert expected["full_turn"] > 10.0 * WORTH
    assert "full_turn" not in [option.sequence for option in menu_of(pair, done=[("full_turn", "inner")])]


@pytest.mark.heavy
def test_a_delay_and_a_lag_far_below_a_sample_are_the_same_in_every_run() -> None:
    diagnosis = diagnosed(shipped_model().with_effect("actuator_lag", "outer", {"time_constant": 7e-5}))
    pair = pair_of(diagnosis, "transport_delay", "actuator_lag")
    found = weighed(diagnosis, pair, menu_of(pair, done=()), on_model)
    assert all(option.expected < WORTH for option in found)
    assert person_needed(pair) is None
