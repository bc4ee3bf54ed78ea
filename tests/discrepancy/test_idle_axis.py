"""An axis that idles is no reason to fail: it is searched on the other, and not testable here."""

from __future__ import annotations

import numpy as np
import pytest

from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.discrepancy import Request, diagnose, verdict_of
from sim_backend.model import shipped_model

T = np.arange(9000) * 1e-3

pytestmark = pytest.mark.heavy


def log(speed: float) -> SignalsTable:
    """The inner axis swings, the outer neither moves nor is driven; the torque is far from what the model needs."""
    columns = {"outer.torque": np.zeros(len(T)), "outer.position": np.zeros(len(T))}
    columns |= {"inner.torque": 0.5 * np.sin(speed * T), "inner.position": 0.3 * (1.0 - np.cos(speed * T))}
    return SignalsTable.of(("outer", "inner"), T, columns)


def test_a_locked_undriven_axis_gets_a_verdict_and_is_not_testable() -> None:
    verdict = verdict_of(diagnose(Request(shipped_model(), (log(2.0),), (log(3.1),)))).document
    assert verdict["verdict"] in ("named", "ambiguous", "unexplained", "no_discrepancy")
    assert ("viscous", "outer") in {(n["name"], n["axis"]) for n in verdict["not_testable"]}
    assert not [e for e in verdict["effects"] if e["axis"] == "outer" and e["name"] == "cogging"]
