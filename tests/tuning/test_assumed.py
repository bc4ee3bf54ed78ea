"""What loops hang on and nobody measured is told by name."""

from __future__ import annotations

from gimbal_hil.knowledge.tuning import assumed_numbers, caution
from sim_backend.model import shipped_model


def test_delay_gyro_and_modes_of_the_shipped_antenna_are_assumed_and_its_friction_is_not() -> None:
    found = assumed_numbers(shipped_model("realistic"))
    told = {(one.axis, one.name): one.value for one in found}
    assert told["outer", "gyro.bandwidth"] == 1256.637 and told["inner", "transport_delay.delay"] == 0.002
    assert ("outer", "structural_resonance.antiresonance_frequency") in told
    assert not any("friction" in name or "inertia.zz" in name for _, name in told)
    said, outer, inner = caution(found).splitlines()
    assert said.startswith(f"caution: {len(found)} ") and inner.startswith("  inner: ")
    assert outer.startswith("  outer: ") and "gyro.bandwidth 1257 rad/s" in outer


def test_a_number_that_was_measured_leaves_the_list_and_an_empty_one_says_nothing() -> None:
    model = shipped_model("realistic")
    before = len(assumed_numbers(model))
    measured = model.with_number("outer", "gyro.bandwidth", 900.0, "measured")
    assert len(assumed_numbers(measured)) == before - 1
    assert caution(()) == ""
