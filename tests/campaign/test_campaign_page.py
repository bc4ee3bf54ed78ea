"""The headline of a campaign names what differs in a size that matters."""

from __future__ import annotations

from pathlib import Path

from gimbal_hil.proof.campaign import campaign_page


def test_an_overshoot_of_next_to_nothing_is_not_what_differs_most(tmp_path: Path) -> None:
    table = tmp_path / "antennas.csv"
    rows = [f"{n},,{0.0001 * (1 + 15 * n / 20)},{10.0 + 0.1 * n},{1e-6 * n}" for n in range(22)]
    names = "antenna,problem,turn: overshoot_percent,turn: torque_nm,rest: torque_nm"
    table.write_text("\n".join([names, *rows]) + "\n")
    page = campaign_page(table, "Steps", "here").render()
    assert "Differs most: torque of turn, 10.2 to 12 N m in nine of ten antennas (nominal 10 N m)." in page
