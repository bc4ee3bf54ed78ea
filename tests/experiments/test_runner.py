"""The runner: guards on entry, a teardown that always comes, checkpoints that lead to the same end."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path

import pytest

from firmware_protocol.errors import BadInputError, LinkError, SafetyStopError
from gimbal_hil.data.runs import EventKind, open_run
from gimbal_hil.data.runs.header import RunHeader
from gimbal_hil.knowledge.experiments.antenna import LockstepAntenna
from gimbal_hil.knowledge.experiments.conducting import run_header, write_results
from gimbal_hil.knowledge.experiments.experiment import Experiment
from gimbal_hil.knowledge.experiments.runner import Outcome, Silent, run_experiment, table_csv
from gimbal_hil.knowledge.experiments.sequences import SequenceOptions, breakaway_torques, build_experiment
from gimbal_hil.loop.host import Guard
from gimbal_hil.loop.settings import shipped_settings
from sim_backend.model import shipped_model
from tests.experiments.scripted_antenna import ScriptedAntenna, waiting_experiment
from tests.experiments.small_sequence import small_sequence

SEED = 5
TEARDOWN = ["back to the safe pose", "torque off"]


def header() -> RunHeader:
    return run_header(shipped_settings(), shipped_model(), SEED, "test", 1)


def embedded() -> LockstepAntenna:
    return LockstepAntenna(shipped_settings(), shipped_model(), SEED)


class StopAt(Silent):
    """Stops the experiment when a step has been followed, before it is measured and its checkpoint written."""

    def __init__(self, step: str, stop: BaseException) -> None:
        self.step, self.stop = step, stop

    def at(self, step: str, advanced_s: float) -> None:
        if step == self.step:
            raise self.stop


def test_every_step_is_followed_in_order_and_the_teardown_comes_last(tmp_path: Path) -> None:
    antenna = ScriptedAntenna()
    outcome = run_experiment(waiting_experiment(), antenna, tmp_path, header())
    assert antenna.followed == ["one", "two", "three", *TEARDOWN]
    assert [row["step"] for row in outcome.rows] == ["one", "two", "three"]
    assert json.loads((tmp_path / "checkpoint.json").read_text())["done"] == 3


def test_the_checkpoint_goes_once_table_and_report_are_written(tmp_path: Path) -> None:
    write_results(run_experiment(waiting_experiment(), ScriptedAntenna(), tmp_path, header()), "nowhere")
    assert (tmp_path / "report.html").exists() and not list(tmp_path.glob("checkpoint*"))


def test_a_forced_run_leaves_nothing_of_the_one_before(tmp_path: Path) -> None:
    (tmp_path / "steps").mkdir()
    (tmp_path / "steps" / "0099.npz").write_bytes(b"")
    run_experiment(waiting_experiment(), ScriptedAntenna(), tmp_path, header(), force=True)
    assert not (tmp_path / "steps").exists()


@pytest.mark.parametrize("stop", [KeyboardInterrupt(), SafetyStopError("a guard"), RuntimeError("anything else")])
def test_the_teardown_comes_however_the_experiment_ends(tmp_path: Path, stop: BaseException) -> None:
    antenna = ScriptedAntenna({"two": stop})
    with pytest.raises(type(stop)):
        run_experiment(waiting_experiment(), antenna, tmp_path, header())
    assert antenna.followed == ["one", "two", *TEARDOWN]
    assert open_run(tmp_path).record.end is not None


def test_a_teardown_that_fails_too_is_noted_and_does_not_hide_why_it_was_needed(tmp_path: Path) -> None:
    antenna = ScriptedAntenna({"two": KeyboardInterrupt(), TEARDOWN[0]: SafetyStopError("stuck")})
    with pytest.raises(KeyboardInterrupt):
        run_experiment(waiting_experiment(), antenna, tmp_path, header())
    notes = [event.text for event in open_run(tmp_path).events if event.kind is EventKind.NOTE]
    assert any("teardown: " in note and "stuck" in note for note in notes)


def test_an_antenna_that_went_with_the_interruption_does_not_hide_it(tmp_path: Path) -> None:
    class Gone(ScriptedAntenna):
        @property
        def tick(self) -> int:
            if "two" in self.followed:
                raise LinkError("the daemon has gone")
            return self._at

        @tick.setter
        def tick(self, at: int) -> None:
            self._at = at

    with pytest.raises(KeyboardInterrupt):
        run_experiment(waiting_experiment(), Gone({"two": KeyboardInterrupt()}), tmp_path, header())
    noted = [event for event in open_run(tmp_path).events if event.text == "teardown: the daemon has gone"]
    assert [event.tick for event in noted] == [55]


def test_a_step_whose_guard_is_already_violated_is_not_entered(tmp_path: Path) -> None:
    experiment = waiting_experiment()
    first = experiment.steps[0]
    guarded = replace(first.segment, inner=replace(first.segment.inner, guard=Guard(-0.1, 0.1)))
    experiment = replace(experiment, steps=(replace(first, segment=guarded), *experiment.steps[1:]))
    antenna = ScriptedAntenna(position=0.5)
    with pytest.raises(SafetyStopError, match=r"'one': inner stands at 0\.5000 rad"):
        run_experiment(experiment, antenna, tmp_path, header())
    assert antenna.followed == TEARDOWN


def test_a_checkpoint_of_another_plan_is_refused(tmp_path: Path) -> None:
    with pytest.raises(KeyboardInterrupt):
        run_experiment(waiting_experiment(), ScriptedAntenna({"two": KeyboardInterrupt()}), tmp_path, header())
    with pytest.raises(BadInputError, match="another plan"):
        run_experiment(waiting_experiment(("one", "four")), ScriptedAntenna(), tmp_path, header(), resume=True)


def test_a_folder_without_a_checkpoint_cannot_be_resumed(tmp_path: Path) -> None:
    with pytest.raises(BadInputError, match="no such file"):
        run_experiment(waiting_experiment(), ScriptedAntenna(), tmp_path / "nothing", header(), resume=True)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Outcome:
    """The small sequence without a stop."""
    return run_experiment(small_sequence(), embedded(), tmp_path_factory.mktemp("whole"), header())


def same_end(outcome: Outcome, whole: Outcome) -> None:
    assert table_csv(outcome.rows) == table_csv(whole.rows)
    assert open_run(outcome.folder).content_hashes() == open_run(whole.folder).content_hashes()
    assert read_events(outcome.folder) == read_events(whole.folder)


def read_events(folder: Path) -> list[dict[str, object]]:
    return [json.loads(line) for line in (folder / "events.jsonl").read_text().splitlines()]


@pytest.mark.parametrize("stopped_in", range(1, len(small_sequence().steps)))
def test_a_sequence_stopped_after_any_checkpoint_goes_on_to_the_same_table_and_the_same_log(
    tmp_path: Path, whole: Outcome, stopped_in: int
) -> None:
    experiment = small_sequence()
    stop = StopAt(experiment.steps[stopped_in].name, KeyboardInterrupt())
    with pytest.raises(KeyboardInterrupt):
        run_experiment(experiment, embedded(), tmp_path, header(), progress=stop)
    same_end(run_experiment(experiment, embedded(), tmp_path, header(), resume=True), whole)


def test_a_sequence_that_was_killed_goes_on_to_the_same_table_and_the_same_log(tmp_path: Path, whole: Outcome) -> None:
    killed = subprocess.run([sys.executable, "-m", "tests.experiments.test_runner", str(tmp_path)], check=False)
    assert killed.returncode == -signal.SIGKILL
    assert open_run(tmp_path).record.end is None
    same_end(run_experiment(small_sequence(), embedded(), tmp_path, header(), resume=True), whole)


class KilledIn(Silent):
    """Ends the process the hard way while a step is being followed."""

    def __init__(self, step: str) -> None:
        self.step = step

    def at(self, step: str, advanced_s: float) -> None:
        if step == self.step:
            os.kill(os.getpid(), signal.SIGKILL)


def run_until_killed(folder: Path, experiment: Experiment) -> None:
    run_experiment(experiment, embedded(), folder, header(), progress=KilledIn(experiment.steps[3].name))


@pytest.mark.heavy
@pytest.mark.parametrize("name", ["sliding", "presliding"])
def test_a_short_sequence_killed_in_every_one_of_its_steps_comes_to_the_same_end(tmp_path: Path, name: str) -> None:
    experiment = build_experiment(
        name, SequenceOptions(1000.0, short=True, breakaway_nm=breakaway_torques(shipped_model()))
    )
    whole = run_experiment(experiment, embedded(), tmp_path / "whole", header())
    folder = tmp_path / "killed"
    for number, step in enumerate(experiment.steps):
        process = get_context("fork").Process(target=_killed_in, args=(experiment, folder, step.name, number > 0))
        process.start()
        process.join()
        assert process.exitcode == -signal.SIGKILL
    same_end(run_experiment(experiment, embedded(), folder, header(), resume=True), whole)


def _killed_in(experiment: Experiment, folder: Path, step: str, resume: bool) -> None:
    # killed before the first step ends there is no checkpoint yet: then the run begins anew
    resume = resume and (folder / "checkpoint.json").exists()
    run_experiment(experiment, embedded(), folder, header(), resume=resume, force=True, progress=KilledIn(step))


if __name__ == "__main__":
    run_until_killed(Path(sys.argv[1]), small_sequence())
