"""The library's objects give what the commands give: tables with units, events, figures, verdicts."""

from __future__ import annotations

import html
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from firmware_protocol.errors import BadInputError
from gimbal_hil import Antenna, Run, identify
from gimbal_hil.data.signals import read_signals, unit_of
from gimbal_hil.surface.library.sources import as_paths
from sim_backend.model import model_named, shipped_model
from tests.runs.lockstep import record_lockstep
from tests.runs.synthetic import position_rad, record_run

pandas = pytest.importorskip("pandas", reason="the extra pandas is not installed")


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Run:
    folder = tmp_path_factory.mktemp("library") / "run"
    record_run(folder, 1200)
    return Run(folder)


def test_importing_the_package_loads_nothing_heavy_and_its_names_are_there() -> None:
    code = (
        "import sys, gimbal_hil\n"
        "print([m for m in ('numpy', 'numba', 'pandas', 'pydantic') if m in sys.modules])\n"
        "from gimbal_hil import Antenna, Finding, Friction, Run, discrepancy, find_discrepancy, identify\n"
        "print(callable(find_discrepancy), discrepancy.__name__)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines() == ["[]", "True gimbal_hil.knowledge.discrepancy"]


def test_a_name_that_is_not_there_is_no_attribute() -> None:
    import gimbal_hil

    with pytest.raises(AttributeError, match="has no attribute 'Runs'"):
        _ = gimbal_hil.Runs  # type: ignore[attr-defined]


def test_a_frame_has_the_run_s_numbers_over_time_and_a_unit_for_every_column(run: Run) -> None:
    frame = run.frame()
    assert frame.index.name == "time_s"
    assert np.allclose(frame["outer.position"], position_rad(np.arange(len(frame))), atol=1e-5)
    assert set(frame.attrs["units"]) == {"time_s", *frame.columns}
    assert frame.attrs["units"]["outer.rate"] == "rad/s" and frame.attrs["units"]["base.r"] == "rad/s"


def test_units_of_an_axis_that_slides_are_metres_and_newtons() -> None:
    assert [unit_of(f"carriage.{name}", ["carriage"]) for name in ("position", "rate", "torque", "temperature")] == [
        "m", "m/s", "N", "degC",
    ]  # fmt: skip


def test_events_are_rows_with_their_time(run: Run) -> None:
    events = run.events()
    assert list(events.columns) == ["tick", "time_s", "kind", "text"]
    assert (events["kind"] == "command").any() and events["time_s"].is_monotonic_increasing


def test_a_figure_has_a_panel_for_each_unit_and_refuses_a_signal_that_is_not_there(run: Run) -> None:
    drawn = run.figure("outer.position", "inner.position", "outer.torque")
    assert [line["name"] for line in drawn.data] == ["outer.position", "inner.position", "outer.torque"]
    assert [drawn.layout[axis]["title"]["text"] for axis in ("yaxis", "yaxis2")] == ["[rad]", "[N m]"]
    with pytest.raises(BadInputError, match="no signal"):
        run.figure("outer.speed")


def test_a_picture_is_a_page_of_its_own_and_what_a_notebook_shows_is_that_page(run: Run, tmp_path: Path) -> None:
    picture = run.figure("outer.position")
    page = picture.write(tmp_path / "picture.html").read_text()
    assert len(re.findall('<div class="plot"', page)) == 1
    shown = html.unescape(re.findall('srcdoc="([^"]+)"', picture._repr_html_())[0])
    assert shown.split("<footer>")[0] == page.split("<footer>")[0]


def test_a_run_of_the_host_replays(tmp_path: Path) -> None:
    record_lockstep(tmp_path / "run", 300)
    assert Run(tmp_path / "run").replays()


def test_a_data_frame_passes_the_same_door_as_a_file(run: Run) -> None:
    frame = run.frame()
    with as_paths([frame, run, str(run.folder)], "log") as paths:
        table = read_signals(paths[0], ("outer", "inner"))
        assert paths[1] == paths[2] == run.folder
    assert np.array_equal(table.position("outer"), frame["outer.position"].to_numpy())
    broken = frame.copy()
    broken.iloc[3, 0] = np.nan
    with as_paths([broken], "log") as paths, pytest.raises(BadInputError, match=r"log-0\.npz"):
        read_signals(paths[0], ("outer", "inner"))
    with pytest.raises(BadInputError, match="a path, a Run or a DataFrame"), as_paths([3], "log"):  # type: ignore[list-item]
        pass


def test_an_antenna_takes_effects_and_keeps_its_configuration() -> None:
    plain = Antenna(seed=4)
    antenna = plain.with_effect("cogging", "outer", amplitude=0.03, order=12, phase=0.0)
    assert antenna.seed == 4 and antenna.settings == plain.settings
    assert [entry.effect.name for entry in antenna.model.effects][-1:] == ["cogging"]
    assert plain.model.document == shipped_model().document


def test_what_a_command_refuses_the_library_refuses(run: Run) -> None:
    with pytest.raises(BadInputError, match="axes"):
        identify(run, model=model_named("emps"))
    with pytest.raises(BadInputError, match="does not exist"):
        Run(run.folder / "no").frame()
    with pytest.raises(BadInputError, match="no axis 'middle'"):
        identify(run, axes=["middle"])


def test_a_picture_is_written_to_a_name_in_text_and_another_kind_of_file_is_refused(tmp_path: Path) -> None:
    from gimbal_hil.pages.plots import figure
    from gimbal_hil.surface.library.picture import Picture

    picture = Picture.of(figure("one", "time [s]", "[rad]"), "one")
    assert picture.write(str(tmp_path / "one.html")) == tmp_path / "one.html"
    with pytest.raises(BadInputError, match=r"\.html"):
        picture.write(tmp_path / "one.bmp")
    assert not (tmp_path / "one.bmp").exists()


@pytest.mark.parametrize(("ending", "begins"), [("svg", b"<?xml"), ("pdf", b"%PDF"), ("png", b"\x89PNG")])
def test_a_picture_is_written_for_papers_and_slides(run: Run, tmp_path: Path, ending: str, begins: bytes) -> None:
    pytest.importorskip("matplotlib", reason="the extra pictures is not installed")
    path = run.figure("outer.position", "outer.torque").write(tmp_path / f"picture.{ending}")
    assert path.read_bytes().startswith(begins)
    if ending == "svg":
        assert all(word in path.read_text() for word in ("time [s]", "[rad]", "[N m]"))
