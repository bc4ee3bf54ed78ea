"""Figures as files: what a page's figure shows stands in the picture, whatever kinds of traces it is made of."""

from __future__ import annotations

from pathlib import Path

import pytest

from firmware_protocol.errors import BadInputError
from gimbal_hil.pages.plots import Drawing, figure, in_floors, stacked, write_picture

pytest.importorskip("matplotlib", reason="the extra pictures is not installed")


def words_of(path: Path) -> str:
    """The texts of an SVG, which Matplotlib keeps as comments beside their outlines."""
    return path.read_text(encoding="utf-8")


def bars() -> Drawing:
    drawn = figure("Left over", "share", "", 300)
    spread = {"type": "data", "symmetric": False, "array": [0.1, 0.2], "arrayminus": [0.0, 0.1]}
    drawn.add_bar(y=[["speed", "time"], ["slow", "late"]], x=[0.3, 0.7], orientation="h", error_x=spread)
    drawn.update_yaxes(autorange="reversed")
    return drawn


def squares() -> Drawing:
    drawn = figure("Correlations", "", "", 300)
    marker = {"symbol": "square", "size": 40, "color": [1.0, -0.5], "cmin": -1.0, "cmax": 1.0}
    marker["colorscale"] = [[0.0, "#6a4c93"], [1.0, "#1f6f8b"]]
    text = {"text": ["1.00", "-0.50"], "textfont": {"color": ["#ffffff", "#222222"]}}
    drawn.add_scatter(x=["kp", "ki"], y=["kp", "kp"], mode="markers+text", marker=marker, **text)
    return drawn


def panels() -> Drawing:
    drawn = stacked(["above", "below"], "time [s]", ["[rad]", "[N m]"])
    drawn.add_scatter(x=[0.0, 1.0, 2.0], y=[0.0, None, 1.0], name="measured", line={"color": "#1f6f8b", "dash": "dot"})
    drawn.add_scatter(x=[0.0, 2.0], y=[1.0, 2.0], name="model", row=2, mode="lines+markers")
    drawn.add_scatter(
        x=[1.0], y=[1.0], name="worst", row=2, marker={"symbol": "circle-open", "size": 9}, mode="markers"
    )
    return drawn


@pytest.mark.parametrize(
    ("drawn", "words"),
    [
        (bars(), ("Left over", "speed: slow", "share")),
        (squares(), ("Correlations", "kp", "-0.50")),
        (panels(), ("above", "time [s]", "[N m]", "measured")),
    ],
    ids=["bars", "squares", "panels"],
)
def test_words_of_a_figure_stand_in_its_picture(drawn: Drawing, words: tuple[str, ...], tmp_path: Path) -> None:
    said = words_of(write_picture(drawn, tmp_path / "one.svg"))
    assert [word for word in words if f"<!-- {word} -->" not in said.replace("−", "-")] == []


def test_sizes_in_floors_begin_at_zero_until_the_largest_would_hide_the_smallest(tmp_path: Path) -> None:
    near, far = figure("near", "", "rms", 300), figure("far", "", "rms", 300)
    for drawn, values in ((near, [0.9, 1.4]), (far, [1.1, 350.0])):
        drawn.add_bar(x=["a", "b"], y=values)
        in_floors(drawn, values)
        write_picture(drawn, tmp_path / "one.png")
    assert near.layout["yaxis"]["range"][0] == 0.0 and "type" not in near.layout["yaxis"]
    assert far.layout["yaxis"]["type"] == "log" and "500" in far.layout["yaxis"]["ticktext"]


def test_another_ending_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BadInputError, match=r"\.svg, \.pdf, \.png"):
        write_picture(figure("one", "", ""), tmp_path / "one.gif")
