"""An effect that nobody here has written is searched for as the catalogue's own are: by its profile, or by one from its
parameters.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from tests.effects.test_plug_in import installed, python

HEAD = """
import numpy as np

from firmware_protocol.compiling import compiled
from sim_backend.effects import Domain, Effect, Hook, Parameter

"""
STOP = '''
@compiled
def stop_torque(P: np.ndarray, o: int, X: np.ndarray, s: int, q: float, v: float, h: float) -> float:
    """A stop that hardens: -k (abs(q) - q_s)^3 beyond q_s, N m."""
    into = abs(q) - P[o + 1]
    if into <= 0.0:
        return 0.0
    return -P[o] * into**3 if q > 0.0 else P[o] * into**3


EFFECT = Effect(
    name="hardening_stop",
    domain=Domain.STRUCTURE,
    hook=Hook.TORQUE,
    law=stop_torque,
    parameters=(
        Parameter("stiffness", "N m/rad3", 0.0, 1e6, 0.0, "of the stop"),
        Parameter("begins", "rad", 0.0, 10.0, 0.0, "position from which it pushes"),
    ),
    text="a stop that hardens", equation="T - k (abs(q) - q_s)^3", source="test", excited_by="the ends of the travel",
)
'''
NOTCH = '''
@compiled
def notch_torque(P: np.ndarray, o: int, X: np.ndarray, s: int, q: float, v: float, h: float) -> float:
    """A magnet that holds the joint at one place, N m."""
    x = (q - P[o + 1]) / P[o + 2]
    return -P[o] * x * np.exp(-x * x)


EFFECT = Effect(
    name="magnetic_notch",
    domain=Domain.DRIVE,
    hook=Hook.TORQUE,
    law=notch_torque,
    parameters=(
        Parameter("pull", "N m", 0.0, 1e3, 0.0, "of the magnet"),
        Parameter("place", "rad", -10.0, 10.0, 0.0, "where it holds"),
        Parameter("width", "rad", 1e-3, 3.0, 0.1, "over which it pulls"),
    ),
    text="a magnet that holds", equation="T - A x exp(-x^2)", source="test", excited_by="slow motion over the place",
)
'''
#: torque of a known motion with the effect in it: what the family of the effect takes of the squares, and where its
#: numbers come to rest
SEARCHED = """
import json, sys
import numpy as np
from gimbal_hil.knowledge.discrepancy.hypotheses.evidence import families
from gimbal_hil.knowledge.discrepancy.hypotheses.fit import FitRule, Weighing, fit
from gimbal_hil.knowledge.discrepancy.hypotheses.hypothesis import Cause, Hypothesis, values_of
from gimbal_hil.knowledge.discrepancy.twin.record import record_of
from gimbal_hil.knowledge.discrepancy.search.screening import propose, respond
from gimbal_hil.knowledge.discrepancy.twin.twin import Twin
from gimbal_hil.data.signals import SignalsTable
from sim_backend.effects import CATALOGUE
from sim_backend.model import model_from_document

name, torque_of = sys.argv[1], eval(sys.argv[2])
axis = {"body": {"inertia": {"zz": 0.5}}}
model = model_from_document({"schema": 1, "name": "rig", "kind": "rotary", "axes": {"axis": axis}}, "rig")
t = 0.004 * np.arange(1000)
q = 0.9 * np.sin(1.9 * t) + 0.1 * np.sin(5.0 * t)
middle = t + 0.002
acceleration = -0.9 * 1.9**2 * np.sin(1.9 * middle) - 0.1 * 25.0 * np.sin(5.0 * middle)
torque = 0.5 * acceleration + torque_of(0.9 * np.sin(1.9 * middle) + 0.1 * np.sin(5.0 * middle))
table = SignalsTable.of(("axis",), t, {"axis.position": q, "axis.torque": torque})
twin = Twin(model, (record_of(table, model, 6.0, "log"),))
family = next(f for f in families(twin, "axis") if f.effect == name)
floor = np.full(len(twin.channels), 0.01)
alike = Weighing((1.0,) * len(floor), 1.0)
null = fit(twin, Hypothesis(), floor, alike, FitRule(0))
best = propose(null, respond(twin, null, floor, family), alike)[0]
found = fit(twin, Hypothesis((Cause(family, best.x),)), floor, alike, FitRule(12))
numbers = {key: value for key, (value, _) in values_of(model, twin, found.hypothesis, 0).items()}
ends = [[k.low, k.high] for k in family.knobs]
print(json.dumps({"starts": len(family.starts), "left": found.cost / null.cost, "numbers": numbers, "ends": ends}))
"""


def searched(folder: Path, source: str, name: str, torque: str) -> dict[str, Any]:
    installed(folder, "guest", HEAD + source)
    code = f"import sys\nsys.argv = ['-', {name!r}, {torque!r}]\n" + SEARCHED
    done = python(folder, code)
    assert done.returncode == 0, done.stderr
    found: dict[str, Any] = json.loads(done.stdout)
    return found


@pytest.mark.heavy
def test_a_stop_that_hardens_is_searched_from_its_parameters_alone(tmp_path: Path) -> None:
    found = searched(
        tmp_path, STOP, "hardening_stop", "lambda q: 40.0 * np.sign(q) * np.maximum(np.abs(q) - 0.55, 0.0) ** 3"
    )
    assert found["left"] < 1e-3
    assert found["numbers"]["begins"] == pytest.approx(0.55, abs=0.02)
    assert found["numbers"]["stiffness"] == pytest.approx(40.0, rel=0.1)
    # the catalogue's bounds hold: a stiffness is never negative
    assert found["ends"][0][0] == 0.0


@pytest.mark.heavy
def test_a_magnet_that_holds_at_one_place_is_found_there(tmp_path: Path) -> None:
    found = searched(
        tmp_path, NOTCH, "magnetic_notch", "lambda q: 1.5 * (q - 0.3) / 0.12 * np.exp(-(((q - 0.3) / 0.12) ** 2))"
    )
    assert found["left"] < 1e-2
    assert found["numbers"] == pytest.approx({"pull": 1.5, "place": 0.3, "width": 0.12}, rel=0.05)


@pytest.mark.heavy
def test_a_profile_of_its_own_takes_the_place_of_the_default(tmp_path: Path) -> None:
    own = """
def _search(scale):
    return one_knob("stiffness", 0.5 * scale.torque_rms)

"""
    source = "from sim_backend.effects import one_knob\n" + STOP.replace("EFFECT =", own + "EFFECT =")
    source = source.replace("EFFECT = Effect(", "EFFECT = Effect(search=_search,")
    found = searched(tmp_path, source, "hardening_stop", "lambda q: 2.0 * q**3")
    assert found["starts"] == 1 and found["left"] < 1e-3
    assert set(found["numbers"]) == {"stiffness"}
