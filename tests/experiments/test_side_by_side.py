"""Parts of an experiment in processes of their own: the same end as one after the other, however often they were
stopped.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path

import pytest

from firmware_protocol.errors import BadInputError, SafetyStopError
from gimbal_hil.data.runs import EventKind, open_run
from gimbal_hil.knowledge.experiments.conducting import conduct
from gimbal_hil.knowledge.experiments.experiment import Experiment
from gimbal_hil.knowledge.experiments.runner import Outcome, Silent, table_csv
from gimbal_hil.knowledge.experiments.sequences import SequenceOptions, build_experiment
from gimbal_hil.knowledge.experiments.step_signals import STEPS_FOLDER, step_file
from gimbal_hil.loop.host import Guard
from gimbal_hil.loop.settings import shipped_settings
from sim_backend.model import shipped_model
from tests.parts import heavy_but

SEED = 3
AXES = ("outer", "inner")


def fast_sliding() -> Experiment:
    """The fastest speeds of the whole sequence, one pass each, both axes."""
    parts = []
    for axis in AXES:
        part = build_experiment("sliding", SequenceOptions(1000.0, (axis,), every=50))
        fast = [
            step
            for step in part.steps
            if step.measured and step.meaning["speed_rad_s"] > 0.08 and step.meaning["pass"] == 0
        ]
        parts.append(replace(part, steps=(part.steps[0], *fast)))
    return replace(parts[0], steps=parts[0].steps + parts[1].steps, parts=tuple(parts))


def conducted(folder: Path, experiment: Experiment, **how: object) -> Outcome:
    return conduct(experiment, shipped_settings(), shipped_model(), SEED, folder, **how)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Outcome:
    """The experiment without a stop."""
    return conducted(tmp_path_factory.mktemp("whole"), fast_sliding())


def same_end(outcome: Outcome, whole: Outcome) -> None:
    assert table_csv(outcome.rows) == table_csv(whole.rows)
    one, other = open_run(outcome.folder), open_run(whole.folder)
    assert one.content_hashes() == other.content_hashes() and one.events == other.events
    assert (outcome.folder / "table.csv").exists() and not (outcome.folder / "parts").exists()


def test_each_part_measures_what_it_measures_alone(tmp_path: Path, whole: Outcome) -> None:
    rows = [row for n, part in enumerate(fast_sliding().parts) for row in conducted(tmp_path / str(n), part).rows]
    assert table_csv(rows) == table_csv(whole.rows)


def test_the_parts_leave_one_run_folder_with_ticks_and_steps_numbered_through(whole: Outcome) -> None:
    run = open_run(whole.folder)
    assert run.record.end is not None and run.record.end.exit_code == 0 and not run.notes
    assert (run.ticks["tick"][1:] - run.ticks["tick"][:-1]).min() > 0 and (run.ticks["tick"] % 50 == 0).all()
    numbered = {
        event.data["number"]: event.text
        for event in run.events
        if event.kind is EventKind.SEGMENT and "number" in event.data
    }
    steps = fast_sliding().steps
    assert numbered == {number: step.name for number, step in enumerate(steps)}
    kept = [step_file(whole.folder, number) for number, step in enumerate(steps) if step.measured]
    assert kept == sorted((whole.folder / STEPS_FOLDER).iterdir())


class Ends(Silent):
    """Stops the process (or kills it) at a step of the part that runs in it."""

    def __init__(self, step: str, kill: bool) -> None:
        self.step, self.kill = step, kill

    def at(self, step: str, advanced_s: float) -> None:
        if step == self.step:
            if self.kill:
                os.kill(os.getpid(), signal.SIGKILL)
            raise KeyboardInterrupt


@pytest.mark.heavy
@pytest.mark.parametrize("place", heavy_but((0,), (0, 3)))
def test_parts_that_were_stopped_go_on_to_the_same_end(tmp_path: Path, whole: Outcome, place: int) -> None:
    experiment = fast_sliding()
    with pytest.raises(KeyboardInterrupt):
        conducted(tmp_path, experiment, progress=Ends(experiment.parts[1].steps[place].name, kill=False))
    assert all(
        open_run(part).record.end is not None for part in (tmp_path / "parts").iterdir() if (part / "run.yaml").exists()
    )
    same_end(conducted(tmp_path, experiment, resume=True), whole)


def run_until_killed(folder: Path, step: str) -> None:
    conducted(folder, fast_sliding(), progress=Ends(step, kill=True))


@pytest.mark.heavy
def test_parts_that_were_killed_go_on_to_the_same_end(tmp_path: Path, whole: Outcome) -> None:
    step = fast_sliding().parts[1].steps[2].name
    process = get_context("spawn").Process(target=run_until_killed, args=(tmp_path, step))
    process.start()
    process.join()
    assert process.exitcode == -signal.SIGKILL
    same_end(conducted(tmp_path, fast_sliding(), resume=True), whole)


def test_what_ends_a_part_in_another_process_ends_the_experiment_with_the_same_error(tmp_path: Path) -> None:
    experiment = fast_sliding()
    first = experiment.parts[0].steps[1]
    guarded = replace(first, segment=replace(first.segment, outer=replace(first.segment.outer, guard=Guard(1.0, 2.0))))
    part = replace(experiment.parts[0], steps=(experiment.parts[0].steps[0], guarded))
    with pytest.raises(SafetyStopError, match="its guard allows 1 to 2 rad"):
        conducted(tmp_path, replace(experiment, parts=(part, experiment.parts[1])))


def test_a_folder_without_parts_cannot_be_resumed(tmp_path: Path) -> None:
    with pytest.raises(BadInputError, match="parts: no such folder"):
        conducted(tmp_path / "nothing", fast_sliding(), resume=True)


PROGRAM = """
import os
from gimbal_hil.knowledge.experiments.runner import Silent
from gimbal_hil.knowledge.experiments.side_by_side import _run_all

class Part:
    def run(self, progress):
        progress.at("", 1.0)

if __name__ == "__main__":
    before = dict(os.environ)
    _run_all([Part(), Part()], Silent())
    print(os.environ == before)
"""


def test_processes_of_parts_read_no_module_of_the_folder_where_the_user_stands(tmp_path: Path) -> None:
    (tmp_path / "programs").mkdir()
    (tmp_path / "programs" / "parts.py").write_text(PROGRAM)
    (tmp_path / "signal.py").write_text("raise ImportError('mine')")
    done = subprocess.run([sys.executable, "programs/parts.py"], cwd=tmp_path, capture_output=True, text=True)
    assert (done.returncode, done.stdout, done.stderr) == (0, "True\n", "")
