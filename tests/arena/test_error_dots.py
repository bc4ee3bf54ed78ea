"""Errors of scenarios side by side: the hardest row on top, spread where there is one, the same picture as a file."""

from __future__ import annotations

import math
from pathlib import Path

from gimbal_hil.pages.plots import write_picture
from gimbal_hil.pointing.arena.error_dots import Dots, error_dots

NAMES = ("slow: 0.001 rad/s", "aircraft: a direction held near the zenith in moderate turbulence", "base: stopped")


def test_the_hardest_case_is_on_top_and_a_spread_belongs_to_its_dot() -> None:
    compared = [
        Dots("one", "#111111", (3.0, 20.0, math.nan), (0.3, 2.0, 0.0)),
        Dots("two", "#222222", (1.0, 50.0, 2.0)),
    ]
    drawn = error_dots("Errors", NAMES, compared).to_dict()
    first, second = drawn["data"]
    assert [name.split("<br>")[0] for name in first["y"]] == ["aircraft: a direction held", "base: stopped", NAMES[0]]
    assert list(first["x"]) == [20.0, None, 3.0] and list(second["x"]) == [50.0, 2.0, 1.0]
    assert list(first["error_x"]["array"]) == [2.0, 0.0, 0.3] and not second["error_x"]
    assert drawn["layout"]["xaxis"]["type"] == "log" and drawn["layout"]["yaxis"]["autorange"] == "reversed"


def test_the_picture_as_a_file_has_the_names_in_lines(tmp_path: Path) -> None:
    drawn = error_dots("Errors", NAMES, [Dots("one", "#111111", (3.0, 20.0, 1.0), (0.3, 2.0, 0.1))])
    write_picture(drawn, tmp_path / "dots.svg")
    text = (tmp_path / "dots.svg").read_text()
    assert "<svg" in text and "br&gt;" not in text and "aircraft: a direction held" in text
