from __future__ import annotations

import json
import re
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from gimbal_hil.pages.plots import figure, peaks_kept, stacked
from gimbal_hil.pages.report import Callout, Details, Heading, Made, Page, Plot, Table, Text, command_of
from gimbal_hil.pages.report.figures_packed import STEPS, rounded, unpacked
from gimbal_hil.surface.demo.story import STAGES, StageResult, story_page

MADE = Made("2026-11-22T12:00:00Z", "0.1.0", "gimbal-hil experiment step --out 'my runs/a'")


def noisy_page(figures: int) -> Page:
    rng = np.random.default_rng(1)
    blocks = []
    for number in range(figures):
        drawn = figure(f"Figure {number}", "time [s]", "torque [N m]")
        time = np.linspace(0.0, 10.0, 2000)
        for name in ("measured", "model"):
            drawn.add_scatter(x=time, y=np.sin(time) + rng.normal(0.0, 0.1, len(time)), name=name)
        blocks.append(Plot(drawn, "what one sees"))
    return Page("A title", "below it", blocks)


def script(page: str, name: str) -> str:
    found = re.search(rf'<script type="text/plain" id="packed:{name}">([^<]+)</script>', page)
    assert found
    return found.group(1)


class Outside(HTMLParser):
    """Addresses that a page would load."""

    def __init__(self) -> None:
        super().__init__()
        self.found: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found += [value or "" for name, value in attrs if name in ("src", "href") and (value or "")[:1] != "#"]


def test_a_page_of_eight_figures_of_pure_noise_is_under_a_megabyte_and_loads_nothing() -> None:
    page = noisy_page(8).render(MADE)
    assert 500_000 < len(page.encode()) < 1_000_000
    outside = Outside()
    outside.feed(page)
    assert outside.found == []


def test_every_page_says_when_by_which_version_and_by_which_command_it_was_made() -> None:
    page = Page("A title", "", [Text("words")]).render(MADE)
    assert "2026-11-22T12:00:00Z" in page and "gimbal-hil 0.1.0" in page
    assert "gimbal-hil experiment step --out &#x27;my runs/a&#x27;" in page
    own = Page("A title", "", [Text("words")]).render()
    assert re.search(r'<time datetime="\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ">', own)


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["/usr/bin/gimbal-hil", "demo", "--out", "a b"], "gimbal-hil demo --out 'a b'"),
        (["/x/gimbal_hil/__main__.py", "bench"], "gimbal-hil bench"),
        (["mine.py", "--fast"], "python mine.py --fast"),
        (["-c"], "python"),
        ([], "python"),
    ],
)
def test_the_command_is_one_that_a_shell_takes(arguments: list[str], line: str) -> None:
    assert command_of(arguments) == line


def test_a_figure_comes_back_as_it_was_to_a_hundred_thousandth_of_its_range() -> None:
    drawn = figure("Title", "x", "y")
    values = np.array([0.0, np.nan, 1e-3, -2.5e-3, 1.234567e-3])
    drawn.add_scatter(x=np.arange(5), y=values, name="one")
    held = unpacked(script(Page("t", "", [Details("folded", [Plot(drawn)])]).render(MADE), "figures"))
    (found,) = held["figures"]
    back = found["data"][0]
    assert back["x"] == [0, 1, 2, 3, 4] and back["y"][1] is None
    error = np.abs(np.array(back["y"], float) - values)[np.isfinite(values)]
    assert np.all(error <= 3.5e-3 / STEPS) and found["layout"]["title"]["text"] == "Title"
    assert held["templates"][found["template"]]["layout"]


def test_numbers_without_a_range_keep_their_digits_and_infinities_are_no_json() -> None:
    assert rounded(np.array([0.123456789, 0.123456789])) == [0.123456789, 0.123456789]
    assert rounded(np.array([1.0, np.inf, -np.inf])) == [1.0, None, None]
    assert rounded(np.array([1e9, 1e9 + 1e7])) == [1e9, 1e9 + 1e7]
    assert json.dumps(rounded(np.array([]))) == "[]"


def test_small_numbers_keep_their_digits_for_logarithmic_axes() -> None:
    values = np.geomspace(1e-12, 1.0, 25)
    assert np.array(rounded(values)) == pytest.approx(values, rel=1e-3)


def test_a_title_stands_above_its_figure_and_says_to_a_screen_reader_what_is_drawn() -> None:
    drawn = stacked(("", ""), "time [s]", ("a", "b"), 150, "Steps <out>")
    drawn.add_scatter(x=[0, 1], y=[0, 1])
    page = Page("t", "", [Plot(drawn, "of both axes")]).render(MADE)
    assert "<h3>Steps &lt;out&gt;</h3>" in page
    assert 'role="img" aria-label="Steps &lt;out&gt; of both axes"' in page and "height:380px" in page


def test_a_page_without_figures_carries_no_script(tmp_path: Path) -> None:
    path = Page("t", "", [Heading("one"), Table(("a", "b"), [("x", "1.5")])]).write(tmp_path / "report.html")
    page = path.read_text()
    assert "<script" not in page and len(page) < 12_000 and '<th scope="col" class="n">b</th>' in page


def test_the_demo_begins_with_the_answer_then_the_plots_that_prove_it_and_folds_the_rest() -> None:
    plots = [Plot(figure(f"Proof {number}", "x", "y")) for number in range(3)]
    answer = Callout("Cogging was hidden, and is named.", "good")
    told = [StageResult(f"line of {stage.name}", (stage.name, "figure"), [Text("much")]) for stage in STAGES[:-1]]
    told.append(StageResult("named", ("named", "judged blind"), [answer, *plots], [Text("It moves.")]))
    page = story_page(told)
    assert page.blocks[0] == answer
    text = page.render(MADE)
    order = [
        text.index(word)
        for word in ("Cogging was hidden", "It moves.", "judged blind", "Proof 0", "Proof 1", "<details>")
    ]
    assert order == sorted(order)
    assert [block.summary for block in page.blocks if isinstance(block, Details)] == [
        stage.all_of_it for stage in STAGES
    ]
    assert len({stage.all_of_it for stage in STAGES}) == len(STAGES)


@pytest.mark.parametrize("heading", ["Figures", "Library", "packed:figures", "Packed: library"])
def test_no_heading_takes_the_name_of_what_is_packed_into_the_page(heading: str) -> None:
    page = noisy_page(1)
    names = re.findall(
        r'\sid="([^"]+)"', Page(page.title, page.subtitle, [Heading(heading), *page.blocks]).render(MADE)
    )
    assert {"packed:figures", "packed:library"} <= set(names) and len(names) == len(set(names))


def test_a_path_of_any_bytes_stands_in_a_page_that_every_reader_takes(tmp_path: Path) -> None:
    written = Page("A run", "of r\udcff", [Text("next: replay r\udcff")]).write(tmp_path / "report.html")
    assert "replay r\\udcff" in written.read_text(encoding="utf-8")


def test_a_line_of_many_samples_keeps_its_peak_and_its_order() -> None:
    values = np.zeros(100_000)
    values[31_417] = 3.6
    kept = peaks_kept(values, 1000)
    assert 31_417 in kept and len(kept) <= 1000 and (np.diff(kept) > 0).all()
    assert list(peaks_kept(values[:5], 1000)) == [0, 1, 2, 3, 4]
