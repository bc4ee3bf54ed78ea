"""What paid for the gain: changed parts by name, each taken back alone, and the share that goes with it."""

from __future__ import annotations

from pathlib import Path

from gimbal_hil.loop.settings import DaemonSettings
from gimbal_hil.pages.report import Page
from gimbal_hil.pointing.arena import (
    BEFORE,
    FIRST,
    IMPROVED,
    changed_parts,
    chosen,
    controller_settings,
    paid_blocks,
    paid_text,
    shipped_scenarios,
    what_paid,
)
from sim_backend.model import AntennaModel, shipped_model


def worse_model() -> AntennaModel:
    """Half the friction on the outer axis, a centre of gravity that is off on the inner one."""
    model = shipped_model("realistic")
    model = model.with_numbers("outer", {"friction.viscous": 0.03})
    levels = {f"friction.{key}": 0.5 * model.number("outer", f"friction.{key}") for key in ("coulomb", "breakaway")}
    model = model.with_numbers("outer", levels)
    return model.with_number("inner", "body.cog.x", 0.0)


def test_changed_parts_have_the_names_of_what_they_are_of_and_are_taken_back_alone() -> None:
    first, improved = worse_model(), shipped_model("realistic").with_effect("cable_spring", "outer", {"stiffness": 0.1})
    parts = changed_parts(first, improved)
    assert set(parts) == {"outer friction", "inner weight", "outer cable spring"}
    without = parts["outer friction"]
    assert without.number("outer", "friction.coulomb") == first.number("outer", "friction.coulomb")
    assert without.number("inner", "body.cog.x") == improved.number("inner", "body.cog.x")
    assert [one.effect.name for one in parts["outer cable spring"].effects] == [
        one.effect.name for one in first.effects
    ]
    assert changed_parts(improved, improved) == {}


def test_a_ripple_beside_one_that_the_model_had_is_a_part_and_the_same_ripples_are_none() -> None:
    ripple = {"amplitude": 0.02, "order": 18.0, "phase": 0.4}
    first = shipped_model("realistic").with_effect("cogging", "inner", {"amplitude": 0.01, "order": 7.0, "phase": 0.0})
    improved = first.with_effect("cogging", "inner", ripple)
    parts = changed_parts(first, improved)
    assert set(parts) == {"inner cogging"}
    amounts = [
        (one.effect.name, one.axis, one.value("order"))
        for one in parts["inner cogging"].effects
        if one.effect.name == "cogging"
    ]
    assert amounts == [
        (one.effect.name, one.axis, one.value("order")) for one in first.effects if one.effect.name == "cogging"
    ]
    assert changed_parts(improved, improved) == {}


def test_friction_pays_for_reversals_and_the_shares_say_so(tmp_path: Path) -> None:
    improved = shipped_model("realistic")
    # the inner axis' viscous friction is hardly off
    first = worse_model().with_number("inner", "body.cog.x", improved.number("inner", "body.cog.x"))
    first = first.with_number("inner", "friction.viscous", 0.034)
    (tmp_path / "first.yaml").write_text(first.to_yaml())
    tuned = controller_settings("tuned")

    def using(model: str) -> DaemonSettings:
        assert tuned.model_control is not None
        return tuned.model_copy(update={"model_control": tuned.model_control.model_copy(update={"model": model})})

    scenario = chosen(shipped_scenarios(), "0.02 rad at 0.2 Hz")[0].model_copy(update={"duration_s": 8.0})
    controllers = {
        BEFORE: controller_settings("cascade"),
        FIRST: using(str(tmp_path / "first.yaml")),
        IMPROVED: using("realistic"),
    }
    paid = what_paid([scenario], "realistic", controllers, changed_parts(first, improved), tmp_path / "parts", 1)
    assert paid.rms(scenario.name, IMPROVED) < paid.rms(scenario.name, FIRST) < paid.rms(scenario.name, BEFORE)
    assert paid.share("outer friction") > 0.9 and abs(paid.share("inner friction")) < 0.1
    assert "outer friction" in paid_text(paid)
    page = Page("a", "b", paid_blocks(paid)).render()
    assert "Most is lost without outer friction" in page
