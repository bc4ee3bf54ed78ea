"""An effect that the model states already moves as a number of the model does: two instances are no sum."""

from __future__ import annotations

import numpy as np
import pytest

from gimbal_hil.knowledge.discrepancy import Request, diagnose, verdict_of
from gimbal_hil.knowledge.discrepancy.hypotheses import Cause, Hypothesis, parameters_of, values_of
from gimbal_hil.knowledge.discrepancy.verdict.corrected import explained_by
from sim_backend.effects import CATALOGUE
from sim_backend.model import AntennaModel, shipped_model
from tests.discrepancy.test_hypothesis_bounds import named, twin_of
from tests.discrepancy.test_logs_of_strangers import swing, table
from tests.discrepancy.test_numbers_that_are_off import arm

IN_PLACE = sorted(effect.name for effect in CATALOGUE.values() if effect.moves_in_place)
SHAPED = sorted(e.name for e in CATALOGUE.values() if not e.is_number and not e.moves_in_place)


def _stating(name: str, share: float = 0.2) -> AntennaModel:
    """The shipped antenna with a ripple, and after it an effect at this share of the way from neutral to its bound."""
    model = shipped_model().with_effect("cogging", "outer", {"amplitude": 0.01, "order": 6.0})
    numbers = {p.name: p.neutral + share * (p.high - p.neutral) for p in CATALOGUE[name].parameters}
    return model.with_effect(name, "outer", numbers)


@pytest.mark.parametrize("name", IN_PLACE)
def test_a_cause_moves_the_instance_that_the_model_states(name: str) -> None:
    model = _stating(name)
    twin = twin_of(model)
    family = named(twin, name)
    moved = [parameter for knob in family.knobs for parameter in knob.parameters]
    stated = {parameter: model.effects[-1].value(parameter) for parameter in moved}
    wanted = {parameter: 0.5 * value for parameter, value in stated.items()}
    x = tuple(-0.5 * stated[knob.parameters[0]] / knob.size for knob in family.knobs)
    hypothesis = Hypothesis((Cause(family, x),))
    structure, P = parameters_of(twin, hypothesis)
    other = model.with_strengths(name, "outer", wanted)
    alone = twin_of(other).structure(())
    assert structure.instances == alone.instances and np.allclose(P, alone.P, rtol=1e-12)
    assert not np.array_equal(P, twin.structure(()).P)
    found = values_of(model, twin, hypothesis, 0)
    assert found == {key: (pytest.approx(value), pytest.approx(stated[key])) for key, value in wanted.items()}
    corrected = explained_by(model, twin, hypothesis)
    assert [entry.effect.name for entry in corrected.effects] == ["cogging", name]
    assert corrected.effects[-1].parameters == pytest.approx(other.effects[-1].parameters)


@pytest.mark.parametrize("name", SHAPED)
def test_an_effect_with_a_shape_of_its_own_is_added_beside_the_one_that_is_stated(name: str) -> None:
    model = shipped_model().with_effect(name, "outer", {})
    twin = twin_of(model)
    structure = twin.structure(((name, "outer"),))
    assert [hook for hook, _ in structure.instances] == [name, name]
    assert len(model.with_effect(name, "outer", {}).effects) == 2


@pytest.mark.parametrize("name", [n for n in IN_PLACE if CATALOGUE[n].parameters[0].low == 0.0])
def test_an_effect_that_is_gone_stands_at_no_bound(name: str) -> None:
    family = named(twin_of(_stating(name)), name)
    (knob,) = family.knobs
    assert knob.low == pytest.approx(-_stating(name).effects[-1].parameters[0] / knob.size)
    assert Cause(family, (knob.low,)).knobs_at_bound == ()
    assert Cause(family, (knob.high,)).knobs_at_bound == knob.parameters


def test_friction_that_is_alike_both_ways_needs_no_other_level() -> None:
    effects = [{"name": "coulomb_asymmetry", "axis": "pan", "asymmetry": 0.3}]
    model = arm(uncertainty="1%", effects=effects)
    logs = []
    for speed in (1.0, 0.8):
        t, torque, position = swing(20.0, noise=0.003, speed=speed)
        logs.append(table({"pan.torque": torque, "pan.position": position}, t))
    # an offset is left out of the search: of a joint that slides all the time it is the same constant torque
    asked = ("coulomb_asymmetry", "coulomb", "viscous", "inertia")
    verdict = verdict_of(diagnose(Request(model, tuple(logs[:1]), tuple(logs[1:]), only=asked)))
    assert [(one["name"], one["status"]) for one in verdict.effects] == [("coulomb_asymmetry", "named")]
    (parameters,) = (one["parameters"] for one in verdict.effects)
    assert parameters["asymmetry"]["nominal"] == 0.3 and abs(parameters["asymmetry"]["value"]) < 0.03
