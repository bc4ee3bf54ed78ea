"""The headline of a campaign names what differs in a size that matters."""

from __future__ import annotations

from pathlib import Path

from gimbal_hil.pages.report import plots_in
from gimbal_hil.proof.campaign import campaign_page


def test_an_overshoot_of_next_to_nothing_is_not_what_differs_most(tmp_path: Path) -> None:
    table = tmp_path / "antennas.csv"
    rows = [f"{n},,{0.0001 * (1 + 15 * n / 20)},{10.0 + 0.1 * n},{1e-6 * n}" for n in range(22)]
    names = "antenna,problem,turn: overshoot_percent,turn: torque_nm,rest: torque_nm"
    table.write_text("\n".join([names, *rows]) + "\n")
    page = campaign_page(table, "Steps", "here").render()
    assert (
        "Largest torque of the step &quot;turn&quot; differs most from antenna to antenna: 10.2 to 12 N m in nine"
        in page
    )


def test_small_numbers_have_a_unit_of_their_size_and_no_exponent(tmp_path: Path) -> None:
    table = tmp_path / "antennas.csv"
    rows = [f"{n},,{(n - 5) * 1e-6},{0.8 + 0.01 * n},{5e-6 + 1e-8 * n}" for n in range(11)]
    names = "antenna,problem,turn: error_rad,turn: settling_s,outer.encoder.step"
    table.write_text("\n".join([names, *rows]) + "\n")
    page = campaign_page(table, "Steps", "here")
    said = page.render()
    # what a loop leaves of an error at rest is a few steps of the encoder
    assert (
        "Settling time of the step &quot;turn&quot; differs most from antenna to antenna: 0.815 to 0.895 s in nine"
        in said
    )
    assert ">Error at rest [µrad]<" in said and ">Settling time [s]<" in said and "0.000005" in said
    assert "e-06" not in said and "error_rad" not in said
    axes = [plot.figure.to_dict()["layout"]["xaxis"]["title"] for plot in plots_in(page.blocks)]
    assert any("difference from the nominal antenna [µrad]" in str(title) for title in axes)
