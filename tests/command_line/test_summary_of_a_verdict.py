"""What the terminal says of a verdict."""

from __future__ import annotations

from pathlib import Path

from gimbal_hil.surface.cli.discrepancy import verdict_summary


def number(value: float, unit: str) -> dict[str, object]:
    return {"value": value, "low": value, "high": value, "unit": unit, "nominal": None}


def test_every_order_of_a_ripple_is_told_and_a_number_without_unit_has_none() -> None:
    orders = [{"amplitude": number(0.008, "N m"), "order": number(n, "1/turn")} for n in (7.0, 14.0)]
    ripple = {"name": "cogging", "axis": "motor", "status": "named", "parameters": orders[0], "entries": orders}
    drag = {"name": "drag", "axis": "motor", "status": "ambiguous", "parameters": {"asymmetry": number(-0.19, "1")}}
    verdict = {
        "verdict": "named", "answer": "A gap.", "grounds": "", "left": "Still unexplained: much.",
        "effects": [ripple, drag], "contradictions": [], "next_experiment": None,
    }  # fmt: skip
    lines = verdict_summary(verdict, Path("found")).splitlines()
    assert lines[:2] == ["named: A gap.", "  Still unexplained: much."]
    assert lines[2] == (
        "  cogging on motor (named): amplitude 0.008 N m, order 7 1/turn; amplitude 0.008 N m, order 14 1/turn"
    )
    assert lines[3] == "  drag on motor (ambiguous): asymmetry -0.19"
